//! AMiRo's boot loader, where it started the image.
//!
//! Facts of its public sources, none of it verified on hardware.

use cortex_m::peripheral::SCB;

/// Where it keeps its table of calls.
const TABLE: usize = 0x0800_01c0;

/// What the table begins with: "A-BL".
const MAGIC: u32 = 0x412d_424c;

/// The call that carries out a request to shut down, from the table's start.
const SHUT_DOWN: usize = 32;

/// The boot loader; there is one only where it was found.
#[derive(Clone, Copy)]
pub(crate) struct Loader(());

impl Loader {
    /// The boot loader, if the image is linked to lie behind it and it is there.
    pub(super) fn find() -> Option<Self> {
        (cfg!(feature = "amiro-layout") && word(TABLE) == MAGIC).then_some(Self(()))
    }

    #[expect(unsafe_code, reason = "the call is a number in the loader's table")]
    /// Hands the robot over to the loader, which switches it off; resets if it returns.
    pub(crate) fn shut_down(self) -> ! {
        cortex_m::interrupt::disable();
        let call = word(TABLE + SHUT_DOWN);
        // SAFETY: the table's magic was found, and at this place it holds a function
        // of the loader's that takes nothing; interrupts are off, so that none of ours
        // comes in between.
        let call = unsafe { core::mem::transmute::<usize, extern "C" fn()>(call as usize) };
        call();
        SCB::sys_reset()
    }
}

#[expect(unsafe_code, reason = "the table lies at a fixed address")]
fn word(address: usize) -> u32 {
    // SAFETY: an aligned word in the chip's flash, which is always there.
    unsafe { core::ptr::with_exposed_provenance::<u32>(address).read_volatile() }
}
