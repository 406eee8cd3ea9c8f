//! The flash image for AMiRo's PowerManagement board (STM32F405).
//!
//! | task | priority | released by | does | deadline when missed |
//! |---|---|---|---|---|
//! | `serial` | 4 | USART2 | moves bytes between line and queues | 5 us per byte at 2 Mbaud: the byte is lost and counted |
//! | `bus_one`, `bus_two` and their `_error` | 3 | I2C1, I2C2 | one event of the sensors' buses | 0.4 ms: the transaction is overdue, the bus is freed |
//! | `frames` | 3 | CAN1_RX0 | takes the frames of the CAN bus | three frames, 0.15 ms: the newest stays, the loss is counted |
//! | `programming` | 3 | USART1, behind AMiRo's boot loader | waits for its flashing tool | 87 us per byte at 115 200 baud: the call is missed, and sent again |
//! | `poll` | 2 | monotonic, 2 kHz | deadlines, rounds of the sensors, frames to send | the next poll keeps its time |
//! | `heartbeat` | 2 | monotonic, 8 Hz | LED, requests a status and the own tick, feeds the watchdog | the next heartbeat keeps its time; 340 ms: a reset |
//! | `run` | 1 | received bytes, readings, heartbeats | the portable program, steps included | a heartbeat later: counted as overrun |
//!
//! Interrupts move bytes; `run` does the work. One step runs at a time and is never
//! interrupted by another: what arrives meanwhile waits in the queue.
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
mod requests;
#[cfg(target_os = "none")]
mod sampler;

#[cfg(not(target_os = "none"))]
mod host;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    host::print_budget()
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, dispatchers = [TIM8_CC])]
mod app {
    use core::mem::MaybeUninit;

    use amiro_ipf::board::acquisition::Bus;
    use amiro_ipf::board::budget::CAPACITY;
    use amiro_ipf::board::supervision::{ProgrammingPort, Task};
    use amiro_ipf::filter::ParticleSet;
    use rtic_monotonics::systick::prelude::*;
    use stm32f4xx_hal::pac::{Interrupt, USART1};

    use crate::clock::{HEARTBEATS, Microseconds, Mono};
    use crate::hal::{Led, StartedBoard, Watchdog};
    use crate::link::{Queues, SerialLine};
    use crate::program::Program;
    use crate::requests::TASKS;
    use crate::sampler::{Reports, Sampler};

    #[shared]
    struct Shared {
        sampler: Sampler,
    }

    #[local]
    struct Local {
        line: SerialLine,
        program: &'static mut Program,
        led: Led,
        watchdog: Watchdog,
        port: Option<USART1>,
    }

    #[init(local = [
        particles: ParticleSet<CAPACITY> = ParticleSet::new(),
        queues: Queues = Queues::new(),
        reports: Reports = Reports::new(),
        program_place: MaybeUninit<Program> = MaybeUninit::uninit(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board = StartedBoard::start(cx.device, cx.core);
        let boot = board.boot_info.boot;
        defmt::info!("up: {}", boot);
        let (line, inbox, outbox) = cx.local.queues.split(board.usart);
        let (report, reported) = cx.local.reports.split();
        let clock = Microseconds::new(boot.core_hz);
        let sampler = Sampler::new(board.acquisition, clock, report);
        let ends = (reported, inbox, outbox);
        // Moved once: each move of 3 kB would take stack.
        let program = Program::new(cx.local.particles, &board.boot_info, ends);
        let program = cx.local.program_place.write(program);
        program.start(&board.boot_info);
        let (led, port) = (board.led, board.programming_port);
        let mut watchdog = board.watchdog;
        // The first spawn of a task cannot fail.
        heartbeat::spawn().ok();
        poll::spawn().ok();
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

    /// Moves bytes. Releases `run` for every received byte and when there is room again.
    #[task(binds = USART2, priority = 4, local = [line])]
    fn serial(cx: serial::Context) {
        if cx.local.line.move_bytes() {
            rtic::pend(Interrupt::TIM8_UP_TIM13);
        }
    }

    /// Serves an event of the first sensor bus.
    #[task(binds = I2C1_EV, priority = 3, shared = [sampler])]
    fn bus_one(mut cx: bus_one::Context) {
        cx.shared.sampler.lock(|it| it.on_event(Bus::I2c1));
    }

    /// Serves an error of the first sensor bus.
    #[task(binds = I2C1_ER, priority = 3, shared = [sampler])]
    fn bus_one_error(mut cx: bus_one_error::Context) {
        cx.shared.sampler.lock(|it| it.on_error(Bus::I2c1));
    }

    /// Serves an event of the second sensor bus.
    #[task(binds = I2C2_EV, priority = 3, shared = [sampler])]
    fn bus_two(mut cx: bus_two::Context) {
        cx.shared.sampler.lock(|it| it.on_event(Bus::I2c2));
    }

    /// Serves an error of the second sensor bus.
    #[task(binds = I2C2_ER, priority = 3, shared = [sampler])]
    fn bus_two_error(mut cx: bus_two_error::Context) {
        cx.shared.sampler.lock(|it| it.on_error(Bus::I2c2));
    }

    /// Takes the received frames of the CAN bus.
    #[task(binds = CAN1_RX0, priority = 3, shared = [sampler])]
    fn frames(mut cx: frames::Context) {
        cx.shared.sampler.lock(Sampler::on_frames);
    }

    /// Serves deadlines and rounds, 2000 times per second.
    #[task(priority = 2, shared = [sampler])]
    async fn poll(mut cx: poll::Context) {
        let mut next = Mono::now();
        loop {
            cx.shared.sampler.lock(Sampler::poll);
            TASKS.check_in(Task::Poll);
            next += 500.micros();
            Mono::delay_until(next).await;
        }
    }

    /// Resets into the boot loader when AMiRo's flashing tool calls.
    #[task(binds = USART1, priority = 3, local = [port, call: ProgrammingPort = ProgrammingPort::new()])]
    fn programming(cx: programming::Context) {
        let Some(port) = cx.local.port else { return };
        if cx.local.call.completes_call(crate::link::take_byte(port)) {
            cortex_m::peripheral::SCB::sys_reset();
        }
    }

    /// Toggles the LED, requests a status and feeds the watchdog if all tasks have checked
    /// in, 8 times per second.
    #[task(priority = 2, local = [led, watchdog])]
    async fn heartbeat(cx: heartbeat::Context) {
        let mut next = Mono::now();
        loop {
            cx.local.led.toggle();
            HEARTBEATS.count();
            TASKS.check_in(Task::Heartbeat);
            if TASKS.all_checked_in() {
                cx.local.watchdog.feed();
            }
            rtic::pend(Interrupt::TIM8_UP_TIM13);
            next += 125.millis();
            Mono::delay_until(next).await;
        }
    }

    /// The portable program: heartbeats first, then the robot's readings, then the host's
    /// inputs while their events have room.
    #[task(binds = TIM8_UP_TIM13, priority = 1, local = [program])]
    fn run(cx: run::Context) {
        cx.local.program.run();
    }
}
