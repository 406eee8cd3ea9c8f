//! The registers and the part's measurements.

use super::cadence::Cadence;
use super::optical_input::OpticalInput;
use super::thresholds::{Quantity, Thresholds};

/// Register 0x81: product 2, revision 1.
const ID: u8 = 0x21;
/// Period of proximity measurements at rate 7, 250 per second.
const SHORTEST_PERIOD_NS: u64 = 4_000_000;
/// Ambient measurements per second for the eight rates of register 0x84.
const AMBIENT_PER_S: [u64; 8] = [1, 2, 3, 4, 5, 6, 8, 10];
/// How long a proximity measurement takes. Assumed: the data sheet does not give it.
pub(super) const PROXIMITY_NS: u64 = 400_000;
/// How long an ambient measurement takes. Assumed as well.
pub(super) const AMBIENT_NS: u64 = 100_000_000;

/// Bits of the command register.
mod command {
    pub(super) const LOCK: u8 = 0x80;
    pub(super) const AMBIENT_READY: u8 = 0x40;
    pub(super) const PROXIMITY_READY: u8 = 0x20;
    pub(super) const AMBIENT_ONCE: u8 = 0x10;
    pub(super) const PROXIMITY_ONCE: u8 = 0x08;
    pub(super) const AMBIENT: u8 = 0x04;
    pub(super) const PROXIMITY: u8 = 0x02;
    pub(super) const SELF_TIMED: u8 = 0x01;
}

/// How the part's own clock runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing {
    /// From switching on periodic proximity to its first result.
    pub(super) phase_ns: u64,
    /// Error of the clock, slower than nominal, in millionths.
    pub(super) error_ppm: i32,
}

/// The register file, which is lost with the supply.
#[derive(Clone, Debug)]
pub(super) struct Registers {
    command: u8,
    pub(super) identity: u8,
    proximity_rate: u8,
    led_current: u8,
    ambient: u8,
    ambient_result: u16,
    proximity_result: u16,
    thresholds: Thresholds,
    modulator: u8,
    periodic_proximity: Option<Cadence>,
    periodic_ambient: Option<Cadence>,
    /// When measurements on demand end.
    single_proximity_ns: Option<u64>,
    single_ambient_ns: Option<u64>,
}

impl Registers {
    pub(super) fn at_power_up() -> Self {
        Self {
            command: command::LOCK,
            identity: ID,
            proximity_rate: 0,
            led_current: 0x02,
            ambient: 0x1d,
            ambient_result: 0,
            proximity_result: 0,
            thresholds: Thresholds::default(),
            modulator: 0x01,
            periodic_proximity: None,
            periodic_ambient: None,
            single_proximity_ns: None,
            single_ambient_ns: None,
        }
    }

    /// A register's content; 0 beyond the last one.
    pub(super) fn get(&self, register: u8) -> u8 {
        let [ambient_high, ambient_low] = self.ambient_result.to_be_bytes();
        let [proximity_high, proximity_low] = self.proximity_result.to_be_bytes();
        match register {
            0x80 => self.command,
            0x81 => self.identity,
            0x82 => self.proximity_rate,
            0x83 => self.led_current,
            0x84 => self.ambient,
            0x85 => ambient_high,
            0x86 => ambient_low,
            0x87 => proximity_high,
            0x88 => proximity_low,
            0x89 => self.thresholds.control,
            0x8a => half_of(self.thresholds.low, 0),
            0x8b => half_of(self.thresholds.low, 1),
            0x8c => half_of(self.thresholds.high, 0),
            0x8d => half_of(self.thresholds.high, 1),
            0x8e => self.thresholds.status,
            0x8f => self.modulator,
            _ => 0,
        }
    }

    /// A read by the bus, which clears a result's ready bit.
    pub(super) fn take(&mut self, register: u8) -> u8 {
        let value = self.get(register);
        match register {
            0x85 | 0x86 => self.command &= !command::AMBIENT_READY,
            0x87 | 0x88 => self.command &= !command::PROXIMITY_READY,
            _ => {}
        }
        value
    }

    /// A write by the bus to the writable bits.
    pub(super) fn set(&mut self, register: u8, value: u8, timing: Timing, now_ns: u64) {
        let self_timed = self.command & command::SELF_TIMED != 0;
        match register {
            0x80 => self.command(value, timing, now_ns),
            0x82 if !self_timed => self.proximity_rate = value & 0x07,
            0x83 => self.led_current = self.led_current & 0xc0 | value & 0x3f,
            0x84 if self.single_ambient_ns.is_some() => {}
            // Its rate is in bits 6 to 4.
            0x84 if self_timed => self.ambient = self.ambient & 0x70 | value & 0x8f,
            0x84 => self.ambient = value,
            0x89 => self.thresholds.control = value & 0xef,
            0x8a => set_half(&mut self.thresholds.low, 0, value),
            0x8b => set_half(&mut self.thresholds.low, 1, value),
            0x8c => set_half(&mut self.thresholds.high, 0, value),
            0x8d => set_half(&mut self.thresholds.high, 1, value),
            0x8e => self.thresholds.status &= !(value & 0x0f),
            0x8f => self.modulator = value,
            _ => {}
        }
    }

