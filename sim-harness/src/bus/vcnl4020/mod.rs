//! VCNL4020: proximity and ambient light, behind seventeen registers.

mod cadence;
mod optical_input;
mod part;
mod registers;
mod thresholds;

pub use part::Vcnl4020Model;
