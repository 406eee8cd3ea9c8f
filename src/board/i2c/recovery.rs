//! Frees a bus by driving its pins by hand.

use super::registers::{BusLine, I2cRegister, I2cRegisters, cr1, sr2};
use super::timing::I2cTiming;

/// Half clocks for which a low SCL is waited for, all in all: 50 us.
const PATIENCE: u8 = 20;

/// Clocks after which a part that was caught in mid-byte has let go of SDA: eight bits
/// and the acknowledgement that it does not get.
const CLOCKS: u8 = 9;

/// Frees the bus and sets the unit up again; returns whether bus and unit are idle afterwards.
///
/// 1. The unit is switched off and the pins are taken.
/// 2. While SDA is low, at most nine clocks: a part that a reset or a lost clock left
///    in the middle of a byte shifts it out.
/// 3. A start and a stop by hand. Every part then waits for a start; and both wires
///    change, which unlocks the unit's analog filters \[ES F1 2.14.7\].
/// 4. Pins back, reset by SWRST, which also clears a busy flag and a refused start that
///    a misplaced stop left behind \[ES, start after a misplaced stop\], and the
///    settings again, which the reset loses.
///
/// The unit is left switched on in either case. At most some 60 half clocks,
/// 150 us; 15 us where nothing is wrong.
pub(super) fn recover<R: I2cRegisters>(registers: &mut R, timing: I2cTiming) -> bool {
    registers.write(I2cRegister::Cr1, 0);
    registers.write(I2cRegister::Cr2, 0);
    registers.take_pins();
    registers.wait_half_clock();
    let free = free_wires(registers);
    registers.return_pins();
    set_up(registers, timing);
    free && registers.read(I2cRegister::Sr2) & sr2::BUSY == 0
}

/// Steps 2 and 3; whether both wires are high.
fn free_wires<R: I2cRegisters>(registers: &mut R) -> bool {
    let mut patience = PATIENCE;
    if !clock_rises(registers, &mut patience) {
        return false;
    }
    let mut clocks = 0;
    loop {
        while !registers.is_high(BusLine::Data) {
            if clocks == CLOCKS || !clock(registers, &mut patience) {
                return false;
            }
            clocks += 1;
        }
        if start_and_stop(registers, &mut patience) {
            return true;
        }
        // The clock in the stop made a part pull SDA: it still sends.
        if clocks == CLOCKS {
            return false;
        }
        clocks += 1;
    }
}

/// One clock; whether SCL came up again.
// Copies in each caller and for each bus would cost flash.
#[inline(never)]
fn clock<R: I2cRegisters>(registers: &mut R, patience: &mut u8) -> bool {
    registers.pull(BusLine::Clock);
    registers.wait_half_clock();
    clock_rises(registers, patience)
}

/// A start, a clock with SDA low, a stop; whether both wires are high then.
fn start_and_stop<R: I2cRegisters>(registers: &mut R, patience: &mut u8) -> bool {
    registers.pull(BusLine::Data);
    registers.wait_half_clock();
    let risen = clock(registers, patience);
    registers.release(BusLine::Data);
    registers.wait_half_clock();
    risen && registers.is_high(BusLine::Data) && registers.is_high(BusLine::Clock)
}

/// Releases SCL and lets half a clock pass, more if a part stretches; whether it rose.
// As `clock`.
#[inline(never)]
fn clock_rises<R: I2cRegisters>(registers: &mut R, patience: &mut u8) -> bool {
    registers.release(BusLine::Clock);
    registers.wait_half_clock();
    while !registers.is_high(BusLine::Clock) {
        if *patience == 0 {
            return false;
        }
        *patience -= 1;
        registers.wait_half_clock();
    }
    true
}

/// Resets the unit, sets it up and switches it on.
fn set_up<R: I2cRegisters>(registers: &mut R, timing: I2cTiming) {
    registers.write(I2cRegister::Cr1, cr1::RESET);
    registers.wait_half_clock();
    registers.write(I2cRegister::Cr1, 0);
    registers.write(I2cRegister::Cr2, timing.megahertz);
    registers.write(I2cRegister::Ccr, timing.clock);
    registers.write(I2cRegister::Trise, timing.rise);
    registers.write(I2cRegister::Cr1, cr1::ENABLE);
}
