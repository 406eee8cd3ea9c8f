//! Registers and the meaning of their bits.
//!
//! Source: Vishay documents 83476 (VCNL4020), 83462 (VCNL4010) and 84150 (VCNL3020),
//! section "Register Functions"; its numbers of the registers stand at each item. The
//! table of all registers with their values after a reset is in the
//! [crate's documentation](crate#registers).

/// Address on the bus, 7 bits; fixed in the part.
pub const ADDRESS: u8 = 0x13;

/// Value of the identity register (#1) of all three parts: product 2, revision 1.
///
/// The parts cannot be told apart by it.
pub const IDENTITY: u8 = 0x21;

/// Proximity count of a full register: the surface is too close to be measured.
pub const SATURATED: u16 = u16::MAX;

/// Illuminance of one count of an ambient light result, lux.
pub const LUX_PER_COUNT: f32 = 0.25;

/// Registers by address. A transfer of several bytes continues with the next register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Register {
    /// #0: state of the measurements, [`Command`].
    Command = 0x80,
    /// #1: product and revision, [`IDENTITY`].
    Identity = 0x81,
    /// #2: [`ProximityRate`].
    ProximityRate = 0x82,
    /// #3: [`LedCurrent`]. Bits 6 and 7 are read-only.
    LedCurrent = 0x83,
    /// #4: [`Ambient`]. Not in the VCNL3020.
    Ambient = 0x84,
    /// #5, high byte, and #6, low byte. Not in the VCNL3020.
    AmbientResult = 0x85,
    /// #7, high byte, and #8, low byte.
    ProximityResult = 0x87,
    /// #9: [`InterruptControl`].
    InterruptControl = 0x89,
    /// #10, high byte, and #11, low byte.
    LowThreshold = 0x8a,
    /// #12, high byte, and #13, low byte.
    HighThreshold = 0x8c,
    /// #14: [`InterruptStatus`].
    InterruptStatus = 0x8e,
    /// #15: frequency and dead time of the infrared pulses; Vishay advises to leave it.
    ModulatorTiming = 0x8f,
}

/// Command register (#0): measurements that are enabled, results that are ready.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command(pub u8);

impl Command {
    /// No measurement.
    pub const STOP: Self = Self(0);
    /// Self-timed measurements of ambient light and proximity.
    pub const SELF_TIMED: Self = Self(0b0000_0111);
    /// Self-timed measurements of proximity alone.
    pub const SELF_TIMED_PROXIMITY: Self = Self(0b0000_0011);
    /// One measurement of ambient light and one of proximity; ends self-timed measuring.
    pub const ON_DEMAND: Self = Self(0b0001_1000);
    /// One measurement of proximity; ends self-timed measuring.
    pub const ON_DEMAND_PROXIMITY: Self = Self(0b0000_1000);

    /// Whether there is an ambient light result that was not read yet.
    #[must_use]
    pub const fn ambient_ready(self) -> bool {
        self.0 & 1 << 6 != 0
    }

    /// Whether there is a proximity result that was not read yet.
    #[must_use]
    pub const fn proximity_ready(self) -> bool {
        self.0 & 1 << 5 != 0
    }

    /// Whether self-timed measuring is on. A sensor that was started and has it off was
    /// reset since.
    #[must_use]
    pub const fn is_self_timed(self) -> bool {
        self.0 & 1 != 0
    }
}

/// Rate of self-timed proximity measurements (#2), results per second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProximityRate {
    /// 1.953125 per second, the value after a reset.
    #[default]
    Hz1_95,
    /// 3.90625 per second.
    Hz3_9,
    /// 7.8125 per second.
    Hz7_8,
    /// 15.625 per second; the documents print 16.625, which is not twice the one before.
    Hz15_6,
    /// 31.25 per second.
    Hz31_25,
    /// 62.5 per second.
    Hz62_5,
    /// 125 per second.
    Hz125,
    /// 250 per second.
    Hz250,
}

