//! What is wrong with a robot, in a line.

use amiro_ipf::board::can::CanState;
use amiro_ipf::board::health::{BusState, Health};
use amiro_ipf::link::Status;

/// Everything that a health reports as not well, separated by commas; empty if all is.
#[must_use]
pub fn health_text(health: &Health) -> String {
    let sensors = (0..)
        .zip(&health.sensors)
        .filter(|(_, sensor)| !sensor.state.is_trusted())
        .map(|(index, sensor)| format!("sensor {index}: {:?}", sensor.state));
    let buses = (1..)
        .zip(&health.buses)
        .filter(|(_, bus)| bus.state != BusState::Working)
        .map(|(number, bus)| format!("I2C{number}: {:?}", bus.state));
    let can = match health.can.state {
        CanState::On => None,
        // A board whose controller does not answer goes from one to the other once a second.
        CanState::Absent | CanState::Joining => Some("CAN: Absent or Joining".to_owned()),
        CanState::BusOff => Some("CAN: BusOff".to_owned()),
    };
    let all: Vec<String> = sensors.chain(buses).chain(can).collect();
    all.join(", ")
}

/// The counters of a health that are not zero, by name.
#[must_use]
pub fn counters(health: &Health) -> Vec<(String, u32)> {
    let sensors = (0..).zip(&health.sensors).map(|(sensor, health)| {
        let name = format!("s{sensor} failed");
        (name, u32::from(health.failed))
    });
    let buses = (1..).zip(&health.buses).flat_map(|(number, bus)| {
        let named = |what, count| (format!("bus{number} {what}"), u32::from(count));
        [
            named("failed", bus.failed),
            named("recoveries", bus.recoveries),
        ]
    });
    let can = [
        ("ignored", health.can.ignored),
        ("overruns", health.can.overruns),
        ("bus_offs", health.can.bus_offs),
        ("unsent", health.can.unsent),
    ];
    let can = can
        .into_iter()
        .map(|(name, count)| (format!("can {name}"), u32::from(count)));
    let all = sensors.chain(buses).chain(can);
    all.filter(|(_, count)| *count > 0).collect()
}

/// The counters of a status that are not zero and should be, by name.
#[must_use]
pub fn status_counters(status: &Status) -> Vec<(String, u32)> {
    let (node, board) = (&status.node, &status.board);
    let all = [
        ("refused", node.refused),
        ("overruns", board.overruns),
        ("dropped_frames", board.dropped_frames),
        ("broken_frames", board.broken_frames),
        ("lost_bytes", board.lost_bytes),
    ];
    let named = all.map(|(name, count)| (name.to_owned(), count));
    named.into_iter().filter(|(_, count)| *count > 0).collect()
}

/// Counters in a line; `None` if there are none.
#[must_use]
pub fn counters_in_words(counters: &[(String, u32)]) -> Option<String> {
    let all: Vec<String> = counters
        .iter()
        .map(|(name, count)| format!("{name} {count}"))
        .collect();
    (!all.is_empty()).then(|| format!("at the end: {}", all.join(", ")))
}

#[cfg(test)]
mod tests {
    use amiro_ipf::board::health::SensorHealth;
    use amiro_ipf::board::sensor_state::{SensorFault, SensorState};

    use super::*;

    #[test]
    fn only_what_is_not_well_is_named() {
        let mut health = Health::default();
        for sensor in &mut health.sensors {
            sensor.state = SensorState::Good;
        }
        for bus in &mut health.buses {
            bus.state = BusState::Working;
        }
        health.can.state = CanState::On;
        assert_eq!(health_text(&health), "");
        health.sensors[3] = SensorHealth {
            state: SensorState::Faulty(SensorFault::Dazzled),
            ..SensorHealth::default()
        };
        health.buses[1].state = BusState::HeldLow;
        health.can.state = CanState::BusOff;
        assert_eq!(
            health_text(&health),
            "sensor 3: Faulty(Dazzled), I2C2: HeldLow, CAN: BusOff"
        );
    }
}
