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
mod change;
mod control;
mod error;
pub mod transactions;

#[cfg(feature = "async")]
pub use asynchronous::Pca9544aAsync;
pub use blocking::Pca9544a;
pub use change::{Change, confirm};
pub use control::{Address, Channel, Interrupts, Selection};
pub use error::Error;
pub use transactions::Transaction;
