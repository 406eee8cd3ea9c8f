//! What the firmware binary says when it is run on a host.

use amiro_ipf::config::Config;
use amiro_ipf::filter::ParticleSet;
use amiro_ipf::wire::MAX_FRAME;

use crate::budget::{CAPACITY, INPUT_ROOM, RECEIVE_QUEUE, REPORT_QUEUE, RESERVE, SEND_QUEUE};

/// Prints the memory that the image spends on purpose.
///
/// Only types without pointers and machine-sized integers are listed, so the figures
/// are the target's; the rest of the image is read from the ELF (`cargo ipf image`).
pub(crate) fn print_budget() {
    const RAM: usize = 128 * 1024;
    let particles = core::mem::size_of::<ParticleSet<CAPACITY>>();
    let send_queue = SEND_QUEUE * (MAX_FRAME + 4);
    let left = RAM - particles - send_queue - RECEIVE_QUEUE;
    println!("amiro-ipf firmware, memory budget of the STM32F405 image");
    println!("{particles:>8} bytes  particle set: {CAPACITY} particles of 8 bytes");
    println!(
        "{send_queue:>8} bytes  send queue: {SEND_QUEUE} frames of {MAX_FRAME} bytes and a length;"
    );
    println!(
        "{:>15} {INPUT_ROOM} for the events of one input, {RESERVE} of them in reserve",
        ""
    );
    println!("{RECEIVE_QUEUE:>8} bytes  receive queue");
    println!(
        "{:>8} places report queue: readings, poses and health for the program",
        REPORT_QUEUE - 1
    );
    println!("{left:>8} bytes  left of {RAM} for stack and the rest");
    println!();
    println!("configuration at boot: {:#?}", Config::default());
}
