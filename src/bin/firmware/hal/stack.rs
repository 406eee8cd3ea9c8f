//! The stack: its guard and its high-water mark.

#![expect(unsafe_code, reason = "the linker places the stack")]

use cortex_m::peripheral::{MPU, SCB};

/// Bytes of the guard below the stack: a power of two, as the protection unit wants it.
/// A function with a larger frame than this could step over it; the largest in the
/// image is the start's, before there is a guard.
const GUARD: u32 = 1024;

/// Control of the protection unit: on, with the default map for everything but the
/// guard; off in the hard fault handler.
const CONTROL: u32 = 1 << 2 | 1;

/// What the start code paints the stack with.
const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    /// The end of the statics, from the linker script.
    static _stack_end: u32;
    /// The top of the stack, from the linker script.
    static _stack_start: u32;
}

/// Addresses of the guard's first byte and of the stack's last one above it.
fn guard() -> (u32, u32) {
    let end = (&raw const _stack_end).addr() as u32;
    let start = end.next_multiple_of(GUARD);
    (start, start + GUARD)
}

/// Whether an address lies in the guard.
pub(super) fn is_guarded(address: u32) -> bool {
    let (start, end) = guard();
    (start..end).contains(&address)
}

/// Whether the 32 bytes of an exception's frame can be read at an address.
pub(super) fn is_frame(address: u32) -> bool {
    let (_, bottom) = guard();
    let top = (&raw const _stack_start).addr() as u32;
    address.is_multiple_of(4) && (bottom..=top.saturating_sub(32)).contains(&address)
}

/// Makes every access to the guard a memory management fault.
pub(super) fn protect(mpu: &mut MPU, scb: &mut SCB) {
    // Size as a power of two less one, no access, nothing executed, on.
    const REGION: u32 = 1 << 28 | (GUARD.ilog2() - 1) << 1 | 1;
    // SAFETY: the region lies between the statics and the stack, where nothing is; the
    // numbers are those of the architecture's manual (ARMv7-M, B3.5).
    unsafe {
        mpu.rnr.write(0);
        mpu.rbar.write(guard().0);
        mpu.rasr.write(REGION);
        mpu.ctrl.write(CONTROL);
    }
    scb.enable(cortex_m::peripheral::scb::Exception::MemoryManagement);
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Whether the guard is set: it is from the image's first steps on, and no boot loader's
/// protection is the same.
pub(super) fn is_protected() -> bool {
    // SAFETY: registers of the core that are always there; reading changes nothing.
    let mpu = unsafe { &*MPU::PTR };
    mpu.ctrl.read() == CONTROL && mpu.rbar.read() == guard().0
}

/// Paints the stack below its present end again, so that the high-water mark covers the
/// tasks and not the start.
///
/// To be called by the idle task: tasks that interrupt it have ended when it goes on, so
/// that nothing is in use below its own frame.
pub(crate) fn repaint() {
    const OWN_FRAME: u32 = 128;
    let (_, bottom) = guard();
    let end = cortex_m::register::msp::read().saturating_sub(OWN_FRAME);
    for address in (bottom..end).step_by(4) {
        // SAFETY: an aligned word of the RAM between the guard and the frames in use,
        // as stated above.
        unsafe {
            core::ptr::with_exposed_provenance_mut::<u32>(address as usize).write_volatile(PAINT);
        }
    }
}

/// Bytes above the guard that were never used since the last painting. Reads each word:
/// 1 ms at most.
pub(crate) fn unused() -> u32 {
    let (_, bottom) = guard();
    let top = (&raw const _stack_start).addr() as u32;
    let is_painted = |address: &u32| {
        // SAFETY: an aligned word of the RAM between the guard and the stack's top, which
        // only the program writes, as its stack; every value is a valid number.
        let word =
            unsafe { core::ptr::with_exposed_provenance::<u32>(*address as usize).read_volatile() };
        word == PAINT
    };
    (bottom..top).step_by(4).take_while(is_painted).count() as u32 * 4
}
