//! The random number unit, asked once at start.

use amiro_ipf::seed::WORDS;
use stm32f4xx_hal::pac::RNG;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// Turns of the polling loop for one word. The unit needs 40 cycles of its 48 MHz, 0.83
/// microseconds; a thousand turns are some 30 at 168 MHz, so that a unit that says
/// nothing costs a start no more than that, and one that is slow a millisecond.
const PATIENCE: u32 = 1_000;

/// Words from the unit; `None` if it reports an error or leaves one out.
///
/// The HAL's own reading waits without bound where there is no such unit.
pub(crate) fn draw(unit: &RNG, rcc: &mut Rcc) -> Option<[u32; WORDS]> {
    RNG::enable(rcc);
    RNG::reset(rcc);
    unit.cr().modify(|_, w| w.rngen().set_bit());
    let mut words = [0; WORDS];
    for word in &mut words {
        *word = next(unit)?;
    }
    unit.cr().modify(|_, w| w.rngen().clear_bit());
    Some(words)
}

fn next(unit: &RNG) -> Option<u32> {
    for _ in 0..PATIENCE {
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