    fn command(&mut self, value: u8, timing: Timing, now_ns: u64) {
        let modes = command::SELF_TIMED | command::PROXIMITY | command::AMBIENT;
        self.command = self.command & !modes | value & modes;
        let asked = |bit| value & bit != 0;
        let self_timed = asked(command::SELF_TIMED);

        let proximity_ns = SHORTEST_PERIOD_NS << (7 - self.proximity_rate);
        self.periodic_proximity = (self_timed && asked(command::PROXIMITY)).then(|| {
            let first_ns = now_ns + timing.phase_ns;
            let new = Cadence::new(first_ns, proximity_ns, timing.error_ppm);
            self.periodic_proximity.unwrap_or(new)
        });
        let ambient_ns = 1_000_000_000 / AMBIENT_PER_S[usize::from(self.ambient >> 4 & 7)];
        self.periodic_ambient = (self_timed && asked(command::AMBIENT)).then(|| {
            let new = Cadence::new(now_ns + AMBIENT_NS, ambient_ns, timing.error_ppm);
            self.periodic_ambient.unwrap_or(new)
        });

        // There is nothing on demand beside periodic measurements.
        if self_timed {
            self.single_proximity_ns = None;
            self.single_ambient_ns = None;
        } else {
            if asked(command::PROXIMITY_ONCE) {
                self.single_proximity_ns
                    .get_or_insert(now_ns + PROXIMITY_NS);
            }
            if asked(command::AMBIENT_ONCE) {
                self.single_ambient_ns.get_or_insert(now_ns + AMBIENT_NS);
            }
        }
        self.show_single();
    }

    /// The bits of measurements on demand are set while those are under way.
    fn show_single(&mut self) {
        self.command &= !(command::PROXIMITY_ONCE | command::AMBIENT_ONCE);
        if self.single_proximity_ns.is_some() {
            self.command |= command::PROXIMITY_ONCE;
        }
        if self.single_ambient_ns.is_some() {
            self.command |= command::AMBIENT_ONCE;
        }
    }

    /// Ends the measurements that are over by now.
    pub(super) fn pass(&mut self, light: &mut OpticalInput, now_ns: u64) {
        while has_ended(&mut self.periodic_proximity, now_ns) {
            self.measure_proximity(light);
        }
        while has_ended(&mut self.periodic_ambient, now_ns) {
            self.measure_ambient(light);
        }
        let is_over = |end_ns: &mut u64| *end_ns <= now_ns;
        if self.single_proximity_ns.take_if(is_over).is_some() {
            self.show_single();
            self.measure_proximity(light);
        }
        if self.single_ambient_ns.take_if(is_over).is_some() {
            self.show_single();
            self.measure_ambient(light);
        }
    }

    /// Ends the periodic proximity measurement under way; whether there is one.
    pub(super) fn end_proximity(&mut self, light: &mut OpticalInput, now_ns: u64) -> bool {
        let Some(cadence) = &mut self.periodic_proximity else {
            return false;
        };
        cadence.end_at(now_ns);
        self.pass(light, now_ns);
        true
    }

    /// Sets when the periodic proximity measurement under way ends.
    pub(super) fn measure_proximity_at(&mut self, at_ns: u64) {
        if let Some(cadence) = &mut self.periodic_proximity {
            cadence.end_at(at_ns);
        }
    }

    /// When the periodic proximity measurement under way ends.
    pub(super) fn measures_proximity_at_ns(&self) -> Option<u64> {
        self.periodic_proximity.map(|cadence| cadence.next_ns())
    }

    fn measure_proximity(&mut self, light: &mut OpticalInput) {
        self.proximity_result = light.next_signal();
        self.command |= command::PROXIMITY_READY;
        self.thresholds
            .judge(Quantity::Proximity, self.proximity_result);
    }

    fn measure_ambient(&mut self, light: &OpticalInput) {
        self.ambient_result = light.ambient;
        self.command |= command::AMBIENT_READY;
        self.thresholds
            .judge(Quantity::Ambient, self.ambient_result);
    }

    /// Whether the interrupt pin is pulled.
    pub(super) const fn interrupts(&self) -> bool {
        self.thresholds.status != 0
    }
}

fn half_of(value: u16, half: usize) -> u8 {
    value.to_be_bytes()[half]
}

fn set_half(value: &mut u16, half: usize, byte: u8) {
    let mut bytes = value.to_be_bytes();
    bytes[half] = byte;
    *value = u16::from_be_bytes(bytes);
}

fn has_ended(cadence: &mut Option<Cadence>, now_ns: u64) -> bool {
    cadence.as_mut().is_some_and(|it| it.has_ended(now_ns))
}
