//! A line that does what serial lines do on bad days.

mod chance;
mod faults;
mod lossy;

pub use faults::{LineFault, LineFaultError, LineFaults, Window};
pub use lossy::{LineTally, LossyLine};
