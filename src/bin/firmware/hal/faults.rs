//! Handlers of faults and of unhandled exceptions: they keep a record and reset.

#![expect(
    unsafe_code,
    reason = "handlers take a stack of their own and read what the core has stacked"
)]

use core::arch::global_asm;

use amiro_ipf::board::supervision::{CoreRegisters, FailureCause};
use cortex_m::peripheral::{NVIC, SCB};

use super::{retained_ram, stack};

// Each handler switches to the emergency stack first, because an overflow leaves no room
// on the old one. It passes the old stack pointer on and never returns.
global_asm!(
    ".section .uninit.EMERGENCY_STACK, \"aw\", %nobits",
    ".balign 8",
    ".space 1024",
    "emergency_stack_top:",
    ".section .text.HardFault, \"ax\", %progbits",
    ".global HardFault",
    ".global MemoryManagement",
    ".global BusFault",
    ".global UsageFault",
    ".global NonMaskableInt",
    ".type HardFault, %function",
    ".type MemoryManagement, %function",
    ".type NonMaskableInt, %function",
    ".thumb_func",
    "HardFault:",
    ".thumb_func",
    "MemoryManagement:",
    ".thumb_func",
    "BusFault:",
    ".thumb_func",
    "UsageFault:",
    ".thumb_func",
    "NonMaskableInt:",
    "mrs r0, msp",
    "mrs r2, ipsr",
    "ldr r1, =emergency_stack_top",
    "msr msp, r1",
    "mov r1, r2",
    "b end_in_fault",
    ".ltorg",
    // Hands over the stack as the core left it. What it jumps to may return.
    ".section .text.DefaultHandler, \"ax\", %progbits",
    ".global DefaultHandler",
    ".type DefaultHandler, %function",
    ".thumb_func",
    "DefaultHandler:",
    "mrs r0, msp",
    "mrs r1, ipsr",
    "b handle_unhandled",
);

/// Number of the exception that the clock's guard raises, and nothing else here.
const NON_MASKABLE: u32 = 2;
/// Fault status: the frame of the exception could not be put on the stack.
const UNSTACKED: u32 = 1 << 4 | 1 << 12;
/// Fault status: the address of a memory management fault is valid.
const MEMORY_ADDRESS: u32 = 1 << 7;
/// Fault status: the address of a bus fault is valid.
const BUS_ADDRESS: u32 = 1 << 15;

/// Keeps a record of the fault and resets.
#[unsafe(no_mangle)]
extern "C" fn end_in_fault(sp: u32, exception: u32) -> ! {
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
    let cause = if exception == NON_MASKABLE {
        FailureCause::Clock
    } else if overflowed {
        FailureCause::StackOverflow
    } else {
        FailureCause::Fault
    };
    let mut record = retained_ram::record_of(cause);
    record.registers = CoreRegisters {
        sp,
        cfsr,
        hfsr,
        address,
        ..frame(sp, cfsr)
    };
    retained_ram::keep(&record);
    SCB::sys_reset()
}

/// Number of the exception of interrupt 0.
const FIRST_INTERRUPT: u32 = 16;

/// Place in the record of an exception without a handler; the line is its number.
const UNHANDLED: &str = "unhandled exception";

/// Keeps a record of an exception without a handler and resets.
///
/// Before the start code has run, the exception is a boot loader's: its interrupt is
/// disabled and the start goes on.
#[unsafe(no_mangle)]
extern "C" fn handle_unhandled(sp: u32, exception: u32) {
    if !stack::is_protected() {
        if let Some(interrupt) = exception.checked_sub(FIRST_INTERRUPT) {
            disable(interrupt);
        }
        return;
    }
    let mut record = retained_ram::record_of(FailureCause::Panic).at(UNHANDLED, exception);
    record.registers = CoreRegisters { sp, ..frame(sp, 0) };
    retained_ram::keep(&record);
    SCB::sys_reset()
}

fn disable(interrupt: u32) {
    // SAFETY: a register of the core that is always there; to disable an interrupt
    // for which there is no handler breaks nothing.
    let nvic = unsafe { &*NVIC::PTR };
    if let Some(register) = nvic.icer.get((interrupt / 32) as usize) {
        // SAFETY: as above; zeros in the word change nothing.
        unsafe { register.write(1 << (interrupt % 32)) }
    }
}

#[expect(unsafe_code, reason = "a handler cannot borrow the unit")]
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
fn frame(sp: u32, cfsr: u32) -> CoreRegisters {
    if cfsr & UNSTACKED != 0 || !stack::is_frame(sp) {
        return CoreRegisters::default();
    }
    let word = |offset: u32| {
        // SAFETY: eight words at `sp` lie in the stack's RAM, as was just found, and
        // the core has written them.
        unsafe { core::ptr::with_exposed_provenance::<u32>((sp + offset) as usize).read_volatile() }
    };
    CoreRegisters {
        lr: word(20),
        pc: word(24),
        psr: word(28),
        ..CoreRegisters::default()
    }
}
