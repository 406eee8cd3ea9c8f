//! The odometry of Ivanjko, Petrovic and Macek 2003 on a simulated lap of squares.

use std::ops::Range;

use amiro_ipf::dead_reckoning::{
    DeadReckoning, DeadReckoningModel, DeadReckoningParameters, WheelCorrection,
};
use amiro_ipf::geometry::{Angle, Pose};
use amiro_ipf::model::{DifferentialDrive, WheelSpeeds};
use amiro_ipf::random::{Generator, standard_normal_pair};

use super::{ExperimentCheck, ExperimentError, ExperimentReport};
use crate::calibration::{WheelSegment, fit_wheels};
use crate::geometry::{Pose2, Vector};

/// Nominal track of the Pioneer 2-DX, metres.
const TRACK_M: f32 = 0.33;

/// Factors of the simulated robot.
const TRUE: WheelCorrection = WheelCorrection {
    left: 1.02,
    right: 0.99,
    track: 1.05,
};

const PERIOD_S: f32 = 0.1;

/// Standard deviations: of a wheel speed, of the compass, and of the poses that a
/// calibration measures.
const SPEED_M_PER_S: f64 = 3e-3;
const COMPASS_DEG: f64 = 3.0;
const PLACE_M: f64 = 5e-3;
const HEADING_DEG: f64 = 0.3;

/// A side of a square and a turn on the spot: 9.5 s at 0.3 m/s and a quarter per 2.5 s.
const SIDE_STEPS: usize = 70;
const TURN_STEPS: usize = 25;
const SPEED: f32 = 0.3;
const SIDES: usize = 4;

/// Squares to the left, then to the right: 190 s.
const SQUARES: [f32; 5] = [1.0, 1.0, 1.0, -1.0, -1.0];

/// Segments of the calibration, and their steps.
const SEGMENTS: u32 = 17;
const SEGMENT_STEPS: usize = 120;

/// Errors at the end of a lap: metres, degrees.
type EndError = [f64; 2];

const ROWS: [&str; 4] = [
    "wheels",
    "wheels, calibrated",
    "compass",
    "compass, calibrated",
];

/// Drives the lap per seed and compares four ways to compute its end.
///
/// # Errors
/// A parameter of the filter outside its range, or a calibration that determines no factors:
/// none of the program's own is.
pub fn odometry_lap(seeds: &Range<u64>) -> Result<ExperimentReport, ExperimentError> {
    let mut sums = [[0.0; 2]; 4];
    for seed in seeds.clone() {
        for (sum, error) in sums.iter_mut().zip(lap(seed)?) {
            for (sum, error) in sum.iter_mut().zip(error) {
                *sum += error;
            }
        }
    }
    let count = (seeds.end - seeds.start) as f64;
    let means = sums.map(|sum| sum.map(|sum| sum / count));
    let mut lines = vec![
        format!(
            "Lap of five squares, 190 s, k = (1.02, 0.99, 1.05) (002); seeds {}..{}",
            seeds.start, seeds.end
        ),
        "mean error at the end     m    degrees".to_owned(),
    ];
    for (name, [metres, degrees]) in ROWS.into_iter().zip(means) {
        lines.push(format!("{name:<21}  {metres:.3}  {degrees:>7.2}"));
    }
    let [
        [raw_m, _],
        [calibrated_m, _],
        [compass_m, _],
        [both_m, both_deg],
    ] = means;
    let checks = vec![
        ExperimentCheck::at_most(
            "calibrated wheels, a tenth of raw, m",
            calibrated_m,
            0.1 * raw_m,
        ),
        ExperimentCheck::at_most("compass without calibration, m", compass_m, 0.15),
        ExperimentCheck::at_most("compass with calibration, m", both_m, 0.15),
        ExperimentCheck::at_most("its heading, degrees", both_deg, 1.5),
    ];
    Ok(ExperimentReport {
        lines,
        checks,
        ..ExperimentReport::default()
    })
}

fn lap(seed: u64) -> Result<[EndError; 4], ExperimentError> {
    let mut rng = Generator::seeded(seed);
    let fitted = calibrated(&mut rng)?;
    let speeds = squares();
    let truth = driven(TRUE, &speeds);
    let measured: Vec<_> = speeds.iter().map(|it| noisy(*it, &mut rng)).collect();
    let compass: Vec<_> = truth
        .iter()
        .skip(1)
        .map(|pose| {
            let noise_rad = normal(&mut rng) * COMPASS_DEG.to_radians();
            Angle::from_radians((pose.heading_rad() + noise_rad) as f32)
        })
        .collect();
    let end = truth.last().copied().unwrap_or(Pose2::new(0.0, 0.0, 0.0));
    let error = |found: Pose2| {
        let turn_deg = found.turn_to(&end).to_degrees();
        [(found.position - end.position).norm(), turn_deg]
    };
    let wheels = |correction| {
        let poses = driven(correction, &measured);
        poses.last().map_or([f64::NAN; 2], |found| error(*found))
    };
    let filtered = |correction| {
        let mut parameters = DeadReckoningParameters::of(DifferentialDrive { track_m: TRACK_M });
        parameters.drive.correction = correction;
        let model = DeadReckoningModel::new(parameters)?;
        let mut filter = DeadReckoning::starting_at(&model, &Pose::default());
        for (speeds, compass) in measured.iter().zip(&compass) {
            filter.step(&model, Some(*speeds), Some(*compass));
        }
        Ok::<_, ExperimentError>(error(Pose2::from(filter.pose())))
    };
    let none = WheelCorrection::NONE;
    Ok([
        wheels(none),
        wheels(fitted),
        filtered(none)?,
        filtered(fitted)?,
    ])
}

