//! Dead reckoning with systematic errors removed and a compass (\[IPM\] sections 2 and 3).
//!
//! [`WheelCorrection`] and [`CorrectedDrive`] are the kinematics of a differential drive
//! with three factors for wheels and track. [`DeadReckoning`] is a Kalman filter over the
//! two wheel speeds and the heading, which a compass measures; its position is integrated
//! from the filtered speeds. The factors come from a calibration drive; a robot without one
//! uses [`WheelCorrection::NONE`], because the compass removes most of the error.
//!
//! # Misprints of the paper, corrected here
//!
//! | printed | here | why |
//! |---|---|---|
//! | position along the new heading (eq. 1, 2) | along the mean of old and new | 30 mm off on a circle of 0.3 m/s, 0.8 rad/s at 0.1 s; the mean 0.2 mm |
//! | heading in degrees plus rad/s times s (eq. 3) | radians throughout | turns are 57 times too small |
//! | k1, k2 on the diagonal of the system matrix (eq. 14) | 1 | multiplies the speeds in every step: 18 % too fast for k1 = 1.02 and Q / R = 0.01 |
//! | P = (I - K) P (eq. 13) | Joseph's form, one measurement at a time | the same value; stays positive with rounding |
//!
//! # Example
//!
//! ```
//! use amiro_ipf::dead_reckoning::{DeadReckoning, DeadReckoningModel, DeadReckoningParameters};
//! use amiro_ipf::geometry::{Angle, Pose};
//! use amiro_ipf::model::{DifferentialDrive, WheelSpeeds};
//!
//! let mut parameters = DeadReckoningParameters::of(DifferentialDrive::AMIRO);
//! parameters.drive.correction.left = 1.02;
//! let model = DeadReckoningModel::new(parameters)?;
//! let mut filter = DeadReckoning::starting_at(&model, &Pose::default());
//! // 10 s straight ahead. The encoder of the larger left wheel shows a lower speed.
//! let speeds = WheelSpeeds { left_m_per_s: 0.05 / 1.02, right_m_per_s: 0.05 };
//! for _ in 0..100 {
//!     filter.step(&model, Some(speeds), Some(Angle::default()));
//! }
//! let reached = filter.pose().position;
//! assert!((reached.x - 0.5).abs() < 0.01 && reached.y.abs() < 0.01);
//! # Ok::<(), amiro_ipf::filter::ParameterError>(())
//! ```
//!
//! Source key: \[IPM\] is Ivanjko, Petrovic, Macek: Improvements of Occupancy Grid Maps by
//! Sonar Data Corrections, FIRA Robot World Congress, Vienna 2003.

mod kalman;
mod kinematics;
mod parameters;

pub use kalman::{DeadReckoning, UsedMeasurements};
pub use kinematics::{CorrectedDrive, WheelCorrection};
pub use parameters::{DeadReckoningModel, DeadReckoningParameters};
