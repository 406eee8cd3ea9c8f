//! Restores the reset state of the core and its units after a boot loader.
//!
//! The start code calls `__pre_init` before it touches the memory. A boot loader starts
//! the image by a jump: interrupts that it enabled, its memory protection, its floating
//! point modes and its DMA streams would otherwise go on.
//!
//! Required of a boot loader: it jumps from thread mode, privileged, and no interrupt
//! that the image uses comes between its write to VTOR and the first instruction here.

#![expect(unsafe_code, reason = "memory and stack are not ready for Rust")]

use core::arch::global_asm;

// The rest is a table of writes: address, word; a zero ends it. Numbers of the core are
// those of the ARMv7-M Architecture Reference Manual, B3.2 to B3.5, those of the clock
// unit of RM0090, 7.3.5 to 7.3.9.
global_asm!(
    ".section .text.__pre_init, \"ax\", %progbits",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "cpsid i",
    "movs r0, #0",
    "msr basepri, r0",
    "cpsie f",
    // The main stack, no floating point context to be kept.
    "msr control, r0",
    "isb",
    "ldr r0, =entry_table",
    "1:",
    "ldr r1, [r0], #4",
    "cbz r1, 2f",
    "ldr r2, [r0], #4",
    "str r2, [r1]",
    "b 1b",
    "2:",
    "dsb",
    "isb",
    // Rounding to the nearest, no flush to zero; the unit was switched on by the table.
    "vmsr fpscr, r1",
    "bx lr",
    ".ltorg",
    ".size __pre_init, . - __pre_init",
    ".section .rodata.entry_table, \"a\", %progbits",
    ".balign 4",
    "entry_table:",
    // SysTick stops.
    ".word 0xe000e010, 0",
    // The memory protection unit is off, none of its eight regions is.
    ".word 0xe000ed94, 0",
    ".irp region, 0, 1, 2, 3, 4, 5, 6, 7",
    ".word 0xe000ed98, \\region, 0xe000eda0, 0",
    ".endr",
    // Units are reset and released: AHB1's DMA, AHB2, AHB3, all of APB1 but the power
    // control, all of APB2. The ports are not: pins that float switch the robot off.
    ".word 0x40023810, 0x22601000, 0x40023810, 0",
    ".word 0x40023814, 0x000000f1, 0x40023814, 0",
    ".word 0x40023818, 0x00000001, 0x40023818, 0",
    ".word 0x40023820, 0x26fec9ff, 0x40023820, 0",
    ".word 0x40023824, 0x00075933, 0x40023824, 0",
    // No interrupt is enabled, none pending; 82 lines.
    ".word 0xe000e180, 0xffffffff, 0xe000e184, 0xffffffff, 0xe000e188, 0xffffffff",
    ".word 0xe000e280, 0xffffffff, 0xe000e284, 0xffffffff, 0xe000e288, 0xffffffff",
    // Nor are PendSV and SysTick.
    ".word 0xe000ed04, 0x0a000000",
    // Every priority is a group, no sleep but WFI's, the traps of a reset.
    ".word 0xe000ed0c, 0x05fa0000",
    ".word 0xe000ed10, 0",
    ".word 0xe000ed14, 0x00000200",
    // All faults are hard faults, and none was seen.
    ".word 0xe000ed24, 0",
    ".word 0xe000ed28, 0xffffffff",
    ".word 0xe000ed2c, 0xffffffff",
    // The floating point unit: automatic and lazy stacking, nothing waits to be stacked,
    // the modes of a reset, full access.
    ".word 0xe000ef34, 0xc0000000",
    ".word 0xe000ef3c, 0",
    ".word 0xe000ed88, 0x00f00000",
    ".word 0",
);
