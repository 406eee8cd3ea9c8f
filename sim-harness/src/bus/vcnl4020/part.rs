//! The part: its answers on the bus, and its measurements.

use super::optical_input::OpticalInput;
use super::registers::{PROXIMITY_NS, Registers, Timing};
use crate::bus::{Device, InjectedBusFault, Vcnl4020Fault};

/// The only address there is.
const ADDRESS: u8 = 0x13;

/// State of the transfer with the master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum RegisterTransfer {
    /// Nothing.
    #[default]
    Idle,
    /// The next byte is a register's number.
    Register,
    /// The next byte is for the register.
    Write,
    /// The master reads the next byte.
    Read,
}

/// The sensor.
///
/// Periodic measurements run by the part's own clock, independently of the bus.
/// Results are not latched by default: a measurement that ends between the two halves of a
/// read gives one half of each. A result is there when its measurement ends; its ready bit
/// is cleared by reading either half. Beyond the last register, reads give zeros and
/// written bytes are acknowledged and ignored.
#[derive(Clone, Debug)]
pub struct Vcnl4020Model {
    registers: Registers,
    /// The register that the next byte goes to or comes from.
    pointer: u8,
    transfer: RegisterTransfer,
    plugged: bool,
    /// It misses a start at this time.
    deaf_at_ns: Option<u64>,
    latches: bool,
    /// The lower half that belongs to an upper half that was read, if the part latches.
    latched: Option<u8>,
    timing: Timing,
    optical_input: OpticalInput,
}

impl Default for Vcnl4020Model {
    fn default() -> Self {
        Self {
            registers: Registers::at_power_up(),
            pointer: 0,
            transfer: RegisterTransfer::Idle,
            plugged: true,
            deaf_at_ns: None,
            latches: false,
            latched: None,
            timing: Timing {
                phase_ns: PROXIMITY_NS,
                error_ppm: 0,
            },
            optical_input: OpticalInput::default(),
        }
    }
}

impl Vcnl4020Model {
    /// A sensor that keeps a result's lower half when its upper half is read.
    #[must_use]
    pub fn latching(self) -> Self {
        Self {
            latches: true,
            ..self
        }
    }

    /// Sets how long after periodic proximity is switched on the first result comes.
    pub fn set_phase(&mut self, phase_ns: u64) {
        self.timing.phase_ns = phase_ns;
    }

    /// Makes its clock slower by so many millionths; holds from the next switching on.
    pub fn set_clock_error(&mut self, ppm: i32) {
        self.timing.error_ppm = ppm;
    }

    /// Makes it another part, with another identity in register 0x81.
    pub fn set_identity(&mut self, identity: u8) {
        self.registers.identity = identity;
    }

    /// Sets when the periodic proximity measurement under way ends; the others follow by
    /// their periods.
    pub fn measure_next_at(&mut self, at_ns: u64) {
        self.registers.measure_proximity_at(at_ns);
    }

    /// When the periodic proximity measurement under way ends; `None` without one.
    #[must_use]
    pub fn measures_at_ns(&self) -> Option<u64> {
        self.registers.measures_proximity_at_ns()
    }

    /// Sets the result of proximity measurements from now on, in counts.
    ///
    /// On a bus, time must be advanced first: see
    /// [`FakeBus::parts_mut`](crate::bus::FakeBus::parts_mut).
    pub fn set_signal(&mut self, raw: u16) {
        self.optical_input.set_signal(raw);
    }

    /// Sets the results of the next proximity measurements in order; the last stays.
    pub fn queue_signals(&mut self, raw: impl IntoIterator<Item = u16>) {
        self.optical_input.queue_signals(raw);
    }

    /// Sets the result of ambient measurements from now on, in counts.
    pub fn set_ambient(&mut self, raw: u16) {
        self.optical_input.ambient = raw;
    }

    /// A register's content, without the effects of a read.
    #[must_use]
    pub fn register(&self, register: u8) -> u8 {
        self.registers.get(register)
    }

