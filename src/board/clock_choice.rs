//! Which clock the core runs on: the best that the board can start.

use crate::link::ClockSource;

/// What the clock unit can be told; every call waits a bounded time at most. The second
/// implementor is the tests' model.
pub trait ClockUnit {
    /// Starts the internal oscillator; whether it runs.
    fn start_internal(&mut self) -> bool;
    /// Lets the core run on it.
    fn select_internal(&mut self);
    /// Stops the PLL, which a boot loader may have left running.
    fn stop_pll(&mut self);
    /// Starts the crystal; whether it runs.
    fn start_crystal(&mut self) -> bool;
    /// Stops it.
    fn stop_crystal(&mut self);
    /// Starts the PLL for 168 MHz, on the crystal or on the internal oscillator; whether
    /// it locked.
    fn lock_pll(&mut self, on_crystal: bool) -> bool;
}

/// Brings the clock unit as far as it goes; what it is then to be frozen at.
///
/// Crystal and PLL; without a crystal the PLL on the internal oscillator, within 1 %;
/// without a PLL the internal oscillator alone. A unit that does not even answer for
/// that one is an emulator's.
pub fn choose(unit: &mut impl ClockUnit) -> ClockSource {
    if !unit.start_internal() {
        return ClockSource::Unknown;
    }
    unit.select_internal();
    unit.stop_pll();
    if unit.start_crystal() && unit.lock_pll(true) {
        return ClockSource::CrystalPll;
    }
    unit.stop_crystal();
    unit.stop_pll();
    if unit.lock_pll(false) {
        return ClockSource::InternalPll;
    }
    unit.stop_pll();
    ClockSource::Internal
}