impl ProximityRate {
    /// Value of the register.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self as u8
    }

    /// Time between two measurements, microseconds: 512 000 to 4000.
    #[must_use]
    pub const fn period_us(self) -> u32 {
        512_000 >> self.bits()
    }
}

/// Current of the infrared diode during a pulse (#3), 0 to 200 mA in steps of 10 mA.
///
/// A higher current gives a longer range, and warms the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LedCurrent(u8);

impl LedCurrent {
    /// Highest current, 200 mA.
    pub const MAX: Self = Self(20);

    /// A current in milliamperes, rounded down to a multiple of 10; `None` above 200.
    #[must_use]
    pub const fn from_milliamperes(current: u8) -> Option<Self> {
        if current > 200 {
            return None;
        }
        Some(Self(current / 10))
    }

    /// Value of the register.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }
}

/// 20 mA, the value after a reset.
impl Default for LedCurrent {
    fn default() -> Self {
        Self(2)
    }
}

/// Rate of self-timed ambient light measurements, results per second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(missing_docs, reason = "each name is its rate")]
pub enum AmbientRate {
    Hz1,
    Hz2,
    Hz3,
    Hz4,
    Hz5,
    Hz6,
    Hz8,
    Hz10,
}

/// Parameters of ambient light measurements (#4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ambient {
    /// Whether the conversions of a result follow each other at once, which is faster,
    /// or are spread over the period, which averages flicker out.
    pub continuous: bool,
    /// Results per second.
    pub rate: AmbientRate,
    /// Whether the sensor measures its own offset first and subtracts it.
    pub auto_offset: bool,
    /// Conversions per result, as a power of two: 0 to 7 for 1 to 128. More is slower
    /// and less noisy. Values above 7 count as 7.
    pub conversions_log2: u8,
}

impl Ambient {
    /// Value of the register.
    #[must_use]
    pub const fn bits(self) -> u8 {
        (self.continuous as u8) << 7
            | (self.rate as u8) << 4
            | (self.auto_offset as u8) << 3
            | at_most_7(self.conversions_log2)
    }
}

/// Values after a reset: 2 results per second of 32 conversions, with automatic offset.
impl Default for Ambient {
    fn default() -> Self {
        Self {
            continuous: false,
            rate: AmbientRate::Hz2,
            auto_offset: true,
            conversions_log2: 5,
        }
    }
}

/// Settings of self-timed measuring.
///
/// The default is the sensor's state after a reset, with both measurements on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Configuration {
    /// Proximity measurements per second.
    pub rate: ProximityRate,
    /// Current of the infrared diode.
    pub led: LedCurrent,
    /// Parameters of ambient light measurements; `None` for none, as on a VCNL3020.
    pub ambient: Option<Ambient>,
}

impl Configuration {
    /// Command that starts the measurements of this configuration.
    #[must_use]
    pub const fn command(&self) -> Command {
        match self.ambient {
            Some(_) => Command::SELF_TIMED,
            None => Command::SELF_TIMED_PROXIMITY,
        }
    }
}

impl Default for Configuration {
    fn default() -> Self {
        Self {
            rate: ProximityRate::default(),
            led: LedCurrent::default(),
            ambient: Some(Ambient::default()),
        }
    }
}

/// Result that is compared with the thresholds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Compared {
    /// The proximity result.
    Proximity,
    /// The ambient light result; not on a VCNL3020.
    Ambient,
}

/// Events that pull the interrupt pin low (#9); none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InterruptControl {
    /// Consecutive results beyond a threshold that make an event, as a power of two: 0
    /// to 7 for 1 to 128. Values above 7 count as 7.
    pub results_log2: u8,
    /// Whether each proximity result is an event.
    pub proximity_ready: bool,
    /// Whether each ambient light result is an event.
    pub ambient_ready: bool,
    /// Result whose leaving of the thresholds is an event; `None` for neither.
    pub thresholds: Option<Compared>,
}

