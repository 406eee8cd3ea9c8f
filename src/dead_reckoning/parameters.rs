//! Parameters of the Kalman filter, checked and prepared.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::{CorrectedDrive, WheelCorrection};
use crate::filter::ParameterError;
use crate::model::DifferentialDrive;

/// Parameters of dead reckoning. \[IPM\] prints none of the values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DeadReckoningParameters {
    /// Wheels and track, with their factors (b, k1 to k3); the track is 0.01 to 10 m.
    pub drive: CorrectedDrive,
    /// Time from one step to the next, seconds (T), 0.001 to 1; constant. 0.1.
    pub period_s: f32,
    /// Standard deviation of the change of a wheel's speed per step, metres per second
    /// (root of the first elements of Q), 0 to 10. More: measured speeds are trusted more.
    /// 0.02.
    pub speed_change_m_per_s: f32,
    /// Standard deviation of the turn per step that the wheels do not show, radians (root
    /// of the last element of Q), 0 to 1. More: the compass is trusted more. 0.5 degrees.
    pub slip_rad: f32,
    /// Standard deviation of a measured wheel speed, metres per second (root of the first
    /// elements of R), 1e-4 to 10. 0.01.
    pub speed_sigma_m_per_s: f32,
    /// Standard deviation of a compass reading, radians (root of the last element of R),
    /// 1e-4 to pi. 3 degrees.
    pub compass_sigma_rad: f32,
}

impl DeadReckoningParameters {
    /// The default figures for a drive without calibration.
    #[must_use]
    pub const fn of(nominal: DifferentialDrive) -> Self {
        Self {
            drive: CorrectedDrive {
                nominal,
                correction: WheelCorrection::NONE,
            },
            period_s: 0.1,
            speed_change_m_per_s: 0.02,
            slip_rad: 0.5_f32.to_radians(),
            speed_sigma_m_per_s: 0.01,
            compass_sigma_rad: 3.0_f32.to_radians(),
        }
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// The first field that is outside its range, NaN included.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let unless = ParameterError::unless;
        let WheelCorrection { left, right, track } = self.drive.correction;
        unless(
            (0.01..=10.0).contains(&self.drive.nominal.track_m),
            "track_m",
            "0.01 to 10 m",
        )?;
        let factor = 0.5..=2.0;
        unless(factor.contains(&left), "left", "0.5 to 2")?;
        unless(factor.contains(&right), "right", "0.5 to 2")?;
        unless(factor.contains(&track), "track", "0.5 to 2")?;
        unless(
            (0.001..=1.0).contains(&self.period_s),
            "period_s",
            "0.001 to 1 s",
        )?;
        unless(
            (0.0..=10.0).contains(&self.speed_change_m_per_s),
            "speed_change_m_per_s",
            "0 to 10 m/s",
        )?;
        unless((0.0..=1.0).contains(&self.slip_rad), "slip_rad", "0 to 1")?;
        unless(
            (1e-4..=10.0).contains(&self.speed_sigma_m_per_s),
            "speed_sigma_m_per_s",
            "0.0001 to 10 m/s",
        )?;
        unless(
            (1e-4..=core::f32::consts::PI).contains(&self.compass_sigma_rad),
            "compass_sigma_rad",
            "0.0001 to pi",
        )
    }
}

/// Checked parameters with the matrices of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadReckoningModel {
    parameters: DeadReckoningParameters,
    /// F: heading' = heading + T w(v_L, v_R); the speeds stay.
    pub(super) transition: Matrix3<f32>,
    /// Q.
    pub(super) process: Matrix3<f32>,
    /// The diagonal of R.
    pub(super) measurement: Vector3<f32>,
}

impl DeadReckoningModel {
    /// Checks and prepares the parameters.
    ///
    /// # Errors
    /// The first field of the parameters that is outside its range, NaN included.
    pub fn new(parameters: DeadReckoningParameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let drive = &parameters.drive;
        let per_track = parameters.period_s / drive.true_drive().track_m;
        let WheelCorrection { left, right, .. } = drive.correction;
        let squares = |speed: f32, heading: f32| {
            Vector3::new(speed * speed, speed * speed, heading * heading)
        };
        let process = squares(parameters.speed_change_m_per_s, parameters.slip_rad);
        Ok(Self {
            transition: Matrix3::new(
                1.0,
                0.0,
                0.0,
                0.0,
                1.0,
                0.0,
                -per_track * left,
                per_track * right,
                1.0,
            ),
            process: Matrix3::from_diagonal(&process),
            measurement: squares(parameters.speed_sigma_m_per_s, parameters.compass_sigma_rad),
            parameters,
        })
    }

    /// The parameters of this model.
    #[must_use]
    pub const fn parameters(&self) -> &DeadReckoningParameters {
        &self.parameters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_legal_and_a_bad_parameter_is_named() {
        type Change = fn(&mut DeadReckoningParameters, f32);
        let good = DeadReckoningParameters::of(DifferentialDrive::AMIRO);
        assert_eq!(good.validate(), Ok(()));
        let changes: [(&str, Change); 9] = [
            ("track_m", |p, x| p.drive.nominal.track_m = x),
            ("left", |p, x| p.drive.correction.left = x),
            ("right", |p, x| p.drive.correction.right = x),
            ("track", |p, x| p.drive.correction.track = x),
            ("period_s", |p, x| p.period_s = x),
            ("speed_change_m_per_s", |p, x| p.speed_change_m_per_s = x),
            ("slip_rad", |p, x| p.slip_rad = x),
            ("speed_sigma_m_per_s", |p, x| p.speed_sigma_m_per_s = x),
            ("compass_sigma_rad", |p, x| p.compass_sigma_rad = x),
        ];
        for (name, change) in changes {
            for bad in [f32::NAN, f32::INFINITY, -0.1, 10.1] {
                let mut parameters = good;
                change(&mut parameters, bad);
                let error = DeadReckoningModel::new(parameters).unwrap_err();
                assert_eq!(error.parameter, name, "{bad}");
            }
        }
    }
}
