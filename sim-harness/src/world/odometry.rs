//! The odometry that reaches the robot, and when.

use std::str::FromStr;

use amiro_ipf::geometry::Pose;
use amiro_ipf::random::Generator;

use super::amiro_odometry::AmiroFrame;
use super::{Drive, OptionsError, WheelErrors, WheelWalk};

/// The errors of the odometry and how it reaches the filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum OdometryModel {
    /// The true pose with every sample.
    #[default]
    Truth,
    /// A pose with every sample that errs as wheels do.
    WheelErrors(WheelErrors),
    /// As on the AMiRo's bus: the true pose as of the last 50 ms update, every
    /// 63 ms, in steps of 256 um and 256 urad.
    ///
    /// Its stamp is the time of the update, not of the frame. A frame takes no time
    /// here, but is up to 50 ms old when it comes and 63 ms older when the next one
    /// does; the node predicts the pose at a reading's stamp from the last two. Along
    /// `msod` at 80 mm/s the poses of its steps are then within 0.6 mm of the truth.
    Amiro,
    /// The same frames as of [`Amiro`](Self::Amiro) without their age: with every
    /// sample the newest frame's pose, stamped as if it were current.
    ///
    /// What is left when nothing is predicted: along `msod` the poses of the steps lag
    /// by up to 4.7 mm, and not by the 9 mm of the oldest pose, because a step begins
    /// when a new frame moves the robot on.
    AmiroUndated,
}

impl std::fmt::Display for OdometryModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Truth => f.write_str("truth"),
            Self::WheelErrors(errors) => {
                let WheelErrors {
                    scale_percent,
                    heading_deg_per_sqrt_m,
                    drift_deg_per_m,
                    slip_percent,
                } = errors;
                write!(f, "wheel-errors:{scale_percent}:{heading_deg_per_sqrt_m}")?;
                if *drift_deg_per_m != 0.0 || *slip_percent != 0.0 {
                    write!(f, ":{drift_deg_per_m}:{slip_percent}")?;
                }
                Ok(())
            }
            Self::Amiro => f.write_str("amiro"),
            Self::AmiroUndated => f.write_str("amiro-undated"),
        }
    }
}

impl FromStr for OdometryModel {
    type Err = OptionsError;

    /// The words of [`Display`](std::fmt::Display), and `wheel-errors` for the default
    /// ones. Two numbers are the scale and the random walk of the heading, two more the
    /// drift and the slips.
    fn from_str(text: &str) -> Result<Self, OptionsError> {
        match text {
            "truth" => return Ok(Self::Truth),
            "wheel-errors" => return Ok(Self::WheelErrors(WheelErrors::default())),
            "amiro" => return Ok(Self::Amiro),
            "amiro-undated" => return Ok(Self::AmiroUndated),
            _ => {}
        }
        let numbers = text.strip_prefix("wheel-errors:").map(|numbers| {
            let numbers = numbers.split(':').map(str::parse::<f64>);
            numbers.collect::<Result<Vec<_>, _>>()
        });
        let (walk, drift) = match numbers.as_ref().map(|numbers| numbers.as_deref()) {
            Some(Ok([scale, heading])) => ([*scale, *heading], [0.0; 2]),
            Some(Ok([scale, heading, drift, slip])) => ([*scale, *heading], [*drift, *slip]),
            _ => {
                let what = "truth, wheel-errors, wheel-errors:PERCENT:DEGREES, \
                            wheel-errors:PERCENT:DEGREES:DRIFT:SLIP, amiro or amiro-undated";
                return Err(OptionsError::value("odometry", text, what));
            }
        };
        let ([scale_percent, heading_deg_per_sqrt_m], [drift_deg_per_m, slip_percent]) =
            (walk, drift);
        Ok(Self::WheelErrors(WheelErrors {
            scale_percent,
            heading_deg_per_sqrt_m,
            drift_deg_per_m,
            slip_percent,
        }))
    }
}

/// The odometry of one drive.
#[derive(Clone, Debug)]
pub(super) struct Odometer {
    kind: OdometerKind,
}

#[derive(Clone, Debug)]
enum OdometerKind {
    Truth,
    Wheels(WheelWalk),
    /// The last frame that was reported.
    Amiro(Option<AmiroFrame>),
    AmiroUndated,
}

impl Odometer {
    /// The given odometry with an error of its own, at the start of a drive.
    pub(super) fn new(odometry: OdometryModel, start: &Pose, errors: Generator) -> Self {
        let kind = match odometry {
            OdometryModel::Truth => OdometerKind::Truth,
            OdometryModel::WheelErrors(model) => {
                OdometerKind::Wheels(WheelWalk::new(&model, start, errors))
            }
            OdometryModel::Amiro => OdometerKind::Amiro(None),
            OdometryModel::AmiroUndated => OdometerKind::AmiroUndated,
        };
        Self { kind }
    }

    /// The stamp and pose that have arrived when the sensors are sampled, if new. Samples are closer together than frames, so it is one at most.
    pub(super) fn update_at(&mut self, drive: &Drive, stamp_us: u64) -> Option<(u64, Pose)> {
        match &mut self.kind {
            OdometerKind::Truth => Some((stamp_us, drive.pose_at(stamp_us))),
            OdometerKind::Wheels(walk) => Some((stamp_us, walk.moved_to(&drive.pose_at(stamp_us)))),
            OdometerKind::Amiro(last) => {
                let newest = AmiroFrame::newest_at(stamp_us);
                if *last == Some(newest) {
                    return None;
                }
                *last = Some(newest);
                Some((newest.update_us(), newest.pose(drive)))
            }
            OdometerKind::AmiroUndated => {
                let newest = AmiroFrame::newest_at(stamp_us);
                Some((stamp_us, newest.pose(drive)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_name_every_odometry() {
        let errors = WheelErrors {
            scale_percent: 0.1 + 0.2,
            heading_deg_per_sqrt_m: 6.0,
            ..WheelErrors::NONE
        };
        let systematic = WheelErrors {
            drift_deg_per_m: -2.0,
            slip_percent: 0.5,
            ..errors
        };
        for odometry in [
            OdometryModel::Truth,
            OdometryModel::WheelErrors(errors),
            OdometryModel::WheelErrors(systematic),
            OdometryModel::Amiro,
            OdometryModel::AmiroUndated,
        ] {
            assert_eq!(odometry.to_string().parse(), Ok(odometry));
        }
        let default = OdometryModel::WheelErrors(WheelErrors::default());
        assert_eq!("wheel-errors".parse(), Ok(default));
        assert_eq!("wheel-errors:1:2:0:0".parse(), Ok(default));
        assert_eq!(default.to_string(), "wheel-errors:1:2");
        for wrong in [
            "",
            "Amiro",
            "wheel-errors:1",
            "wheel-errors:1:x",
            "wheel-errors:1:2:3",
            "wheel-errors:1:2:3:4:5",
            "amiro:1",
        ] {
            let error = wrong.parse::<OdometryModel>().unwrap_err().to_string();
            assert!(error.starts_with("odometry: `"), "{error}");
        }
    }
}
