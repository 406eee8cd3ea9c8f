//! What is wrong with a robot, in a line.

use amiro_ipf::can::CanState;
use amiro_ipf::health::{BusState, Health};

/// Everything that a health reports as not well, separated by commas; empty if all is.
pub(super) fn ailments(health: &Health) -> String {
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

#[cfg(test)]
mod tests {
    use amiro_ipf::driver::{SensorFault, SensorState};
    use amiro_ipf::health::SensorHealth;

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
        assert_eq!(ailments(&health), "");
        health.sensors[3] = SensorHealth {
            state: SensorState::Faulty(SensorFault::Dazzled),
            ..SensorHealth::default()
        };
        health.buses[1].state = BusState::HeldLow;
        health.can.state = CanState::BusOff;
        assert_eq!(
            ailments(&health),
            "sensor 3: Faulty(Dazzled), I2C2: HeldLow, CAN: BusOff"
        );
    }
}
