//! End errors of a recorded drive's odometry: raw, calibrated, and filtered with a compass.

use std::collections::BTreeMap;

use amiro_ipf::dead_reckoning::{DeadReckoning, DeadReckoningModel, DeadReckoningParameters};
use amiro_ipf::filter::ParameterError;
use amiro_ipf::geometry::{Angle, Pose};
use amiro_ipf::model::{DifferentialDrive, WheelSpeeds};
use amiro_ipf::random::{Generator, standard_normal_pair};

use super::{WheelFit, WheelSegment};
use crate::geometry::{Pose2, Turn, Vector};

/// Poses by odometry and by matching at the same instants, as wheel increments and truth.
///
/// A log of poses has no wheel speeds: the increments are those that a differential drive
/// of this track needs for the odometry's motions.
#[derive(Clone, Debug, PartialEq)]
pub struct OdometryDrive {
    track_m: f64,
    period_s: f64,
    increments_m: Vec<(f64, f64)>,
    truth: Vec<Pose2>,
}

/// Distances from the last true place, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryEnds {
    /// Of the wheels alone.
    pub wheels_m: f64,
    /// Of the Kalman filter with a compass, mean over the seeds.
    pub filtered_m: f64,
}

impl OdometryDrive {
    /// Records of one segment of a calibration.
    pub const SEGMENT: usize = 30;

    /// Standard deviation of the simulated compass, degrees.
    pub const COMPASS_DEG: f32 = 3.0;

    /// Number of seeds of the simulated compass.
    pub const SEEDS: u64 = 10;

    /// The instants that both lists have; `lever_m` is how far the matched poses' point
    /// lies before that of the odometry. `None` for fewer than two instants, and a track
    /// or time that is not positive.
    #[must_use]
    pub fn new(
        odometry: &BTreeMap<u64, Pose2>,
        matched: &BTreeMap<u64, Pose2>,
        track_m: f64,
        lever_m: f64,
    ) -> Option<Self> {
        let both = odometry
            .iter()
            .filter_map(|(stamp_us, pose)| Some((*stamp_us, *pose, *matched.get(stamp_us)?)));
        let both: Vec<_> = both.collect();
        let (first, last) = (both.first()?.0, both.last()?.0);
        let steps = both.len().checked_sub(1).filter(|steps| *steps > 0)?;
        let period_s = 1e-6 * (last - first) as f64 / steps as f64;
        let increments = both
            .windows(2)
            .map(|two| increments_m(&two[0].1, &two[1].1, track_m));
        let truth = both.iter().map(|(_, _, matched)| Pose2 {
            position: matched.place(Vector::new(-lever_m, 0.0)),
            ..*matched
        });
        (period_s > 0.0 && track_m > 0.0).then(|| Self {
            track_m,
            period_s,
            increments_m: increments.collect(),
            truth: truth.collect(),
        })
    }

    /// Mean time between two instants, seconds.
    #[must_use]
    pub const fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The drive in segments of [`Self::SEGMENT`] records; the rest at its end is left out.
    #[must_use]
    pub fn segments(&self) -> Vec<WheelSegment> {
        let increments = self.increments_m.chunks_exact(Self::SEGMENT);
        let segments = increments.enumerate().filter_map(|(number, increments)| {
            let from = number * Self::SEGMENT;
            let truth = self.truth.get(from..=from + Self::SEGMENT)?;
            Some(WheelSegment {
                increments_m: increments.to_vec(),
                displacement: truth.first()?.view(truth.last()?.position),
                turn_rad: truth.windows(2).map(|two| turn_rad(&two[0], &two[1])).sum(),
            })
        });
        segments.collect()
    }

    /// The end errors with these factors.
    ///
    /// # Errors
    /// Factors or a period outside the filter's ranges.
    pub fn ends(&self, fit: &WheelFit) -> Result<OdometryEnds, ParameterError> {
        let mut parameters = DeadReckoningParameters::of(DifferentialDrive {
            track_m: self.track_m as f32,
        });
        parameters.drive.correction = fit.correction();
        parameters.period_s = self.period_s as f32;
        let model = DeadReckoningModel::new(parameters)?;
        let sum: f64 = (0..Self::SEEDS)
            .map(|seed| self.filtered_end_m(&model, seed))
            .sum();
        Ok(OdometryEnds {
            wheels_m: self.wheels_end_m(fit),
            filtered_m: sum / Self::SEEDS as f64,
        })
    }

    fn wheels_end_m(&self, fit: &WheelFit) -> f64 {
        let (start, end) = (self.truth[0], self.truth[self.truth.len() - 1]);
        let (mut place, mut heading_rad) = (start.position, start.heading_rad());
        for (left, right) in &self.increments_m {
            let (left, right) = (left * fit.left, right * fit.right);
            let turn = (right - left) / (self.track_m * fit.track);
            let middle = Turn::by_radians_f64(heading_rad + 0.5 * turn);
            place = place + middle.direction().scaled(0.5 * (left + right));
            heading_rad += turn;
        }
        (place - end.position).norm()
    }

