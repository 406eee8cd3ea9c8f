//! Where faults end: a record, and a reset.

#![expect(
    unsafe_code,
    reason = "handlers take a stack of their own and read what the core has left"
)]

use core::arch::global_asm;

use amiro_ipf::supervision::{Cause, Registers};
use cortex_m::peripheral::SCB;

use super::{last_words, stack};

// Both handlers take a stack of their own before they do anything: after an overflow
// there is none left. They hand over the old one, and never return.
global_asm!(
    ".section .uninit.EMERGENCY_STACK, \"aw\", %nobits",
    ".balign 8",
    ".space 1024",
    "emergency_stack_top:",
    ".section .text.HardFault, \"ax\", %progbits",
    ".global HardFault",
    ".global MemoryManagement",
    ".type HardFault, %function",
    ".type MemoryManagement, %function",
    ".thumb_func",
    "HardFault:",
    ".thumb_func",
    "MemoryManagement:",
    "mrs r0, msp",
    "ldr r1, =emergency_stack_top",
    "msr msp, r1",
    "b end_in_fault",
    ".ltorg",
);

/// Fault status: the frame of the exception could not be put on the stack.
const UNSTACKED: u32 = 1 << 4 | 1 << 12;
/// Fault status: the address of a memory management fault is valid.
const MEMORY_ADDRESS: u32 = 1 << 7;
/// Fault status: the address of a bus fault is valid.
const BUS_ADDRESS: u32 = 1 << 15;

/// Writes down what can be known, and starts over.
#[unsafe(no_mangle)]
extern "C" fn end_in_fault(sp: u32) -> ! {
    let (cfsr, hfsr, memory, bus) = status();
    let address = if cfsr & MEMORY_ADDRESS != 0 {
        memory
    } else if cfsr & BUS_ADDRESS != 0 {
        bus
    } else {
        0
    };
    let overflowed = stack::is_guarded(sp)
        || (cfsr & MEMORY_ADDRESS != 0 && stack::is_guarded(memory))
        || cfsr & UNSTACKED != 0;
    let cause = if overflowed {
        Cause::StackOverflow
    } else {
        Cause::Fault
    };
    let mut record = last_words::record_of(cause);
    record.registers = Registers {
        sp,
        cfsr,
        hfsr,
        address,
        ..frame(sp, cfsr)
    };
    last_words::keep(&record);
    SCB::sys_reset()
}

#[expect(
    unsafe_code,
    reason = "a handler has nobody who could lend it the unit"
)]
fn status() -> (u32, u32, u32, u32) {
    // SAFETY: registers of the core that are always there; reading changes nothing.
    let scb = unsafe { &*SCB::PTR };
    (
        scb.cfsr.read(),
        scb.hfsr.read(),
        scb.mmfar.read(),
        scb.bfar.read(),
    )
}

/// The registers that the core has put on the stack: r0 to r3, r12, lr, pc, psr.
fn frame(sp: u32, cfsr: u32) -> Registers {
    if cfsr & UNSTACKED != 0 || !stack::is_frame(sp) {
        return Registers::default();
    }
    let word = |offset: u32| {
        // SAFETY: eight words at `sp` lie in the stack's RAM, as was just found, and
        // the core has written them.
        unsafe { core::ptr::with_exposed_provenance::<u32>((sp + offset) as usize).read_volatile() }
    };
    Registers {
        lr: word(20),
        pc: word(24),
        psr: word(28),
        ..Registers::default()
    }
}
