//! Sizes of the image's statics: one place for the board and for the budget it prints.

/// Particles that fit: 8 sensors x 1000.
pub(crate) const CAPACITY: usize = 8000;

/// Frames that wait to be sent, one place less than this.
pub(crate) const SEND_QUEUE: usize = 256;

/// Bytes received and not yet looked at: twice the window of 8 frames of 128.
pub(crate) const RECEIVE_QUEUE: usize = 2048;

/// Places that particle frames leave for everything else.
pub(crate) const RESERVE: usize = 24;

/// Places in which all frames of any one input fit: 211 of particles for 8000
/// outcomes, the step's begin and end, the answer.
pub(crate) const INPUT_ROOM: usize = CAPACITY.div_ceil(amiro_ipf::event::BATCH) + RESERVE;

/// Readings, poses and health reports on their way to `think`, one place less than
/// this: 125 readings, 16 poses and 8 reports a second are 19 in the longest step.
pub(crate) const REPORT_QUEUE: usize = 32;

const _: () = assert!(INPUT_ROOM < SEND_QUEUE);
const _: () =
    assert!(RECEIVE_QUEUE >= 2 * amiro_ipf::wire::WINDOW as usize * amiro_ipf::wire::MAX_FRAME);