    fn filtered_end_m(&self, model: &DeadReckoningModel, seed: u64) -> f64 {
        let (start, end) = (self.truth[0], self.truth[self.truth.len() - 1]);
        let Vector { x, y } = start.position;
        // Relative to the start: single precision holds distances, not map coordinates.
        let at_start = Pose::new(0.0, 0.0, start.heading_rad() as f32);
        let mut filter = DeadReckoning::starting_at(model, &at_start);
        let mut rng = Generator::seeded(seed);
        let sigma_rad = Self::COMPASS_DEG.to_radians();
        for ((left, right), truth) in self.increments_m.iter().zip(&self.truth[1..]) {
            let noise_rad = sigma_rad * standard_normal_pair(&mut rng).0;
            let compass = Angle::from_radians(truth.heading_rad() as f32 + noise_rad);
            let speeds = WheelSpeeds {
                left_m_per_s: (left / self.period_s) as f32,
                right_m_per_s: (right / self.period_s) as f32,
            };
            filter.step(model, Some(speeds), Some(compass));
        }
        let reached = filter.pose().position;
        let place = Vector::new(x + f64::from(reached.x), y + f64::from(reached.y));
        (place - end.position).norm()
    }
}

/// Turn from one pose to another, radians in (-pi, pi].
fn turn_rad(from: &Pose2, to: &Pose2) -> f64 {
    let turn = from.heading.inverse().after(to.heading);
    libm::atan2(turn.sine, turn.cosine)
}

/// Travel of the left and right wheel on an arc from one pose to another.
fn increments_m(from: &Pose2, to: &Pose2, track_m: f64) -> (f64, f64) {
    let turn = turn_rad(from, to);
    let middle = Turn::by_radians_f64(from.heading_rad() + 0.5 * turn);
    let chord = (to.position - from.position).dot(middle.direction());
    let half = 0.5 * turn;
    let travel = if half.abs() < 1e-6 {
        chord
    } else {
        chord * half / libm::sin(half)
    };
    (travel - track_m * half, travel + track_m * half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::fit_wheels;

    /// A drive of S curves whose odometry has wheels of other sizes than it believes.
    fn drive(true_fit: &WheelFit) -> OdometryDrive {
        let (mut odometry, mut truth) = (BTreeMap::new(), BTreeMap::new());
        let (mut believed, mut real) = ([0.0; 3], [0.0; 3]);
        let step = |pose: &mut [f64; 3], left: f64, right: f64, track: f64| {
            let turn = (right - left) / track;
            let middle = pose[2] + 0.5 * turn;
            pose[0] += 0.5 * (left + right) * middle.cos();
            pose[1] += 0.5 * (left + right) * middle.sin();
            pose[2] += turn;
        };
        for index in 0..601_u32 {
            let stamp_us = u64::from(index) * 200_000;
            odometry.insert(stamp_us, Pose2::new(believed[0], believed[1], believed[2]));
            let ahead = Pose2::new(real[0], real[1], real[2]);
            let laser = ahead.place(Vector::new(0.1, 0.0));
            truth.insert(stamp_us, Pose2::new(laser.x, laser.y, real[2]));
            let bend = 0.01 * (0.05 * f64::from(index)).sin();
            let (left, right) = (0.05 - bend, 0.05 + bend);
            step(&mut believed, left, right, 0.33);
            let (left, right) = (left * true_fit.left, right * true_fit.right);
            step(&mut real, left, right, 0.33 * true_fit.track);
        }
        OdometryDrive::new(&odometry, &truth, 0.33, 0.1).unwrap()
    }

    const NONE: WheelFit = WheelFit {
        left: 1.0,
        right: 1.0,
        track: 1.0,
    };

    #[test]
    fn calibration_and_compass_remove_a_systematic_error() {
        let true_fit = WheelFit {
            left: 1.02,
            right: 0.99,
            track: 1.05,
        };
        let drive = drive(&true_fit);
        let fit = fit_wheels(&drive.segments(), 0.33).unwrap();
        // The chord of an arc is exact to 1e-4 of it.
        assert!(
            (fit.left - 1.02).abs() < 1e-3 && (fit.track - 1.05).abs() < 3e-3,
            "{fit:?}"
        );
        let raw = drive.ends(&NONE).unwrap();
        assert!(raw.wheels_m > 2.0, "{raw:?}");
        assert!(drive.ends(&fit).unwrap().wheels_m < 0.1);
        assert!(raw.filtered_m < 0.5, "{raw:?}");
    }

    #[test]
    fn without_an_error_the_wheels_end_where_the_robot_does() {
        let drive = drive(&NONE);
        // Chords are shorter than arcs, by up to 1.5e-4 of 30 m here.
        assert!(drive.ends(&NONE).unwrap().wheels_m < 0.01);
        assert!((drive.period_s() - 0.2).abs() < 1e-9);
    }

    #[test]
    fn a_drive_without_two_common_instants_is_none() {
        let one = BTreeMap::from([(0, Pose2::new(0.0, 0.0, 0.0))]);
        let other = BTreeMap::from([(1, Pose2::new(0.0, 0.0, 0.0))]);
        assert!(OdometryDrive::new(&one, &other, 0.33, 0.1).is_none());
        assert!(OdometryDrive::new(&one, &one, 0.33, 0.1).is_none());
    }
}
