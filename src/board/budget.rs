//! Sizes of the image's statics, for the image and for the budget it prints.

/// Particles that fit: 8 sensors x 1000.
pub const CAPACITY: usize = 8000;

/// Places of the send queue; one stays empty.
pub const SEND_QUEUE: usize = 240;

/// Bytes of the receive queue: twice the window of 8 frames of 144.
pub const RECEIVE_QUEUE: usize = 2304;

/// Places that particle frames leave for everything else.
pub const RESERVE: usize = 24;

/// Places in which all frames of any one input fit: 211 of particles for 8000
/// outcomes, the step's begin and end, the answer.
pub const INPUT_ROOM: usize = CAPACITY.div_ceil(crate::node::BATCH) + RESERVE;

/// Places of the queue of readings, poses and health reports to `run`; one stays empty.
/// 125 readings, 16 poses and 8 reports per second are 19 in the longest step.
pub const REPORT_QUEUE: usize = 24;

const _: () = assert!(INPUT_ROOM < SEND_QUEUE);
