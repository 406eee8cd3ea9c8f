//! Chooses the core's clock: the best that the board can start.

use serde::{Deserialize, Serialize};

/// What the core's clock runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ClockSource {
    /// No microcontroller: the node runs on a host.
    Host,
    /// Crystal and PLL, 168 MHz.
    CrystalPll,
    /// Internal oscillator and PLL, 168 MHz within 1 %: the crystal did not start.
    InternalPll,
    /// Internal oscillator, 16 MHz: the PLL did not lock.
    Internal,
    /// The clock unit answers nothing, as in an emulator; 168 MHz are assumed.
    Unknown,
}

/// Access to the clock unit; every wait is bounded. The second implementor is the tests'
/// model.
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

/// Starts the best clock; the source to configure the core with.
///
/// Crystal and PLL; without a crystal the PLL on the internal oscillator, within 1 %;
/// without a PLL the internal oscillator alone. If the internal oscillator does not start
/// either, the unit is an emulator's.
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
