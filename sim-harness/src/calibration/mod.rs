//! The photometric law fitted to a table of measured counts.
//!
//! [`Table`] has the measurements, [`Fixed`] the known parameters, [`Law`] the least
//! squares problem, [`Fit`] the answer: parameters, their standard errors, residuals.
//! Apart from it, [`fit_wheels`] fits the factors of a differential drive.

mod estimate;
mod fit;
mod fixed;
mod law;
mod parameter;
mod report;
mod start;
mod table;
mod wheels;

pub use estimate::{Estimate, Fit, Origin};
pub use fit::{FitError, fit};
pub use fixed::{Fixed, FixedError};
pub use law::Law;
pub use parameter::Parameter;
pub use table::{CalibrationPoint, Table, TableError, TableProblem};
pub use wheels::{WheelFit, WheelFitError, WheelSegment, fit_wheels};
