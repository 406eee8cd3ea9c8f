//! The flash image for AMiRo's PowerManagement board (STM32F405).
//!
//! | task | priority | released by | does | deadline when missed |
//! |---|---|---|---|---|
//! | `bytes` | 4 | USART2 | moves bytes between line and queues | 5 us a byte at 2 Mbaud: the byte is lost and counted |
//! | `bus_one`, `bus_two` and their `_error` | 3 | I2C1, I2C2 | one event of the sensors' buses | 0.4 ms: the transaction is overdue, the bus is freed |
//! | `frames` | 3 | CAN1_RX0 | takes the frames of the robot's bus | three frames, 0.15 ms: the newest stays, the loss is counted |
//! | `programming` | 3 | USART1, behind AMiRo's boot loader | listens for its flashing tool | 87 us a byte at 115 200 baud: the call is missed, and sent again |
//! | `patrol` | 2 | monotonic, 2 kHz | deadlines, rounds of the sensors, frames to send | the next patrol keeps its time |
//! | `beat` | 2 | monotonic, 8 Hz | LED, calls for a status and the own tick, feeds the watchdog | the next beat keeps its time; 340 ms: a reset |
//! | `think` | 1 | received bytes, readings, beats | the portable program, steps included | a beat later: counted as overrun |
//!
//! Interrupts move bytes; `think` thinks. One step runs at a time and is never
//! interrupted by another: whatever arrives meanwhile waits in the queue.
//!
//! Built for a host, the binary prints its memory budget.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod clock;
#[cfg(target_os = "none")]
mod hal;
#[cfg(target_os = "none")]
mod link;
#[cfg(target_os = "none")]
mod panic;
#[cfg(target_os = "none")]
mod program;
#[cfg(target_os = "none")]
mod sampler;
#[cfg(target_os = "none")]
mod watch;

#[cfg(not(target_os = "none"))]
mod host;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    host::print_budget()
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, dispatchers = [TIM8_CC])]
mod app {
    use amiro_ipf::board::acquisition::Bus;
    use amiro_ipf::board::budget::CAPACITY;
    use amiro_ipf::board::supervision::{ProgrammingPort, Task};
    use amiro_ipf::filter::ParticleSet;
    use rtic_monotonics::systick::prelude::*;
    use stm32f4xx_hal::pac::{Interrupt, USART1};

    use crate::clock::{BEATS, Microseconds, Mono};
    use crate::hal::{Board, Led, Watchdog};
    use crate::link::{Line, Queues};
    use crate::program::Program;
    use crate::sampler::{Reports, Sampler};
    use crate::watch::ROLL;

    #[shared]
    struct Shared {
        sampler: Sampler,
    }

    #[local]
    struct Local {
        line: Line,
        program: Program,
        led: Led,
        watchdog: Watchdog,
        port: Option<USART1>,
    }

    #[init(local = [
        particles: ParticleSet<CAPACITY> = ParticleSet::new(),
        queues: Queues = Queues::new(),
        reports: Reports = Reports::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board = Board::start(cx.device, cx.core);
        let boot = board.introduction.boot;
        defmt::info!("up: {}", boot);
        let (line, inbox, outbox) = cx.local.queues.split(board.usart);
        let (report, reported) = cx.local.reports.split();
        let clock = Microseconds::new(boot.core_hz);
        let sampler = Sampler::new(board.senses, clock, report);
        let ends = (reported, inbox, outbox);
        let program = Program::start(cx.local.particles, board.introduction, ends);
        let (led, port) = (board.led, board.programming_port);
        let mut watchdog = board.watchdog;
        // The first spawn of a task cannot fail.
        beat::spawn().ok();
        patrol::spawn().ok();
        rtic::pend(Interrupt::USART2);
        watchdog.start();
        board.start_line.release();
        let local = Local {
            line,
            program,
            led,
            watchdog,
            port,
        };
        (Shared { sampler }, local)
    }

    /// Sleeps until the next interrupt.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        crate::hal::repaint_stack();
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
            ROLL.report(Task::Patrol);
            next += 500.micros();
            Mono::delay_until(next).await;
        }
    }

    /// Listens for the call of AMiRo's flashing tool, and starts over into the boot
    /// loader when it comes.
    #[task(binds = USART1, priority = 3, local = [port, call: ProgrammingPort = ProgrammingPort::new()])]
    fn programming(cx: programming::Context) {
        let Some(port) = cx.local.port else { return };
        if cx.local.call.hears(crate::link::take_byte(port)) {
            cortex_m::peripheral::SCB::sys_reset();
        }
    }

    /// Shows life, calls for a status and feeds the watchdog if all tasks live, eight
    /// times a second.
    #[task(priority = 2, local = [led, watchdog])]
    async fn beat(cx: beat::Context) {
        let mut next = Mono::now();
        loop {
            cx.local.led.toggle();
            BEATS.count();
            ROLL.report(Task::Beat);
            if ROLL.call() {
                cx.local.watchdog.feed();
            }
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
