//! The flash image for AMiRo's PowerManagement board (STM32F405).
//!
//! | task | priority | released by | does | deadline when missed |
//! |---|---|---|---|---|
//! | `bytes` | 3 | USART2 | moves bytes between line and queues | 5 us a byte at 2 Mbaud: the byte is lost and counted |
//! | `beat` | 2 | monotonic, 8 Hz | LED, calls for a status and the own tick | the next beat keeps its time |
//! | `think` | 1 | received bytes, beats | the portable program, steps included | a beat later: counted as overrun |
//!
//! Interrupts move bytes; `think` thinks. One step runs at a time and is never
//! interrupted by another: whatever arrives meanwhile waits in the queue.
//!
//! Built for a host, the binary prints its memory budget.

#![cfg_attr(target_os = "none", no_std, no_main)]

mod budget;

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod clock;
#[cfg(target_os = "none")]
#[expect(
    dead_code,
    unused_imports,
    reason = "nobody has transactions for the buses yet"
)]
mod i2c;
#[cfg(target_os = "none")]
mod i2c_port;
#[cfg(target_os = "none")]
mod link;
#[cfg(target_os = "none")]
mod panic;
#[cfg(target_os = "none")]
mod program;

#[cfg(not(target_os = "none"))]
mod host;

#[cfg(not(target_os = "none"))]
fn main() {
    host::print_budget();
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, dispatchers = [TIM8_CC])]
mod app {
    use amiro_ipf::filter::ParticleSet;
    use rtic_monotonics::systick::prelude::*;
    use stm32f4xx_hal::pac::Interrupt;

    use crate::board::{Board, Led};
    use crate::budget::CAPACITY;
    use crate::clock::{BEATS, Mono};
    use crate::link::{Line, Queues};
    use crate::program::Program;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        line: Line,
        program: Program,
        led: Led,
    }

    #[init(local = [particles: ParticleSet<CAPACITY> = ParticleSet::new(), queues: Queues = Queues::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board = Board::start(cx.device, cx.core.SYST);
        let (line, inbox, outbox) = cx.local.queues.split(board.usart);
        let program = Program::start(cx.local.particles, board.boot, board.boot_id, inbox, outbox);
        defmt::info!("up: {}", board.boot);
        // The first spawn of a task cannot fail.
        beat::spawn().ok();
        rtic::pend(Interrupt::USART2);
        let led = board.led;
        (Shared {}, Local { line, program, led })
    }

    /// Sleeps until the next interrupt.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Moves bytes. Wakes `think` for every byte that came and when there is room again.
    #[task(binds = USART2, priority = 3, local = [line])]
    fn bytes(cx: bytes::Context) {
        if cx.local.line.move_bytes() {
            rtic::pend(Interrupt::TIM8_UP_TIM13);
        }
    }

    /// Shows life and calls for a status, eight times a second.
    #[task(priority = 2, local = [led])]
    async fn beat(cx: beat::Context) {
        let mut next = Mono::now();
        loop {
            cx.local.led.toggle();
            BEATS.count();
            rtic::pend(Interrupt::TIM8_UP_TIM13);
            next += 125.millis();
            Mono::delay_until(next).await;
        }
    }

    /// The portable program: beats first, then inputs while their events have room.
    #[task(binds = TIM8_UP_TIM13, priority = 1, local = [program])]
    fn think(cx: think::Context) {
        cx.local.program.think();
    }
}
