//! What of a robot's faults happens on its two I2C buses, byte by byte.

use core::ops::Range;

use amiro_ipf::board::acquisition::{Bus, ROUND_US};

use super::{BusTrouble, MuxTrouble, RobotFaults, Trouble};
use crate::bus::{Fault, MuxFault, Outages, Random, RobotBuses, Script, SensorFault, on_sensor};

/// A loose contact fails for a round or does not.
const SLOT_NS: u64 = ROUND_US * 1_000;
/// Distances of disturbed bytes, and of a multiplexer's jumps.
const DISTURBED: core::ops::RangeInclusive<u32> = 1..=39;
const JUMPS: core::ops::RangeInclusive<u32> = 1..=199;

impl RobotFaults {
    /// Writes what happens on the buses into their scripts.
    ///
    /// The drive begins at `starts_us` of the buses' own time. What is broken when it
    /// begins has been so since the power came up.
    pub fn script(&self, buses: &mut RobotBuses, starts_us: u64) {
        let at_ns = |drive_us: u64| drive_us.saturating_add(starts_us).saturating_mul(1_000);
        for (place, (when_us, trouble)) in self.all().enumerate() {
            let from_ns = if when_us.start == 0 {
                0
            } else {
                at_ns(when_us.start)
            };
            // Two loose contacts are not loose at the same times.
            let seed = self.seed().wrapping_add(1 + place as u64).rotate_left(32);
            script(buses, from_ns..at_ns(when_us.end), trouble, seed);
        }
    }
}

fn script(buses: &mut RobotBuses, when_ns: Range<u64>, trouble: Trouble, seed: u64) {
    let Range { start, end } = when_ns;
    match trouble {
        Trouble::Unplugged { sensor } => {
            plug(buses, sensor, SensorFault::Unplugged, start);
            if end < u64::MAX {
                plug(buses, sensor, SensorFault::PluggedIn, end);
            }
        }
        Trouble::Loose { sensor, share } => {
            let outages = Outages::new(SLOT_NS, share, seed);
            let fault = on_sensor(sensor, SensorFault::Deaf);
            let script = &mut buses.bus_of_mut(sensor).script;
            script.now_and_then(start, end, outages, fault);
        }
        Trouble::Bus { bus, trouble } => {
            script_bus(script_of(buses, bus), start, end, trouble, seed);
        }
        Trouble::Mux { bus, trouble } => {
            script_mux(script_of(buses, bus), start, end, trouble, seed);
        }
        _ => {}
    }
}

fn script_of(buses: &mut RobotBuses, bus: Bus) -> &mut Script {
    match bus {
        Bus::I2c1 => &mut buses.one.script,
        Bus::I2c2 => &mut buses.two.script,
    }
}

fn script_bus(script: &mut Script, start: u64, end: u64, trouble: BusTrouble, seed: u64) {
    match trouble {
        BusTrouble::Off => script.between(start, end, Fault::NoAcknowledge),
        BusTrouble::HeldLow => {
            let for_ns = match end {
                u64::MAX => u64::MAX,
                end => end - start,
            };
            script.from_time(start, Fault::SclLow { for_ns });
        }
        BusTrouble::Disturbed => {
            let kinds = vec![
                Fault::NoAcknowledge,
                Fault::ArbitrationLost,
                Fault::SdaLow { clocks: 4 },
            ];
            script.at_random_between(start, end, Random::new(kinds, DISTURBED, seed));
        }
        BusTrouble::Loose { share } => {
            let outages = Outages::new(SLOT_NS, share, seed);
            script.now_and_then(start, end, outages, Fault::NoAcknowledge);
        }
    }
}

fn script_mux(script: &mut Script, start: u64, end: u64, trouble: MuxTrouble, seed: u64) {
    match trouble {
        MuxTrouble::Off => {
            script.between(start, end, Fault::Mux(MuxFault::Reset));
            script.between(start, end, Fault::Mux(MuxFault::Deaf));
        }
        MuxTrouble::Stuck => script.between(start, end, Fault::Mux(MuxFault::WriteLost)),
        MuxTrouble::Jumping => {
            let kinds = (0..4).map(|channel| Fault::Mux(MuxFault::Jump(channel)));
            let random = Random::new(kinds.collect(), JUMPS, seed);
            script.at_random_between(start, end, random);
        }
        MuxTrouble::Loose { share } => {
            let outages = Outages::new(SLOT_NS, share, seed);
            script.now_and_then(start, end, outages, Fault::Mux(MuxFault::Deaf));
        }
    }
}

/// Pulls a sensor's plug, or plugs it in, before the first byte from a time on.
pub(super) fn plug(buses: &mut RobotBuses, sensor: usize, fault: SensorFault, from_ns: u64) {
    let bus = buses.bus_of_mut(sensor);
    bus.script.from_time(from_ns, on_sensor(sensor, fault));
}
