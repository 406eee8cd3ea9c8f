//! The unit's clock settings for 400 kHz.

/// The bus clock wanted, hertz: fast mode, which all parts on the board can do.
const FAST_HZ: u32 = 400_000;

/// What the timing registers hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct I2cTiming {
    /// Frequency of the peripheral bus, MHz: the field FREQ of CR2.
    pub(super) megahertz: u16,
    /// CCR: fast mode, low to high 2:1, and the clock's thirds in bus cycles.
    pub(super) clock: u16,
    /// TRISE: most bus cycles in which a line may rise, and one.
    pub(super) rise: u16,
}

impl I2cTiming {
    /// Settings for a peripheral bus (APB1) of the given frequency \[RM 27.6.8, 27.6.9\].
    ///
    /// At 42 MHz: a clock is 3 x CCR bus cycles, so CCR = 42 MHz / (3 x 400 kHz) = 35
    /// exactly, low for 70 cycles (1.67 us) and high for 35 (0.83 us; fast mode asks
    /// for 1.3 us and 0.6 us). TRISE = 300 ns x 42 MHz + 1 = 12.6 + 1 -> 13. Where the
    /// division leaves a remainder CCR is rounded up: never faster than 400 kHz.
    ///
    /// The unit needs 4 MHz for fast mode and takes at most 50 MHz; what lies outside
    /// is set as the nearest of these.
    pub const fn fast(bus_hz: u32) -> Self {
        let bus_hz = match bus_hz {
            0..4_000_000 => 4_000_000,
            50_000_001.. => 50_000_000,
            _ => bus_hz,
        };
        const FAST_MODE: u16 = 1 << 15;
        // At most 50, at most 42, at most 16: each fits its field of 6, 12 and 6 bits.
        Self {
            megahertz: (bus_hz / 1_000_000) as u16,
            clock: FAST_MODE | bus_hz.div_ceil(3 * FAST_HZ) as u16,
            rise: (bus_hz / 1000 * 300 / 1_000_000) as u16 + 1,
        }
    }
}
