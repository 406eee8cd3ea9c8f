//! The faults of a robot's two I2C buses, byte by byte.

use core::ops::{Range, RangeInclusive};

use amiro_ipf::board::acquisition::{Bus, ROUND_US};

use crate::bus::{
    InjectedBusFault, MuxFault, Outages, Random, RobotBuses, Script, Vcnl4020Fault, on_sensor,
};
use crate::faults::{ActiveFault, ActiveFaults, Component, Kind};

/// Time slot of a loose contact: one round.
const SLOT_NS: u64 = ROUND_US * 1_000;
/// Distances of disturbed bytes, and of a multiplexer's jumps.
const DISTURBED: RangeInclusive<u32> = 1..=39;
const JUMPS: RangeInclusive<u32> = 1..=199;

impl ActiveFaults {
    /// Writes the faults of the buses into their scripts.
    ///
    /// The drive begins at `starts_us` of the buses' own time. A fault at its begin is
    /// active since the power came up.
    pub fn script(&self, buses: &mut RobotBuses, starts_us: u64) {
        let at_ns = |drive_us: u64| drive_us.saturating_add(starts_us).saturating_mul(1_000);
        for (place, fault) in self.iter().enumerate() {
            let Range { start, end } = fault.when_us;
            let from_ns = if start == 0 { 0 } else { at_ns(start) };
            // Two loose contacts fail at different times.
            let seed = self.seed().wrapping_add(1 + place as u64).rotate_left(32);
            script(buses, fault, from_ns..at_ns(end), seed);
        }
    }
}

fn script(buses: &mut RobotBuses, fault: &ActiveFault, when_ns: Range<u64>, seed: u64) {
    match (fault.component, fault.kind) {
        (Component::Sensor(sensor), Kind::Off) => {
            let script = &mut buses.bus_of_mut(sensor).script;
            script.from_time(when_ns.start, on_sensor(sensor, Vcnl4020Fault::Unplugged));
            if when_ns.end < u64::MAX {
                script.from_time(when_ns.end, on_sensor(sensor, Vcnl4020Fault::PluggedIn));
            }
        }
        (Component::Sensor(sensor), Kind::Intermittent(share)) => {
            let outages = Outages::new(SLOT_NS, share, seed);
            let script = &mut buses.bus_of_mut(sensor).script;
            let deaf = on_sensor(sensor, Vcnl4020Fault::Deaf);
            script.now_and_then(when_ns.start, when_ns.end, outages, deaf);
        }
        (Component::Bus(bus), kind) => script_bus(script_of(buses, bus), when_ns, kind, seed),
        (Component::Mux(bus), kind) => script_mux(script_of(buses, bus), when_ns, kind, seed),
        _ => {}
    }
}

fn script_of(buses: &mut RobotBuses, bus: Bus) -> &mut Script {
    match bus {
        Bus::I2c1 => &mut buses.one.script,
        Bus::I2c2 => &mut buses.two.script,
    }
}

fn script_bus(script: &mut Script, when_ns: Range<u64>, kind: Kind, seed: u64) {
    let Range { start, end } = when_ns;
    match kind {
        Kind::Off => script.between(start, end, InjectedBusFault::NoAcknowledge),
        Kind::Stuck => {
            let for_ns = match end {
                u64::MAX => u64::MAX,
                end => end - start,
            };
            script.from_time(start, InjectedBusFault::SclLow { for_ns });
        }
        Kind::Garbage => {
            let kinds = vec![
                InjectedBusFault::NoAcknowledge,
                InjectedBusFault::ArbitrationLost,
                InjectedBusFault::SdaLow { clocks: 4 },
            ];
            script.at_random_between(start, end, Random::new(kinds, DISTURBED, seed));
        }
        Kind::Intermittent(share) => {
            let outages = Outages::new(SLOT_NS, share, seed);
            script.now_and_then(start, end, outages, InjectedBusFault::NoAcknowledge);
        }
        _ => {}
    }
}

fn script_mux(script: &mut Script, when_ns: Range<u64>, kind: Kind, seed: u64) {
    let Range { start, end } = when_ns;
    match kind {
        Kind::Off => {
            script.between(start, end, InjectedBusFault::Mux(MuxFault::Reset));
            script.between(start, end, InjectedBusFault::Mux(MuxFault::Deaf));
        }
        Kind::Stuck => script.between(start, end, InjectedBusFault::Mux(MuxFault::WriteLost)),
        Kind::Garbage => {
            let kinds = (0..4).map(|channel| InjectedBusFault::Mux(MuxFault::Jump(channel)));
            let random = Random::new(kinds.collect(), JUMPS, seed);
            script.at_random_between(start, end, random);
        }
        Kind::Intermittent(share) => {
            let outages = Outages::new(SLOT_NS, share, seed);
            script.now_and_then(start, end, outages, InjectedBusFault::Mux(MuxFault::Deaf));
        }
        _ => {}
    }
}
