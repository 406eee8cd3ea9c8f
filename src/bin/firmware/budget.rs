//! Sizes of the image's statics: one place for the board and for the budget it prints.

/// Particles that fit: 8 sensors x 1000.
pub(crate) const CAPACITY: usize = 8000;

/// Bytes waiting to be sent. A whole step of 8000 outcomes takes 211 frames of 128
/// bytes, 27 008, and must fit beside the reserve.
pub(crate) const SEND_QUEUE: usize = 32_768;

/// Bytes received and not yet looked at: twice the window of 8 frames of 128.
pub(crate) const RECEIVE_QUEUE: usize = 2048;

/// Room that particle frames leave for everything else.
pub(crate) const RESERVE: usize = 1024;

/// Room in which all frames of any one input fit.
pub(crate) const INPUT_ROOM: usize = 27_008 + RESERVE;

const _: () = assert!(INPUT_ROOM < SEND_QUEUE);
const _: () =
    assert!(RECEIVE_QUEUE >= 2 * amiro_ipf::wire::WINDOW as usize * amiro_ipf::wire::MAX_FRAME);
