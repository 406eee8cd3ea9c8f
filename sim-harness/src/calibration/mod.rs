//! The laws of a sensor fitted to a table of measured counts.
//!
//! [`Table`] has the measurements, [`Fixed`] the known parameters, [`Law`] the least
//! squares problem, [`Fit`] the answer: parameters, their standard errors, residuals.
//! [`LawComparison`] fits the law of small and that of extended surfaces and decides which
//! explains the table better.

mod estimate;
mod fit;
mod fixed;
mod law;
mod law_comparison;
mod parameter;
mod report;
mod start;
mod table;

pub use estimate::{Estimate, Fit, Origin};
pub use fit::{FitError, fit, fit_law};
pub use fixed::{Fixed, FixedError};
pub use law::{Law, LawKind};
pub use law_comparison::{LawComparison, Verdict};
pub use parameter::Parameter;
pub use table::{CalibrationPoint, Table, TableError, TableProblem};
