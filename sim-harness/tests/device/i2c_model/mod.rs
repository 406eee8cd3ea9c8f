//! A bus of the board on a host: the F405's I2C unit, a part, and time.

mod bench;
mod part;
mod unit;

pub(crate) use bench::{Bench, PATROL_NS};
pub(crate) use part::{Part, Seen};
pub(crate) use unit::{FOR_EVER, Fault, Stuck, Unit};
