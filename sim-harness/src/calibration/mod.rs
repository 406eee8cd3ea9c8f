//! The photometric law fitted to a table of measured counts.
//!
//! [`Table`] has the measurements, [`Fixed`] the known parameters, [`Law`] the least
//! squares problem, [`Fit`] the answer: parameters, their standard errors, residuals.

mod estimate;
mod fit;
mod fixed;
mod law;
mod parameter;
mod report;
mod start;
mod table;

pub use estimate::{Estimate, Fit, Origin};
pub use fit::{FitError, fit};
pub use fixed::{Fixed, FixedError};
pub use law::Law;
pub use parameter::Parameter;
pub use table::{CalibrationPoint, Table, TableError, TableProblem};
