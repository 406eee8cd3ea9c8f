//! One I2C bus with a multiplexer and up to four proximity sensors behind it.
//!
//! [`MuxedBus`] says which transaction comes next and is told its result; it neither
//! waits nor knows what executes it. Nothing is believed that the multiplexer does not
//! vouch for: it is read back after each selection and again after each reading, and a
//! reading counts only if it named the sensor's channel both times.
//!
//! # A round
//!
//! | step | transaction | clocks |
//! |---|---|---|
//! | select the channel, read it back | 2 + 2 bytes | 40 |
//! | read the command register: does it still measure, is a result ready? | 4 | 39 |
//! | read both results | 7 | 66 |
//! | read proximity again: another value means that it changed meanwhile | 5 | 48 |
//! | read the multiplexer back | 2 | 20 |
//!
//! 213 clocks a sensor, 852 a round: 2.13 ms at 400 kHz. At 100 kHz it is 8.52 ms, more
//! than the 8 ms of 125 rounds a second.
//!
//! **Torn values.** The part clears its ready bit when either byte of the result is
//! read, so a result that arrives between the two leaves no trace in it. Equal values
//! in two reads are whole, whichever update came between; of unequal ones the next read
//! is, since updates lie 8 ms apart.
//!
//! **Second visits.** A sensor that failed, or had nothing new, is visited once more
//! after the others. A result that comes just after its sensor's visit is so not a
//! round late. No second visit begins later than [`SECOND_READOUTS_UNTIL_US`].
//!
//! **Errors.** After any error the multiplexer's selection is unknown; all channels are
//! deselected, which is read back, before anything else is said. When that fails the
//! round is over. When a line is held low or a transaction did not end, it is at once.

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
