//! What the firmware binary says when it is run on a host.

use std::io::{self, Write};
use std::process::ExitCode;

use amiro_ipf::filter::ParticleSet;
use amiro_ipf::link::MAX_FRAME;
use amiro_ipf::node::Config;

use amiro_ipf::board::budget::{
    CAPACITY, INPUT_ROOM, RECEIVE_QUEUE, REPORT_QUEUE, RESERVE, SEND_QUEUE,
};

/// Prints the budget; exit code 5 if standard output cannot be written. One that was
/// closed, as `head` does, ends the printing without a message.
pub(crate) fn print_budget() -> ExitCode {
    #[expect(
        clippy::disallowed_methods,
        reason = "sim-harness is no dependency of this crate; failures are handled here"
    )]
    let (mut out, mut errors) = (io::stdout().lock(), io::stderr());
    match write_budget(&mut out).and_then(|()| out.flush()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            // There is no other place to report it.
            let _ = writeln!(errors, "standard output cannot be written: {error}");
            ExitCode::from(5)
        }
    }
}

/// Writes the memory that the image spends on purpose.
///
/// Only types without pointers and machine-sized integers are listed, so the figures
/// are the target's; the rest of the image is read from the ELF (`cargo ipf image`).
fn write_budget(out: &mut impl Write) -> io::Result<()> {
    const RAM: usize = 128 * 1024;
    let particles = core::mem::size_of::<ParticleSet<CAPACITY>>();
    let send_queue = SEND_QUEUE * (MAX_FRAME + 4);
    let left = RAM - particles - send_queue - RECEIVE_QUEUE;
    writeln!(
        out,
        "amiro-ipf firmware, memory budget of the STM32F405 image"
    )?;
    writeln!(
        out,
        "{particles:>8} bytes  particle set: {CAPACITY} particles of 8 bytes"
    )?;
    writeln!(
        out,
        "{send_queue:>8} bytes  send queue: {SEND_QUEUE} frames of {MAX_FRAME} bytes and a length;"
    )?;
    writeln!(
        out,
        "{:>15} {INPUT_ROOM} for the events of one input, {RESERVE} of them in reserve",
        ""
    )?;
    writeln!(out, "{RECEIVE_QUEUE:>8} bytes  receive queue")?;
    writeln!(
        out,
        "{:>8} places report queue: readings, poses and health for the program",
        REPORT_QUEUE - 1
    )?;
    writeln!(out, "{left:>8} bytes  left of {RAM} for stack and the rest")?;
    writeln!(out)?;
    writeln!(out, "configuration at boot: {:#?}", Config::default())
}
