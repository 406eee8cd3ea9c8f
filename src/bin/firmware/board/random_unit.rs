//! What tells one start from another: the random number unit, the chip's number.

use amiro_ipf::node::seed::WORDS;
use stm32f4xx_hal::pac::RNG;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};
use stm32f4xx_hal::signature::Uid;

/// Turns of the polling loop for all words together. The unit needs 40 cycles of its 48
/// MHz for one, 27 microseconds for all; 10 000 turns are some 0.6 ms at 168 MHz, which
/// is all that a unit which says nothing costs a start.
const PATIENCE: u32 = 10_000;

/// Words from the unit; `None` if it reports an error or leaves one out.
///
/// The HAL's own reading waits without bound where there is no such unit.
pub(super) fn draw(unit: &RNG, rcc: &mut Rcc) -> Option<[u32; WORDS]> {
    RNG::enable(rcc);
    RNG::reset(rcc);
    unit.cr().modify(|_, w| w.rngen().set_bit());
    let mut words = [0; WORDS];
    let mut patience = PATIENCE;
    for word in &mut words {
        *word = next(unit, &mut patience)?;
    }
    unit.cr().modify(|_, w| w.rngen().clear_bit());
    Some(words)
}

fn next(unit: &RNG, patience: &mut u32) -> Option<u32> {
    while *patience > 0 {
        *patience -= 1;
        let status = unit.sr().read();
        if status.cecs().bit_is_set() || status.secs().bit_is_set() {
            return None;
        }
        if status.drdy().bit_is_set() {
            return Some(unit.dr().read().rndata().bits());
        }
    }
    None
}

/// The number that the maker gave the chip: 96 bits, on the silicon's system memory.
pub(super) fn unique_number() -> [u32; 3] {
    let uid = Uid::get();
    let lot = uid.lot_num().as_bytes();
    let word = |at: usize| {
        (at..at + 4).fold(0, |word, at| {
            word << 8 | u32::from(lot.get(at).copied().unwrap_or(0))
        })
    };
    [
        u32::from(uid.x()) << 16 | u32::from(uid.y()),
        u32::from(uid.waf_num()) << 24 | word(0) >> 8,
        word(3),
    ]
}
