//! The bit timing of the CAN unit.

/// The bit timing register's value for 1 Mbit/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitTiming(u32);

impl BitTiming {
    /// 42 MHz: a prescaler of 2 gives 21 quanta to a microsecond, 1 + 16 + 4 of them a
    /// bit. SJW 2 (1 in the register), TS2 4 (3), TS1 16 (15), BRP 2 (1). Sampled at
    /// 17 / 21 = 81 %; the robots' own firmware has the same.
    pub const AT_42_MHZ: Self = Self(1 << 24 | 3 << 20 | 15 << 16 | 1);

    /// 16 MHz: 16 quanta, 1 + 12 + 3; SJW 2 (1), TS2 3 (2), TS1 12 (11), BRP 1 (0).
    /// Sampled at 13 / 16 = 81 %. The internal oscillator's 1 % may be too coarse for
    /// the bus, which shows in the error counters.
    pub const AT_16_MHZ: Self = Self(1 << 24 | 2 << 20 | 11 << 16);

    /// The timing on a peripheral bus of the given frequency, if there is one.
    pub const fn at(bus_hz: u32) -> Option<Self> {
        match bus_hz {
            42_000_000 => Some(Self::AT_42_MHZ),
            16_000_000 => Some(Self::AT_16_MHZ),
            _ => None,
        }
    }

    /// The register's bits.
    pub const fn bits(self) -> u32 {
        self.0
    }
}