/// Wheel speeds of the lap as the encoders give them without noise.
fn squares() -> Vec<WheelSpeeds> {
    let half_turn = core::f32::consts::FRAC_PI_2 / (TURN_STEPS as f32 * PERIOD_S) * 0.5 * TRACK_M;
    let mut speeds = Vec::new();
    for side in SQUARES {
        for _ in 0..SIDES {
            speeds.extend([over_ground(SPEED, SPEED); SIDE_STEPS]);
            let turn = half_turn * TRUE.track * side;
            speeds.extend([over_ground(-turn, turn); TURN_STEPS]);
        }
    }
    speeds
}

/// What the encoders give of speeds over ground.
fn over_ground(left_m_per_s: f32, right_m_per_s: f32) -> WheelSpeeds {
    WheelSpeeds {
        left_m_per_s: left_m_per_s / TRUE.left,
        right_m_per_s: right_m_per_s / TRUE.right,
    }
}

/// The poses of a drive with these factors, from the origin.
fn driven(correction: WheelCorrection, speeds: &[WheelSpeeds]) -> Vec<Pose2> {
    let (left, right) = (f64::from(correction.left), f64::from(correction.right));
    let track_m = f64::from(TRACK_M) * f64::from(correction.track);
    let seconds = f64::from(PERIOD_S);
    let (mut place, mut heading_rad) = (Vector::new(0.0, 0.0), 0.0);
    let mut poses = vec![Pose2::new(0.0, 0.0, 0.0)];
    for speed in speeds {
        let left_m = left * f64::from(speed.left_m_per_s) * seconds;
        let right_m = right * f64::from(speed.right_m_per_s) * seconds;
        let turn_rad = (right_m - left_m) / track_m;
        let (sine, cosine) = libm::sincos(heading_rad + 0.5 * turn_rad);
        place = place + Vector::new(cosine, sine).scaled(0.5 * (left_m + right_m));
        heading_rad += turn_rad;
        poses.push(Pose2::new(place.x, place.y, heading_rad));
    }
    poses
}

/// The factors that a drive of 17 segments with turns both ways gives.
fn calibrated(rng: &mut Generator) -> Result<WheelCorrection, ExperimentError> {
    let segments = (0..SEGMENTS).map(|number| {
        // From a turn to the right over straight ahead to one to the left.
        let turn = (number as f32 / (SEGMENTS - 1) as f32 - 0.5) * 0.2;
        let speeds = vec![over_ground(SPEED - turn, SPEED + turn); SEGMENT_STEPS];
        let end = driven(TRUE, &speeds);
        let turn_rad = end.windows(2).map(|two| {
            let turn = two[1].heading.after(two[0].heading.inverse());
            libm::atan2(turn.sine, turn.cosine)
        });
        let turn_rad: f64 = turn_rad.sum();
        let place = end.last().map_or(Vector::new(0.0, 0.0), |end| end.position);
        let increments = speeds.iter().map(|it| {
            let it = noisy(*it, rng);
            let metres = |speed: f32| f64::from(speed * PERIOD_S);
            (metres(it.left_m_per_s), metres(it.right_m_per_s))
        });
        let increments_m = increments.collect();
        WheelSegment {
            increments_m,
            displacement: place + Vector::new(normal(rng), normal(rng)).scaled(PLACE_M),
            turn_rad: turn_rad + normal(rng) * HEADING_DEG.to_radians(),
        }
    });
    let segments: Vec<_> = segments.collect();
    Ok(fit_wheels(&segments, f64::from(TRACK_M))?.correction())
}

fn noisy(speeds: WheelSpeeds, rng: &mut Generator) -> WheelSpeeds {
    let (left, right) = standard_normal_pair(rng);
    WheelSpeeds {
        left_m_per_s: speeds.left_m_per_s + SPEED_M_PER_S as f32 * left,
        right_m_per_s: speeds.right_m_per_s + SPEED_M_PER_S as f32 * right,
    }
}

fn normal(rng: &mut Generator) -> f64 {
    f64::from(standard_normal_pair(rng).0)
}

#[cfg(test)]
mod tests {
    use amiro_ipf::dead_reckoning::CorrectedDrive;

    use super::*;

    #[test]
    fn five_squares_take_190_s_and_end_where_they_began() {
        let speeds = squares();
        assert_eq!(speeds.len(), 1900);
        let end = *driven(TRUE, &speeds).last().unwrap();
        // Single precision of the speeds.
        assert!(end.position.norm() < 1e-3, "{end:?}");
        // Three whole turns less two.
        assert!(end.heading_rad().abs() < 1e-4, "{end:?}");
    }

    #[test]
    fn the_core_s_kinematics_give_the_same_way() {
        let drive = CorrectedDrive {
            nominal: DifferentialDrive { track_m: TRACK_M },
            correction: TRUE,
        };
        let speeds = over_ground(0.2, 0.3);
        let motion = drive.midpoint_motion(speeds, PERIOD_S);
        let found = driven(TRUE, &[speeds])[1];
        let expected = Vector::from(motion.displacement);
        assert!((found.position - expected).norm() < 1e-7);
    }

    #[test]
    fn calibration_and_compass_give_the_published_errors() {
        let report = odometry_lap(&(100..110)).unwrap();
        assert!(report.checks.iter().all(|check| check.holds), "{report:#?}");
    }
}
