//! What the sampling costs the core: the flash image's own sampler at scripted registers.
//!
//! Everything between the interrupts' entries and the queue to `think` is the image's:
//! `Sampler`, `Senses`, both I2C masters, the controller of the robot's bus, the clock.
//! Only the registers are memory, one load or store an access as on silicon, and what is
//! at the other end of them runs outside of the counted calls. All eight sensors deliver
//! for 1000 rounds; the wheels' odometry and speed come in and the ring's frames go out
//! sixteen times a second.
//!
//! Says on USART2 how many counts of the 168 MHz timer each kind of call took, then
//! resets. In an emulator that executes one instruction a nanosecond 168 counts are 1000
//! instructions; on a board they would be cycles. `cargo test --test firmware sampling::` runs it
//! and holds the table in docs/hardware.md against it. By hand, in one line:
//!
//! ```text
//! cargo run --release --target thumbv7em-none-eabihf --example sampling --config 'target.thumbv7em-none-eabihf.runner="qemu-system-arm -M netduinoplus2 -icount shift=0,sleep=off -no-reboot -display none -monitor none -serial null -serial stdio -kernel"'
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod bench;
#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod parts;

#[cfg(target_os = "none")]
#[expect(dead_code, reason = "the program's part of it is not here")]
#[path = "../../../src/bin/firmware/clock.rs"]
mod clock;
#[cfg(target_os = "none")]
#[expect(
    dead_code,
    unreachable_pub,
    reason = "the program's part of it is not here"
)]
#[path = "../../../src/bin/firmware/sampler.rs"]
mod sampler;
#[cfg(target_os = "none")]
#[expect(dead_code, reason = "the program's part of it is not here")]
#[path = "../../../src/bin/firmware/watch.rs"]
mod watch;

#[cfg(not(target_os = "none"))]
fn main() {}
