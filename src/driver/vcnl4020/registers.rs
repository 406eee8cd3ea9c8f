//! The registers of the VCNL4020 and what their bits mean.

/// The part's address; it cannot be changed.
pub const ADDRESS: u8 = 0x13;

/// What the identity register reads: product 2, revision 1.
pub const IDENTITY: u8 = 0x21;

/// The proximity register when it is full: something touches the sensor.
pub const SATURATED: u16 = u16::MAX;

/// The registers by their addresses; a transfer goes on to the next by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Register {
    Command = 0x80,
    Identity = 0x81,
    ProximityRate = 0x82,
    LedCurrent = 0x83,
    Ambient = 0x84,
    Result = 0x85,
    ProximityResult = 0x87,
    InterruptControl = 0x89,
    LowThreshold = 0x8a,
    InterruptStatus = 0x8e,
}

/// The command register: what the part is doing and what is ready.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command(pub u8);

impl Command {
    /// Nothing measures.
    pub const STOP: Self = Self(0);
    /// Ambient light and proximity are measured periodically by the part itself.
    pub const SELF_TIMED: Self = Self(0b0111);
    /// Ambient light and proximity are each measured once.
    pub const ON_DEMAND: Self = Self(0b1_1000);

    /// Whether an ambient result waits that was not read yet.
    #[must_use]
    pub const fn ambient_ready(self) -> bool {
        self.0 & 1 << 6 != 0
    }

    /// Whether a proximity result waits that was not read yet.
    #[must_use]
    pub const fn proximity_ready(self) -> bool {
        self.0 & 1 << 5 != 0
    }

    /// Whether the part measures by itself. A part that was told to and does not has
    /// been reset since.
    #[must_use]
    pub const fn is_self_timed(self) -> bool {
        self.0 & 1 != 0
    }
}

/// Proximity measurements a second in self-timed mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProximityRate {
    /// 1.953125 /s, the value after a reset.
    Hz1_95,
    /// 3.90625 /s.
    Hz3_9,
    /// 7.8125 /s.
    Hz7_8,
    /// 15.625 /s; the data sheet prints 16.625, which breaks its row of halves.
    Hz15_6,
    /// 31.25 /s.
    Hz31_25,
    /// 62.5 /s.
    Hz62_5,
    /// 125 /s.
    Hz125,
    /// 250 /s.
    Hz250,
}

impl ProximityRate {
    /// The register's value.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self as u8
    }

    /// Time between two measurements, microseconds.
    #[must_use]
    pub const fn period_us(self) -> u32 {
        512_000 >> self.bits()
    }
}

/// Current of the infrared diode during a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LedCurrent(u8);

impl LedCurrent {
    /// The most, 200 mA.
    pub const MAX: Self = Self(20);

    /// A current in steps of 10 mA, rounded down; `None` above 200 mA.
    #[must_use]
    pub const fn from_milliamperes(current: u8) -> Option<Self> {
        if current > 200 {
            return None;
        }
        Some(Self(current / 10))
    }

    /// The register's value.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }
}

/// Ambient measurements a second in self-timed mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(missing_docs, reason = "the names say it all")]
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

/// How ambient light is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ambient {
    /// Conversions follow each other at once instead of being spread over a period.
    pub continuous: bool,
    /// Results a second.
    pub rate: AmbientRate,
    /// The part measures its own offset first and subtracts it.
    pub auto_offset: bool,
    /// Conversions averaged for a result, as a power of two: 0 to 7 for 1 to 128.
    pub conversions_log2: u8,
}

impl Ambient {
    /// As AMiRo-OS leaves it: 2 results a second of 32 conversions, no auto-offset
    /// (it means to have it and sets a bit of the rate instead).
    pub const AMIRO: Self = Self {
        continuous: false,
        rate: AmbientRate::Hz2,
        auto_offset: false,
        conversions_log2: 5,
    };

    /// The register's value.
    #[must_use]
    pub const fn bits(self) -> u8 {
        let conversions = if self.conversions_log2 > 7 {
            7
        } else {
            self.conversions_log2
        };
        (self.continuous as u8) << 7
            | (self.rate as u8) << 4
            | (self.auto_offset as u8) << 3
            | conversions
    }
}

/// What the thresholds are compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Watched {
    /// The proximity result.
    Proximity,
    /// The ambient result.
    Ambient,
}

/// When the interrupt pin is pulled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InterruptControl {
    /// Results in a row beyond a threshold before the pin is pulled, as a power of
    /// two: 0 to 7 for 1 to 128.
    pub results_log2: u8,
    /// At every proximity result.
    pub proximity_ready: bool,
    /// At every ambient result.
    pub ambient_ready: bool,
    /// When this result leaves the thresholds; `None` does not look at them.
    pub thresholds: Option<Watched>,
}

impl InterruptControl {
    /// The register's value.
    #[must_use]
    pub const fn bits(self) -> u8 {
        let results = if self.results_log2 > 7 {
            7
        } else {
            self.results_log2
        };
        let thresholds = match self.thresholds {
            None => 0b00,
            Some(Watched::Proximity) => 0b10,
            Some(Watched::Ambient) => 0b11,
        };
        results << 5
            | (self.proximity_ready as u8) << 3
            | (self.ambient_ready as u8) << 2
            | thresholds
    }
}

/// Why the interrupt pin is pulled; writing a bit of it back clears that reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InterruptStatus(pub u8);

impl InterruptStatus {
    /// Every reason.
    pub const ALL: Self = Self(0x0f);

    /// A proximity result came.
    #[must_use]
    pub const fn proximity_ready(self) -> bool {
        self.0 & 1 << 3 != 0
    }

    /// An ambient result came.
    #[must_use]
    pub const fn ambient_ready(self) -> bool {
        self.0 & 1 << 2 != 0
    }

    /// The watched result fell below the low threshold.
    #[must_use]
    pub const fn below_low(self) -> bool {
        self.0 & 1 << 1 != 0
    }

    /// The watched result rose above the high threshold.
    #[must_use]
    pub const fn above_high(self) -> bool {
        self.0 & 1 != 0
    }
}

/// One result: two raw numbers of 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Measurement {
    /// Ambient light, 0.25 lx a count.
    pub ambient: u16,
    /// Proximity: reflected light and the part's own offset of some 2000 counts;
    /// [`SATURATED`] when full.
    pub proximity: u16,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_amiros_settings_have_the_published_bytes() {
        assert_eq!(ProximityRate::Hz125.bits(), 0x06);
        assert_eq!(ProximityRate::Hz125.period_us(), 8_000);
        assert_eq!(LedCurrent::MAX.bits(), 0x14);
        assert_eq!(Ambient::AMIRO.bits(), 0x15);
        assert_eq!(Command::SELF_TIMED.0, 0x07);
    }

    #[test]
    fn rates_double_from_one_to_the_next() {
        assert_eq!(ProximityRate::Hz250.period_us(), 4_000);
        assert_eq!(ProximityRate::Hz1_95.period_us(), 512_000);
        assert_eq!(ProximityRate::Hz1_95.bits(), 0);
    }

    #[test]
    fn currents_step_by_ten_and_end_at_200() {
        let bits = |current| LedCurrent::from_milliamperes(current).map(LedCurrent::bits);
        assert_eq!(bits(0), Some(0));
        assert_eq!(bits(29), Some(2));
        assert_eq!(bits(200), Some(20));
        assert_eq!(bits(201), None);
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
            thresholds: Some(Watched::Ambient),
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
