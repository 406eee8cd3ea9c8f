//! Starts the core's clock: crystal and PLL, or the best that starts.

use amiro_ipf::board::clock_choice::{ClockSource, ClockUnit, choose};
use stm32f4xx_hal::pac::RCC;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};

/// Full speed, hertz.
pub(super) const CORE_HZ: u32 = 168_000_000;

/// The crystal, hertz.
const CRYSTAL_HZ: u32 = 8_000_000;

/// Turns of a polling loop after which a clock is given up: at 16 MHz and some ten
/// cycles a turn 60 ms, many times what a crystal (2 ms) or a PLL (0.3 ms) needs.
const PATIENCE: u32 = 100_000;

/// Runs the core at 168 MHz, or at the best clock that starts.
///
/// A boot loader leaves the PLL running, so everything first goes back to the
/// internal oscillator. The HAL's own start waits without bound; here crystal and
/// PLL are started first, with bounds and with the very settings that the HAL
/// computes, so that its loops end at once.
pub(super) fn start(rcc: RCC) -> (Rcc, ClockSource) {
    let mut unit = ResetAndClockUnit(rcc);
    let source = choose(&mut unit);
    let ResetAndClockUnit(rcc) = unit;
    if source == ClockSource::CrystalPll {
        // Should the crystal stop later, the core goes on at 16 MHz and gets an NMI.
        rcc.cr().modify(|_, w| w.csson().set_bit());
    }
    let config = match source {
        ClockSource::CrystalPll => Config::hse(CRYSTAL_HZ.Hz()).sysclk(CORE_HZ.Hz()),
        ClockSource::InternalPll => Config::hsi().sysclk(CORE_HZ.Hz()),
        ClockSource::Internal | ClockSource::Unknown | ClockSource::Host => Config::hsi(),
    };
    (rcc.freeze(config), source)
}

/// The clock unit's registers.
struct ResetAndClockUnit(RCC);

impl ClockUnit for ResetAndClockUnit {
    fn start_internal(&mut self) -> bool {
        self.0.cr().modify(|_, w| w.hsion().set_bit());
        patiently(|| self.0.cr().read().hsirdy().bit_is_set())
    }

    fn select_internal(&mut self) {
        self.0.cfgr().modify(|_, w| w.sw().hsi());
        patiently(|| self.0.cfgr().read().sws().is_hsi());
    }

    fn stop_pll(&mut self) {
        self.0.cr().modify(|_, w| w.pllon().clear_bit());
        patiently(|| self.0.cr().read().pllrdy().bit_is_clear());
    }

    fn start_crystal(&mut self) -> bool {
        self.0.cr().modify(|_, w| w.hseon().set_bit());
        patiently(|| self.0.cr().read().hserdy().bit_is_set())
    }

    fn stop_crystal(&mut self) {
        self.0.cr().modify(|_, w| w.hseon().clear_bit());
    }

    #[expect(unsafe_code, reason = "the register's fields take raw numbers")]
    /// 2 MHz in (M), 336 MHz inside (N), half out (P), 48 MHz beside (Q).
    fn lock_pll(&mut self, on_crystal: bool) -> bool {
        let m = if on_crystal { 4 } else { 8 };
        self.0.pllcfgr().write(|w| {
            // SAFETY: M 2..=63, N 50..=432 and Q 2..=15 are the ranges of the reference
            // manual (RM0090, 7.3.2), and these values lie inside.
            unsafe {
                w.pllm().bits(m);
                w.plln().bits(168);
                w.pllq().bits(7);
            }
            w.pllp().div2().pllsrc().bit(on_crystal)
        });
        self.0.cr().modify(|_, w| w.pllon().set_bit());
        patiently(|| self.0.cr().read().pllrdy().bit_is_set())
    }
}

/// Polls until `ready`, at most [`PATIENCE`] times; whether it became ready.
fn patiently(ready: impl Fn() -> bool) -> bool {
    (0..PATIENCE).any(|_| ready())
}
