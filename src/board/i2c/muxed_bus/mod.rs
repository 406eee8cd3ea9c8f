//! Reads four proximity sensors behind the multiplexer of one I2C bus.
//!
//! [`MuxedBus`] gives the next transaction and takes its result; something else executes
//! it. The multiplexer is read back after each selection and again after each reading. A
//! reading counts only if the multiplexer named the sensor's channel both times.
//!
//! # A round
//!
//! A round reads each sensor once. The readout of a sensor is:
//!
//! | step | transaction | clocks |
//! |---|---|---|
//! | select the channel, read it back | 2 + 2 bytes | 40 |
//! | read the command register: does it still measure, is a result ready? | 4 | 39 |
//! | read both results | 7 | 66 |
//! | read proximity again: another value means that it changed meanwhile | 5 | 48 |
//! | read the multiplexer back | 2 | 20 |
//!
//! 213 clocks per sensor, 852 per round: 2.13 ms at 400 kHz. At 100 kHz it is 8.52 ms, more
//! than the 8 ms of 125 rounds per second.
//!
//! **Torn values.** The part clears its ready bit when either byte of the result is
//! read, so a result that arrives between the two leaves no trace in it. Equal values
//! in two reads are whole, whichever update came between; of unequal ones the next read
//! is whole, since updates lie 8 ms apart.
//!
//! **Second pass.** A sensor that failed, or had no new result, is read once more after
//! the others. A result that comes just after its sensor's readout is therefore not a
//! round late. No readout of the second pass begins later than
//! [`SECOND_READOUTS_UNTIL_US`].
//!
//! **Errors.** After an error the multiplexer's selection is unknown. All channels are
//! deselected, and that is read back, before anything else happens. If that fails, the
//! round ends. It ends at once if a line is held low or a transaction did not end.

mod channels;
mod counters;
mod sequence;
mod settings;
mod timing;

pub use counters::MuxedBusCounters;
pub use sequence::MuxedBus;
pub use settings::{MUX_ADDRESS, SENSOR_CONFIGURATION};
pub use timing::{
    LONGEST_FIRST_PASS_CLOCKS, ROUND_PERIOD_US, SECOND_READOUTS_UNTIL_US, USUAL_ROUND_CLOCKS,
    longest_round_us,
};

#[cfg(test)]
mod tests;
