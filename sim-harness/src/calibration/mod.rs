//! The laws of a sensor fitted to a table of measured counts.
//!
//! [`Table`] has the measurements, [`Fixed`] the known parameters, [`Law`] the least
//! squares problem, [`Fit`] the answer: parameters, their standard errors, residuals.
//! [`LawComparison`] fits the law of small and that of extended surfaces and decides which
//! explains the table better.
//!
//! [`DriveGains`] are the gains of the sensors of a ring as recorded drives give them, and
//! [`GainFile`] what is written of them.
//!
//! Apart from it, [`fit_wheels`] fits the factors of a differential drive.

mod drive_gains;
mod estimate;
mod fit;
mod fixed;
mod gain_file;
mod law;
mod law_comparison;
mod odometry_drive;
mod parameter;
mod report;
mod start;
mod table;
mod wheels;

pub use drive_gains::{DriveGainError, DriveGainSettings, DriveGains};
pub use estimate::{Estimate, Fit, Origin};
pub use fit::{FitError, fit, fit_law};
pub use fixed::{Fixed, FixedError};
pub use gain_file::{GainFile, GainFileError};
pub use law::{Law, LawKind};
pub use law_comparison::{LawComparison, LawVerdict};
pub use odometry_drive::{OdometryDrive, OdometryEnds};
pub use parameter::Parameter;
pub use table::{CalibrationPoint, Table, TableError, TableProblem};
pub use wheels::{WheelFit, WheelFitError, WheelSegment, fit_wheels};
