//! Sizes of the image's statics: one place for the board and for the budget it prints.

/// Particles that fit: 8 sensors x 1000.
pub const CAPACITY: usize = 8000;

/// Frames that wait to be sent, one place less than this.
pub const SEND_QUEUE: usize = 256;

/// Bytes received and not yet looked at: twice the window of 8 frames of 128.
pub const RECEIVE_QUEUE: usize = 2048;

/// Places that particle frames leave for everything else.
pub const RESERVE: usize = 24;

/// Places in which all frames of any one input fit: 211 of particles for 8000
/// outcomes, the step's begin and end, the answer.
pub const INPUT_ROOM: usize = CAPACITY.div_ceil(crate::node::BATCH) + RESERVE;

/// Readings, poses and health reports on their way to `think`, one place less than
/// this: 125 readings, 16 poses and 8 reports a second are 19 in the longest step.
pub const REPORT_QUEUE: usize = 32;

const _: () = assert!(INPUT_ROOM < SEND_QUEUE);
const _: () = assert!(RECEIVE_QUEUE >= 2 * crate::link::WINDOW as usize * crate::link::MAX_FRAME);