impl InterruptControl {
    /// Value of the register.
    #[must_use]
    pub const fn bits(self) -> u8 {
        let thresholds = match self.thresholds {
            None => 0b00,
            Some(Compared::Proximity) => 0b10,
            Some(Compared::Ambient) => 0b11,
        };
        at_most_7(self.results_log2) << 5
            | (self.proximity_ready as u8) << 3
            | (self.ambient_ready as u8) << 2
            | thresholds
    }
}

/// Events that pull the interrupt pin low now (#14); writing a bit back clears its event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InterruptStatus(pub u8);

impl InterruptStatus {
    /// All four events.
    pub const ALL: Self = Self(0b1111);

    /// Whether there was a proximity result.
    #[must_use]
    pub const fn proximity_ready(self) -> bool {
        self.0 & 1 << 3 != 0
    }

    /// Whether there was an ambient light result.
    #[must_use]
    pub const fn ambient_ready(self) -> bool {
        self.0 & 1 << 2 != 0
    }

    /// Whether the compared result fell below the low threshold.
    #[must_use]
    pub const fn below_low(self) -> bool {
        self.0 & 1 << 1 != 0
    }

    /// Whether the compared result rose above the high threshold.
    #[must_use]
    pub const fn above_high(self) -> bool {
        self.0 & 1 != 0
    }
}

/// A result of each kind, raw counts of 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Measurement {
    /// Ambient light, [`LUX_PER_COUNT`]. Without meaning on a VCNL3020.
    pub ambient: u16,
    /// Reflected infrared light above an offset that is the part's own, typically some
    /// 2000 counts; [`SATURATED`] if the register is full.
    pub proximity: u16,
}

const fn at_most_7(value: u8) -> u8 {
    if value > 7 { 7 } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_double_from_one_to_the_next() {
        assert_eq!(ProximityRate::Hz250.period_us(), 4_000);
        assert_eq!(ProximityRate::Hz125.bits(), 0x06);
        assert_eq!(ProximityRate::Hz1_95.period_us(), 512_000);
        assert_eq!(ProximityRate::Hz1_95.bits(), 0);
    }

    #[test]
    fn currents_step_by_ten_and_end_at_200() {
        let bits = |current| LedCurrent::from_milliamperes(current).map(LedCurrent::bits);
        assert_eq!(bits(0), Some(0));
        assert_eq!(bits(29), Some(2));
        assert_eq!(bits(200), Some(LedCurrent::MAX.bits()));
        assert_eq!(bits(201), None);
    }

    #[test]
    fn defaults_are_the_values_after_a_reset() {
        let after_reset = Configuration::default();
        assert_eq!(after_reset.rate.bits(), 0x00);
        assert_eq!(after_reset.led.bits(), 0x02);
        assert_eq!(after_reset.ambient.map(Ambient::bits), Some(0x1d));
        assert_eq!(InterruptControl::default().bits(), 0x00);
    }

    #[test]
    fn without_ambient_light_only_proximity_is_started() {
        let mut configuration = Configuration::default();
        assert_eq!(configuration.command(), Command(0x07));
        configuration.ambient = None;
        assert_eq!(configuration.command(), Command(0x03));
    }

    #[test]
    fn each_field_has_its_own_bits_and_does_not_overflow_into_the_next() {
        let ambient = Ambient {
            continuous: true,
            rate: AmbientRate::Hz10,
            auto_offset: true,
            conversions_log2: 200,
        };
        assert_eq!(ambient.bits(), 0xff);
        let control = InterruptControl {
            results_log2: 9,
            proximity_ready: true,
            ambient_ready: true,
            thresholds: Some(Compared::Ambient),
        };
        assert_eq!(control.bits(), 0b1110_1111);
        let status = InterruptStatus(0b1010);
        assert!(status.proximity_ready() && status.below_low());
        assert!(!status.ambient_ready() && !status.above_high());
        let command = Command(0b1010_0111);
        assert!(command.proximity_ready() && command.is_self_timed());
        assert!(!command.ambient_ready());
    }
}