    /// Reads a register, with the effects of a read.
    fn take(&mut self, register: u8) -> u8 {
        let latches_now = self.latches && matches!(register, 0x85 | 0x87);
        let lower = latches_now.then(|| self.registers.get(register + 1));
        let value = self.registers.take(register);
        match core::mem::replace(&mut self.latched, lower) {
            Some(latched) if matches!(register, 0x86 | 0x88) => latched,
            _ => value,
        }
    }

    fn next_register(&mut self) -> u8 {
        let register = self.pointer;
        self.pointer = register.wrapping_add(1);
        register
    }

    fn power_up(&mut self) {
        let identity = self.registers.identity;
        self.registers = Registers::at_power_up();
        self.registers.identity = identity;
        self.pointer = 0;
        self.transfer = RegisterTransfer::Idle;
    }
}

impl Device for Vcnl4020Model {
    fn start(&mut self, address: u8, read: bool, now_ns: u64) -> bool {
        self.pass(now_ns);
        self.latched = None;
        let is_addressed = self.plugged && self.deaf_at_ns != Some(now_ns);
        self.transfer = match (is_addressed && address == ADDRESS, read) {
            (false, _) => RegisterTransfer::Idle,
            (true, false) => RegisterTransfer::Register,
            (true, true) => RegisterTransfer::Read,
        };
        self.transfer != RegisterTransfer::Idle
    }

    fn write(&mut self, byte: u8, now_ns: u64) -> bool {
        self.pass(now_ns);
        match self.transfer {
            RegisterTransfer::Idle | RegisterTransfer::Read => return false,
            RegisterTransfer::Register => {
                self.pointer = byte;
                self.transfer = RegisterTransfer::Write;
            }
            RegisterTransfer::Write => {
                let register = self.next_register();
                self.registers.set(register, byte, self.timing, now_ns);
            }
        }
        true
    }

    fn read(&mut self, now_ns: u64) -> u8 {
        self.pass(now_ns);
        if self.transfer != RegisterTransfer::Read {
            return 0xff;
        }
        let register = self.next_register();
        self.take(register)
    }

    fn stop(&mut self, now_ns: u64) {
        self.pass(now_ns);
        self.transfer = RegisterTransfer::Idle;
    }

    fn pass(&mut self, now_ns: u64) {
        self.registers.pass(&mut self.optical_input, now_ns);
    }

    fn interrupts(&self) -> bool {
        self.plugged && self.registers.interrupts()
    }

    fn inject(&mut self, fault: InjectedBusFault, now_ns: u64) -> bool {
        let InjectedBusFault::Sensor { fault, .. } = fault else {
            return false;
        };
        self.pass(now_ns);
        if fault == Vcnl4020Fault::Measures {
            return self
                .registers
                .end_proximity(&mut self.optical_input, now_ns);
        }
        if fault == Vcnl4020Fault::Deaf {
            self.deaf_at_ns = Some(now_ns);
            return self.plugged;
        }
        let was_plugged = self.plugged;
        self.plugged = match fault {
            Vcnl4020Fault::Unplugged => false,
            Vcnl4020Fault::PluggedIn => true,
            Vcnl4020Fault::Reset | Vcnl4020Fault::Measures | Vcnl4020Fault::Deaf => was_plugged,
        };
        let struck = fault == Vcnl4020Fault::Reset && was_plugged || self.plugged != was_plugged;
        if struck {
            self.power_up();
        }
        struck
    }
}

#[cfg(test)]
mod tests {
    use super::super::registers::AMBIENT_NS;
    use super::*;

    const MS: u64 = 1_000_000;

    fn write(sensor: &mut Vcnl4020Model, bytes: &[u8], now_ns: u64) {
        assert!(sensor.start(ADDRESS, false, now_ns));
        assert!(bytes.iter().all(|byte| sensor.write(*byte, now_ns)));
        sensor.stop(now_ns);
    }

    fn read<const BYTES: usize>(
        sensor: &mut Vcnl4020Model,
        register: u8,
        now_ns: u64,
    ) -> [u8; BYTES] {
        assert!(sensor.start(ADDRESS, false, now_ns) && sensor.write(register, now_ns));
        assert!(sensor.start(ADDRESS, true, now_ns));
        let bytes = core::array::from_fn(|_| sensor.read(now_ns));
        sensor.stop(now_ns);
        bytes
    }

