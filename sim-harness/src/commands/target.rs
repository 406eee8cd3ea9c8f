//! Where a board is: an emulator or a serial port.

use std::error::Error;
use std::path::Path;

use sim_harness::link::{Board, Image, Layout, QemuOptions, build_image};

/// Reaches the board that the command line names: `qemu`, or a serial port.
///
/// For the emulator the image is built from these sources unless an ELF file is given.
pub(super) fn reach(
    on: &str,
    baud: u32,
    image: Option<&Path>,
    options: &QemuOptions,
) -> Result<Board, Box<dyn Error>> {
    if on != "qemu" {
        return Ok(Board::on_port(on, baud)?);
    }
    let image = match image {
        Some(path) => Image::read(path)?,
        None => Image::read(&build_image(Layout::Bare)?)?,
    };
    Ok(Board::in_qemu(&image, options)?)
}

/// Greets a board and prints how it introduced itself.
pub(super) fn greet(board: &mut Board) -> Result<(), Box<dyn Error>> {
    let boot = board.greet()?;
    println!(
        "board up: build {:016x}, capacity {}, clock {:?}, {} baud",
        boot.build_id, boot.capacity, boot.clock, boot.baud
    );
    Ok(())
}
