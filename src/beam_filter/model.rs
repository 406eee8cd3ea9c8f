//! Checked parameters of the beam filter, with what can be prepared of them.

use super::BeamFilterParameters;
use crate::filter::ParameterError;

/// The parameters of a beam filter, each in its range.
///
/// A model is `&self` in every cycle; one model can serve many filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamModel {
    parameters: BeamFilterParameters,
    pub(super) radius_squared: f32,
    pub(super) tolerance_squared: f32,
    /// e_y / l_w: change of the weight per metre of distance.
    pub(super) error_per_metre: f32,
}

impl BeamModel {
    /// Checks and prepares the parameters.
    ///
    /// # Errors
    /// The first field of the parameters that is outside its range, NaN included.
    pub fn new(parameters: BeamFilterParameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let tolerance_m = parameters.beam_tolerance_m;
        Ok(Self {
            parameters,
            radius_squared: parameters.local_radius_m * parameters.local_radius_m,
            tolerance_squared: tolerance_m * tolerance_m,
            error_per_metre: parameters.measurement_error / tolerance_m,
        })
    }

    /// The parameters of this model.
    #[must_use]
    pub const fn parameters(&self) -> &BeamFilterParameters {
        &self.parameters
    }
}
