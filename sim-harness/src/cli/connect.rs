//! Where a board is: an emulator or a serial port.

use std::error::Error;
use std::fs::File;
use std::path::Path;
use std::time::{Duration, Instant};

use amiro_ipf::board::budget::CAPACITY;
use amiro_ipf::board::supervision::{ImageCheck, Mode, Supervision};
use amiro_ipf::link::Message;
use amiro_ipf::node::Config;
use sim_harness::device::{
    Board, Image, Interrupt, Layout, QemuOptions, build_image, post_mortem_in_words,
};
use sim_harness::{RunError, console};

/// How long to wait for what a board says of itself once a second.
const SAID_WITHIN: Duration = Duration::from_secs(2);

/// Speed of a serial port if none is given, bits per second.
const BAUD: u32 = 2_000_000;

/// Checks, before the work, that the target has the options that are given: a speed is of
/// a serial port, an image and `of_emulator` (names, and whether they are given) are of
/// the emulator.
///
/// # Errors
/// An option that would do nothing; an image file that cannot be read.
pub(super) fn check(
    on: &str,
    baud: Option<u32>,
    image: Option<&Path>,
    of_emulator: &[(&str, bool)],
) -> Result<(), String> {
    let is_port = on != "qemu" && on != "host";
    if baud.is_some() && !is_port {
        return Err(format!("--baud is for a serial port, not for --on {on}"));
    }
    let image_is_given = [("--image", image.is_some())];
    let mut given = image_is_given.iter().chain(of_emulator);
    if let Some((option, _)) = given.find(|(_, is_given)| *is_given && on != "qemu") {
        return Err(format!("{option} is for --on qemu, not for --on {on}"));
    }
    let Some(image) = image else {
        return Ok(());
    };
    let failed = |error: &dyn Error| format!("--image {}: {error}", image.display());
    let file = File::open(image).map_err(|error| failed(&error))?;
    if file.metadata().is_ok_and(|found| found.is_dir()) {
        return Err(failed(&std::io::Error::from(
            std::io::ErrorKind::IsADirectory,
        )));
    }
    Ok(())
}

/// Reaches the board that the command line names: `qemu`, or a serial port.
///
/// From now on an interrupt ends what waits for the board, in order. For the emulator the
/// image is built from these sources unless an ELF file is given; the particles of `config`
/// must fit into it.
pub(super) fn reach(
    on: &str,
    baud: Option<u32>,
    image: Option<&Path>,
    options: &QemuOptions,
    config: Option<&Config>,
) -> Result<Board, Box<dyn Error>> {
    if on != "qemu" {
        return Ok(Board::on_port(on, baud.unwrap_or(BAUD))?.ended_by(Interrupt::on_signals()?));
    }
    let fits = |capacity| match (config, capacity) {
        (Some(config), Some(capacity)) => sim_harness::check_capacity(config, capacity),
        _ => Ok(()),
    };
    let image = match image {
        Some(path) => Image::read(path)?,
        None => {
            fits(Some(CAPACITY))?;
            Image::read(&build_image(Layout::Bare)?)?
        }
    };
    fits(image.capacity())?;
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
        && let Ok(message) = board.next_message()
    {
        if let Message::Supervision(supervision) = message {
            unwell(&supervision).iter().for_each(console::warn);
            return;
        }
    }
}