    /// Measures proximity 125 times a second, first at 1 ms.
    fn measuring() -> Vcnl4020Model {
        let mut sensor = Vcnl4020Model::default();
        sensor.set_phase(MS);
        write(&mut sensor, &[0x82, 0x06], 0);
        write(&mut sensor, &[0x80, 0x03], 0);
        sensor
    }

    #[test]
    fn registers_after_power_up_are_those_of_the_sheet() {
        let mut sensor = Vcnl4020Model::default();
        assert_eq!(
            read::<18>(&mut sensor, 0x80, 0),
            [
                0x80, 0x21, 0x00, 0x02, 0x1d, 0, 0, 0, 0, 0x00, 0, 0, 0, 0, 0x00, 0x01, 0x00, 0x00
            ]
        );
    }

    #[test]
    fn only_bits_that_can_be_written_are() {
        let mut sensor = Vcnl4020Model::default();
        let mut all_ones = vec![0x80];
        all_ones.resize(18, 0xff);
        // Register 0x80 first: self-timed, so that no rate takes its ones.
        write(&mut sensor, &all_ones, 0);
        assert_eq!(
            read::<17>(&mut sensor, 0x80, 0),
            [
                0x87, 0x21, 0x00, 0x3f, 0x9f, 0, 0, 0, 0, 0xef, 255, 255, 255, 255, 0x00, 0xff, 0
            ]
        );
        write(&mut sensor, &[0x80, 0x00, 0xff, 0xff, 0xff, 0xff], 0);
        assert_eq!(read(&mut sensor, 0x80, 0), [0x80, 0x21, 0x07, 0x3f, 0xff]);
    }

    #[test]
    fn the_register_number_survives_a_stop_and_counts_on() {
        let mut sensor = Vcnl4020Model::default();
        write(&mut sensor, &[0x81], 0);
        assert!(sensor.start(ADDRESS, true, 0));
        assert_eq!(sensor.read(0), 0x21);
        sensor.stop(0);
        assert!(sensor.start(ADDRESS, true, 0));
        assert_eq!((sensor.read(0), sensor.read(0)), (0x00, 0x02));
    }

    #[test]
    fn another_address_is_not_acknowledged() {
        let mut sensor = Vcnl4020Model::default();
        assert!(!sensor.start(0x14, false, 0));
        assert!(!sensor.write(0x83, 0));
        assert_eq!(sensor.read(0), 0xff);
        assert!(sensor.start(ADDRESS, true, 0));
        sensor.stop(0);
        assert_eq!(sensor.read(0), 0xff, "after a stop");
    }

    #[test]
    fn each_rate_matches_the_data_sheet() {
        for (rate, in_1024_ms) in [(0, 2), (1, 4), (2, 8), (3, 16), (4, 32), (5, 64), (7, 256)] {
            let mut sensor = Vcnl4020Model::default();
            sensor.queue_signals(1..=300);
            sensor.set_phase(MS);
            write(&mut sensor, &[0x82, rate], 0);
            write(&mut sensor, &[0x80, 0x03], 0);
            let [high, low] = read(&mut sensor, 0x87, 1024 * MS);
            assert_eq!(u16::from_be_bytes([high, low]), in_1024_ms, "rate {rate}");
        }
    }

    #[test]
    fn results_come_by_the_sensors_own_clock() {
        let mut sensor = Vcnl4020Model::default();
        sensor.set_phase(3 * MS);
        sensor.set_clock_error(100_000);
        sensor.queue_signals([7, 8, 9]);
        write(&mut sensor, &[0x82, 0x06], 5 * MS);
        write(&mut sensor, &[0x80, 0x03], 5 * MS);
        // 8 ms and a tenth more after 8 ms.
        for (now_ns, expected) in [
            (8 * MS - 1, 0),
            (8 * MS, 7),
            (16_800_000 - 1, 7),
            (16_800_000, 8),
            (25_600_000, 9),
            (900 * MS, 9),
        ] {
            sensor.pass(now_ns);
            assert_eq!(sensor.register(0x88), expected, "{now_ns} ns");
        }
    }

