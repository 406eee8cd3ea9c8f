//! The parts of the robot when its power comes up.

use amiro_ipf::board::offsets::{OffsetOrigin, Offsets, STORE_BYTES};
use amiro_ipf::board::proximity_sensor::DEFAULT_OFFSET;
use amiro_ipf::model::{SENSORS, SensorMask};

use crate::bus::{RobotBuses, Vcnl4020Fault, on_sensor};

/// Raw counts of the robot's sensors with nothing in range; its memory holds them.
///
/// Those of a robot on a table, as published.
pub const OFFSETS: [u16; SENSORS] = [2469, 2412, 2381, 2491, 2488, 2449, 2413, 2320];

/// The robot's buses with these sensors plugged in and the offsets in the memory.
pub(super) fn buses(plugged: SensorMask) -> RobotBuses {
    let mut buses = RobotBuses::default();
    for sensor in 0..SENSORS {
        // Until the first measurement is known: nothing in range.
        buses.set_signal(
            sensor,
            OFFSETS.get(sensor).copied().unwrap_or(DEFAULT_OFFSET),
        );
        if !plugged.contains(sensor) {
            let unplugged = on_sensor(sensor, Vcnl4020Fault::Unplugged);
            buses.bus_of_mut(sensor).script.from_time(0, unplugged);
        }
    }
    let offsets = Offsets {
        counts: OFFSETS,
        origin: OffsetOrigin::Stored,
    };
    let mut bytes = [0; STORE_BYTES];
    offsets.encode(&mut bytes);
    if let Some(memory) = &mut buses.two.parts_mut().memory {
        for (place, byte) in memory.bytes_mut().iter_mut().zip(bytes) {
            *place = byte;
        }
    }
    buses
}
