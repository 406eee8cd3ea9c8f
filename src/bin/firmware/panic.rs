//! The last resort: write down where, start over.

use core::panic::PanicInfo;

use amiro_ipf::board::supervision::Cause;
use defmt_rtt as _;

use crate::hal;

/// Keeps the place for the next life and resets: a robot must not stand dead on the
/// floor.
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let record = hal::record_of(Cause::Panic);
    let record = match info.location() {
        Some(location) => {
            defmt::error!("panic at {}:{}", location.file(), location.line());
            record.at(location.file(), location.line())
        }
        None => record,
    };
    hal::keep(&record);
    cortex_m::peripheral::SCB::sys_reset()
}