    #[test]
    fn a_result_is_ready_until_either_half_is_read() {
        let mut sensor = measuring();
        sensor.set_ambient(0x0102);
        assert_eq!(read(&mut sensor, 0x80, MS - 1), [0x83]);
        for half in [0x87, 0x88] {
            sensor.inject(measures(), MS);
            assert_eq!(
                read(&mut sensor, 0x80, MS),
                [0xa3],
                "reading the bit keeps it"
            );
            assert_eq!(read(&mut sensor, 0x80, MS), [0xa3]);
            let [_] = read(&mut sensor, half, MS);
            assert_eq!(read(&mut sensor, 0x80, MS), [0x83], "{half:#x}");
        }
        // Ambient has its own bit.
        write(&mut sensor, &[0x80, 0x07], 2 * MS);
        assert_eq!(read(&mut sensor, 0x80, 8 * MS + AMBIENT_NS), [0xe7]);
        assert_eq!(read(&mut sensor, 0x85, 8 * MS + AMBIENT_NS), [1, 2]);
        assert_eq!(read(&mut sensor, 0x80, 8 * MS + AMBIENT_NS), [0xa7]);
    }

    fn measures() -> InjectedBusFault {
        InjectedBusFault::Sensor {
            channel: 0,
            fault: Vcnl4020Fault::Measures,
        }
    }

    /// Both halves, with a measurement between them; before it `0x01ff`, then `0x0200`.
    fn read_across_an_update(mut sensor: Vcnl4020Model) -> u16 {
        sensor.queue_signals([0x01ff, 0x0200]);
        assert_eq!(read(&mut sensor, 0x87, 8 * MS), [0x01, 0xff]);
        assert!(sensor.start(ADDRESS, false, 8 * MS) && sensor.write(0x87, 8 * MS));
        assert!(sensor.start(ADDRESS, true, 8 * MS));
        let halves = [sensor.read(9 * MS - 1), sensor.read(9 * MS)];
        sensor.stop(9 * MS);
        u16::from_be_bytes(halves)
    }

    #[test]
    fn a_measurement_between_the_halves_tears_the_result() {
        assert_eq!(read_across_an_update(measuring()), 0x0100);
        assert_eq!(read_across_an_update(measuring().latching()), 0x01ff);
    }

    #[test]
    fn rates_cannot_be_changed_while_it_measures_by_itself() {
        let mut sensor = measuring();
        write(&mut sensor, &[0x82, 0x02, 0x14, 0x7d], 0);
        assert_eq!(read(&mut sensor, 0x82, 0), [0x06, 0x14, 0x1d]);
        write(&mut sensor, &[0x80, 0x00, 0x00, 0x02, 0x14, 0x7d], 0);
        assert_eq!(read(&mut sensor, 0x82, 0), [0x02, 0x14, 0x7d]);
    }

    #[test]
    fn the_same_command_again_does_not_disturb_the_cadence() {
        let mut sensor = measuring();
        sensor.queue_signals(1..=9);
        write(&mut sensor, &[0x80, 0x03], 4 * MS);
        assert_eq!(read(&mut sensor, 0x87, 9 * MS - 1), [0, 1]);
        assert_eq!(read(&mut sensor, 0x87, 9 * MS), [0, 2]);
        write(&mut sensor, &[0x80, 0x01], 10 * MS);
        assert_eq!(
            read(&mut sensor, 0x87, 80 * MS),
            [0, 2],
            "without proximity"
        );
    }

    #[test]
    fn a_measurement_that_is_moved_moves_those_after_it() {
        let mut sensor = measuring();
        sensor.queue_signals(1..=9);
        sensor.pass(MS);
        sensor.measure_next_at(14 * MS);
        for (now_ns, expected) in [
            (14 * MS - 1, 1),
            (14 * MS, 2),
            (22 * MS - 1, 2),
            (22 * MS, 3),
        ] {
            sensor.pass(now_ns);
            assert_eq!(sensor.register(0x88), expected, "{now_ns} ns");
        }
        let mut idle = Vcnl4020Model::default();
        idle.measure_next_at(MS);
        assert_eq!(read(&mut idle, 0x80, 2 * MS), [0x80]);
    }

