// The README shows the feature `async`, so its examples are tested only with it.
#![cfg_attr(
    any(feature = "async", not(doctest)),
    doc = include_str!("../README.md")
)]
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing)
)]

#[cfg(feature = "async")]
mod asynchronous;
mod blocking;
mod error;
pub mod registers;
pub mod sequences;
pub mod transactions;

#[cfg(feature = "async")]
pub use asynchronous::Vcnl4020Async;
pub use blocking::Vcnl4020;
pub use error::Error;
pub use registers::{
    ADDRESS, Ambient, AmbientRate, Command, Compared, Configuration, IDENTITY, InterruptControl,
    InterruptStatus, LUX_PER_COUNT, LedCurrent, Measurement, ProximityRate, SATURATED,
};
pub use sequences::{Sequence, Step};
pub use transactions::{LONGEST_READ, LONGEST_WRITE, Transaction};
