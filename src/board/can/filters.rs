//! What the unit lets in: the identifiers that are read, as data frames, nothing else.

use super::{READ, StandardId};

use super::registers::{FINIT, Register, Registers};

/// The banks of CAN1, of which the first three are used.
const ALL_BANKS: u32 = 0x3fff;
/// Bits of the banks in use.
const USED_BANKS: u32 = 0b111;

/// Identifiers by bank and word, two in a word; places left over repeat the first.
const LIST: [[[StandardId; 2]; 2]; 3] = {
    let [a, b, c, d, e, f, g, h, i] = READ;
    [[[a, b], [c, d]], [[e, f], [g, h]], [[i, a], [a, a]]]
};

/// Sets the filters; a flood of anything else then costs no interrupt.
///
/// List mode with 16 bits: identifier in the upper 11, then RTR and IDE, which must be
/// 0 as they are here: remote and extended frames do not match.
pub(super) fn set<R: Registers>(registers: &mut R) {
    registers.change(Register::FMR, 0, FINIT);
    registers.change(Register::FA1R, ALL_BANKS, 0);
    registers.change(Register::FM1R, 0, USED_BANKS);
    registers.change(Register::FS1R, USED_BANKS, 0);
    registers.change(Register::FFA1R, USED_BANKS, 0);
    for (bank, identifiers) in Register::BANKS.iter().zip(LIST) {
        for (word, [low, high]) in bank.iter().zip(identifiers) {
            let pattern = |identifier: StandardId| u32::from(identifier.bits()) << 5;
            registers.write(*word, pattern(low) | pattern(high) << 16);
        }
    }
    registers.change(Register::FA1R, 0, USED_BANKS);
    registers.change(Register::FMR, FINIT, 0);
}
