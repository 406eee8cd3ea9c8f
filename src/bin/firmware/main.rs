//! The flash image for AMiRo's PowerManagement board (STM32F405).
//!
//! | task | priority | released by | does | deadline when missed |
//! |---|---|---|---|---|
//! | `bytes` | 4 | USART2 | moves bytes between line and queues | 5 us a byte at 2 Mbaud: the byte is lost and counted |
//! | `bus_one`, `bus_two` and their `_error` | 3 | I2C1, I2C2 | one event of the sensors' buses | 0.4 ms: the transaction is overdue, the bus is freed |
//! | `frames` | 3 | CAN1_RX0 | takes the frames of the robot's bus | three frames, 0.15 ms: the newest stays, the loss is counted |
//! | `patrol` | 2 | monotonic, 2 kHz | deadlines, rounds of the sensors, frames to send | the next patrol keeps its time |
//! | `beat` | 2 | monotonic, 8 Hz | LED, calls for a status and the own tick | the next beat keeps its time |
//! | `think` | 1 | received bytes, readings, beats | the portable program, steps included | a beat later: counted as overrun |
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
mod can;
#[cfg(target_os = "none")]
mod clock;
#[cfg(target_os = "none")]
mod i2c;
#[cfg(target_os = "none")]
mod link;
#[cfg(target_os = "none")]
mod panic;
#[cfg(target_os = "none")]
mod program;
#[cfg(target_os = "none")]
mod sampler;

#[cfg(not(target_os = "none"))]
mod host;

#[cfg(not(target_os = "none"))]
fn main() {
    host::print_budget();
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, dispatchers = [TIM8_CC])]
mod app {
    use amiro_ipf::driver::Bus;
    use amiro_ipf::filter::ParticleSet;
    use rtic_monotonics::systick::prelude::*;
    use stm32f4xx_hal::pac::Interrupt;

    use crate::board::{Board, Led};
    use crate::budget::CAPACITY;
    use crate::clock::{BEATS, Microseconds, Mono};
    use crate::link::{Line, Queues};
    use crate::program::Program;
    use crate::sampler::{Reports, Sampler};

    #[shared]
    struct Shared {
        sampler: Sampler,
    }

    #[local]
    struct Local {
        line: Line,
        program: Program,
        led: Led,
    }

    #[init(local = [
        particles: ParticleSet<CAPACITY> = ParticleSet::new(),
        queues: Queues = Queues::new(),
        reports: Reports = Reports::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board = Board::start(cx.device, cx.core.SYST);
        let (line, inbox, outbox) = cx.local.queues.split(board.usart);
        let boot = (board.boot, board.boot_id);
        let (report, reported) = cx.local.reports.split();
        let (seed, seed_source) = board.seed;
        let clock = Microseconds::new(board.boot.core_hz);
        let (one, two, can) = (board.bus_one, board.bus_two, board.can);
        let sampler = Sampler::new(one, two, can, seed_source, clock, report);
        let ends = (inbox, outbox);
        let program = Program::start(cx.local.particles, boot, seed, reported, ends);
        defmt::info!("up: {}", board.boot);
        // The first spawn of a task cannot fail.
        beat::spawn().ok();
        patrol::spawn().ok();
        rtic::pend(Interrupt::USART2);
        let led = board.led;
        (Shared { sampler }, Local { line, program, led })
    }

    /// Sleeps until the next interrupt.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Moves bytes. Wakes `think` for every byte that came and when there is room again.
    #[task(binds = USART2, priority = 4, local = [line])]
    fn bytes(cx: bytes::Context) {
        if cx.local.line.move_bytes() {
            rtic::pend(Interrupt::TIM8_UP_TIM13);
        }
    }

    /// Moves the transaction on the first bus of sensors.
    #[task(binds = I2C1_EV, priority = 3, shared = [sampler])]
    fn bus_one(mut cx: bus_one::Context) {
        cx.shared.sampler.lock(|it| it.on_event(Bus::I2c1));
    }

    /// Ends a transaction there that went wrong.
    #[task(binds = I2C1_ER, priority = 3, shared = [sampler])]
    fn bus_one_error(mut cx: bus_one_error::Context) {
        cx.shared.sampler.lock(|it| it.on_error(Bus::I2c1));
    }

    /// Moves the transaction on the second bus of sensors.
    #[task(binds = I2C2_EV, priority = 3, shared = [sampler])]
    fn bus_two(mut cx: bus_two::Context) {
        cx.shared.sampler.lock(|it| it.on_event(Bus::I2c2));
    }

    /// Ends a transaction there that went wrong.
    #[task(binds = I2C2_ER, priority = 3, shared = [sampler])]
    fn bus_two_error(mut cx: bus_two_error::Context) {
        cx.shared.sampler.lock(|it| it.on_error(Bus::I2c2));
    }

    /// Takes the frames of the robot's bus.
    #[task(binds = CAN1_RX0, priority = 3, shared = [sampler])]
    fn frames(mut cx: frames::Context) {
        cx.shared.sampler.lock(Sampler::on_frames);
    }

    /// Looks after deadlines and rounds, two thousand times a second.
    #[task(priority = 2, shared = [sampler])]
    async fn patrol(mut cx: patrol::Context) {
        let mut next = Mono::now();
        loop {
            cx.shared.sampler.lock(Sampler::patrol);
            next += 500.micros();
            Mono::delay_until(next).await;
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

    /// The portable program: beats first, then the robot's readings, then the host's
    /// inputs while their events have room.
    #[task(binds = TIM8_UP_TIM13, priority = 1, local = [program])]
    fn think(cx: think::Context) {
        cx.local.program.think();
    }
}
