//! Where a board is: an emulator or a serial port.

use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

use amiro_ipf::config::Config;
use amiro_ipf::event::Event;
use amiro_ipf::supervision::{ImageCheck, Mode, Supervision};
use sim_harness::link::{
    Board, Image, Interrupt, Layout, QemuOptions, build_image, post_mortem_in_words,
};
use sim_harness::{RunError, console};

/// How long to wait for what a board says of itself once a second.
const SAID_WITHIN: Duration = Duration::from_secs(2);

/// Reaches the board that the command line names: `qemu`, or a serial port.
///
/// From now on an interrupt ends what waits for the board, in order. For the emulator the
/// image is built from these sources unless an ELF file is given.
pub(super) fn reach(
    on: &str,
    baud: u32,
    image: Option<&Path>,
    options: &QemuOptions,
) -> Result<Board, Box<dyn Error>> {
    if on != "qemu" {
        return Ok(Board::on_port(on, baud)?.ended_by(Interrupt::on_signals()?));
    }
    let image = match image {
        Some(path) => Image::read(path)?,
        None => Image::read(&build_image(Layout::Bare)?)?,
    };
    // Before the emulator is there: it is to end with this program.
    let interrupt = Interrupt::on_signals()?;
    Ok(Board::in_qemu(&image, options)?.ended_by(interrupt))
}

/// Greets a board and prints how it introduced itself, and how its last life ended.
pub(super) fn greet(board: &mut Board) -> Result<(), Box<dyn Error>> {
    let boot = board.greet()?;
    console::print(format_args!(
        "board up: build {:016x}, capacity {}, clock {:?} at {} Hz, {} baud",
        boot.build_id, boot.capacity, boot.clock, boot.core_hz, boot.baud
    ));
    if let Some(record) = board.post_mortem() {
        console::warn(post_mortem_in_words(record));
    }
    Ok(())
}

/// Whether the particles of a configuration fit into a greeted board.
pub(super) fn check_capacity(board: &Board, config: &Config) -> Result<(), RunError> {
    let capacity = board.boot().map_or(0, |boot| boot.capacity);
    // At most as many as the host's memory holds.
    sim_harness::check_capacity(config, capacity as usize)
}

/// How the image is, in a line; `None` where it does all it can.
pub(super) fn unwell(supervision: &Supervision) -> Option<String> {
    let Supervision {
        mode, reset, image, ..
    } = supervision;
    let is_well = *mode == Mode::Normal && *image != ImageCheck::Damaged;
    (!is_well).then(|| format!("the board's mode: {mode:?} (image {image:?}, reset {reset:?})"))
}

/// Waits for a board to say how its image is, and prints it if it is not well.
pub(super) fn print_unwell(board: &mut Board) {
    let deadline = Instant::now() + SAID_WITHIN;
    while Instant::now() < deadline
        && let Ok(event) = board.next_event()
    {
        if let Event::Supervision(supervision) = event {
            unwell(&supervision).iter().for_each(console::warn);
            return;
        }
    }
}
