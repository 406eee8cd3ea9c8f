//! The panic handler: keeps a post-mortem record and resets.

use core::panic::PanicInfo;

use amiro_ipf::board::supervision::FailureCause;
use defmt_rtt as _;

use crate::hal;

/// Keeps the panic's place for the next boot and resets, so that the robot goes on.
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let record = hal::record_of(FailureCause::Panic);
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