    #[test]
    fn another_part_keeps_its_identity_after_a_reset() {
        let mut sensor = Vcnl4020Model::default();
        sensor.set_identity(0x32);
        let fault = Vcnl4020Fault::Reset;
        assert!(sensor.inject(InjectedBusFault::Sensor { channel: 0, fault }, 0));
        assert_eq!(read(&mut sensor, 0x81, 0), [0x32]);
    }

    #[test]
    fn a_measurement_on_demand_happens_once_and_not_beside_periodic_ones() {
        let mut sensor = Vcnl4020Model::default();
        sensor.queue_signals([41, 42]);
        sensor.set_ambient(9);
        write(&mut sensor, &[0x80, 0x18], 0);
        assert_eq!(read(&mut sensor, 0x80, PROXIMITY_NS - 1), [0x98]);
        assert_eq!(read(&mut sensor, 0x80, PROXIMITY_NS), [0xb0]);
        assert_eq!(read(&mut sensor, 0x80, AMBIENT_NS), [0xe0]);
        assert_eq!(read(&mut sensor, 0x85, AMBIENT_NS), [0, 9, 0, 41]);
        assert_eq!(read(&mut sensor, 0x85, 9 * AMBIENT_NS), [0, 9, 0, 41]);
        let mut sensor = measuring();
        write(&mut sensor, &[0x80, 0x0b], 0);
        assert_eq!(read(&mut sensor, 0x80, 0), [0x83]);
    }

    #[test]
    fn the_interrupt_line_is_up_until_its_bit_is_written() {
        let mut sensor = measuring();
        // Every proximity result.
        write(&mut sensor, &[0x89, 0x08], 0);
        assert!(!sensor.interrupts());
        sensor.pass(MS);
        assert!(sensor.interrupts());
        assert_eq!(read(&mut sensor, 0x8e, MS), [0x08]);
        write(&mut sensor, &[0x8e, 0x07], MS);
        assert!(sensor.interrupts(), "other bits");
        write(&mut sensor, &[0x8e, 0x08], MS);
        assert!(!sensor.interrupts());
        // Twice above 0x0102.
        write(&mut sensor, &[0x89, 0x22, 0, 0, 0x01, 0x02], MS);
        sensor.queue_signals([0x0103, 0x0103]);
        sensor.pass(9 * MS);
        assert!(!sensor.interrupts());
        sensor.pass(17 * MS);
        assert_eq!(read(&mut sensor, 0x8e, 17 * MS), [0x01]);
    }

    #[test]
    fn a_sensor_whose_supply_failed_is_as_after_power_up() {
        let strike = |sensor: &mut Vcnl4020Model, fault| {
            sensor.inject(InjectedBusFault::Sensor { channel: 2, fault }, 20 * MS)
        };
        let mut sensor = measuring();
        sensor.set_signal(300);
        sensor.pass(10 * MS);
        assert!(strike(&mut sensor, Vcnl4020Fault::Reset));
        assert_eq!(read(&mut sensor, 0x80, 90 * MS), [0x80, 0x21, 0, 0x02]);
        assert_eq!(read(&mut sensor, 0x87, 90 * MS), [0, 0]);
        assert!(!strike(&mut sensor, Vcnl4020Fault::Measures), "it is idle");
        assert!(strike(&mut sensor, Vcnl4020Fault::Unplugged));
        assert!(
            !strike(&mut sensor, Vcnl4020Fault::Unplugged),
            "already out"
        );
        assert!(
            !strike(&mut sensor, Vcnl4020Fault::Reset),
            "of what is not there"
        );
        assert!(!sensor.start(ADDRESS, true, 90 * MS));
        assert!(strike(&mut sensor, Vcnl4020Fault::PluggedIn));
        assert!(sensor.start(ADDRESS, true, 90 * MS));
    }
}
