//! The acceptance filters: data frames with the identifiers that are read.

use super::{READ_IDS, StandardId};

use super::registers::{CanRegister, CanRegisters, FINIT};

/// The banks of CAN1, of which the first three are used.
const ALL_BANKS: u32 = 0x3fff;
/// Bits of the banks in use.
const USED_BANKS: u32 = 0b111;

/// Identifiers by bank and word, two in a word; places left over repeat the first.
const LIST: [[[StandardId; 2]; 2]; 3] = {
    let [a, b, c, d, e, f, g, h, i] = READ_IDS;
    [[[a, b], [c, d]], [[e, f], [g, h]], [[i, a], [a, a]]]
};

/// Sets the filters, so that a flood of other frames causes no interrupt.
///
/// List mode with 16 bits: identifier in the upper 11, then RTR and IDE, which must be
/// 0 as they are here: remote and extended frames do not match.
pub(super) fn set<R: CanRegisters>(registers: &mut R) {
    registers.change(CanRegister::FMR, 0, FINIT);
    registers.change(CanRegister::FA1R, ALL_BANKS, 0);
    registers.change(CanRegister::FM1R, 0, USED_BANKS);
    registers.change(CanRegister::FS1R, USED_BANKS, 0);
    registers.change(CanRegister::FFA1R, USED_BANKS, 0);
    for (bank, identifiers) in CanRegister::BANKS.iter().zip(LIST) {
        for (word, [low, high]) in bank.iter().zip(identifiers) {
            let pattern = |identifier: StandardId| u32::from(identifier.bits()) << 5;
            registers.write(*word, pattern(low) | pattern(high) << 16);
        }
    }
    registers.change(CanRegister::FA1R, 0, USED_BANKS);
    registers.change(CanRegister::FMR, FINIT, 0);
}
