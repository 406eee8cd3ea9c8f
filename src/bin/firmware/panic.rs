//! The last resort: say where, start over.

use core::panic::PanicInfo;

use defmt_rtt as _;

/// Logs the place and resets: a robot must not stand dead on the floor.
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    match info.location() {
        Some(location) => defmt::error!("panic at {}:{}", location.file(), location.line()),
        None => defmt::error!("panic"),
    }
    cortex_m::peripheral::SCB::sys_reset()
}
