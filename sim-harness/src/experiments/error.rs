//! Why an experiment could not be computed.

use amiro_ipf::filter::ParameterError;

use crate::calibration::WheelFitError;
use crate::mapping::UnknownMethod;
use crate::rig::RigError;

/// Why an experiment could not be computed.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// The program lacks a method.
    #[error(transparent)]
    Method(#[from] UnknownMethod),
    /// A rig of the program is none.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// A parameter is outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The calibration determines no factors.
    #[error(transparent)]
    Calibration(#[from] WheelFitError),
}
