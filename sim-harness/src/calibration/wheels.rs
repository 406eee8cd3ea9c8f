//! The factors of wheels and track of a differential drive, fitted to a calibration drive.

use amiro_ipf::dead_reckoning::WheelCorrection;
use nalgebra::{Matrix2, Vector2};

use crate::geometry::Vector;

/// Least ratio of the smaller to the larger singular value of the wheels' travel; a drive
/// below it has no turns that the noise would not hide.
const LEAST_TURN_SHARE: f64 = 0.01;

/// One segment of a calibration drive: what the encoders measured, and what is true.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelSegment {
    /// Measured travel of the left and the right wheel per step, metres, in steps short
    /// enough for straight pieces.
    pub increments_m: Vec<(f64, f64)>,
    /// Where the axle's centre went, in the frame in which the segment starts; metres.
    pub displacement: Vector,
    /// How far the robot turned, radians, counter-clockwise positive; **not** wrapped.
    pub turn_rad: f64,
}

/// Why the factors cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WheelFitError {
    /// The nominal track or a segment has no finite numbers.
    #[error("the track must be positive, and every measurement a finite number")]
    NotFinite,
    /// All segments are nearly straight, or all turn alike: the track is open.
    #[error(
        "the segments do not determine the track: ratio {ratio:.4}, at least {LEAST_TURN_SHARE} is needed; drive turns both ways"
    )]
    NoTurns {
        /// Smaller by larger singular value of the wheels' travel.
        ratio: f64,
    },
    /// No segment leads away from where it starts: the size of the wheels is open.
    #[error("the segments lead nowhere; drive straight ones as well")]
    NoTravel,
}

/// The factors k1, k2 and k3 of [`amiro_ipf::dead_reckoning`] in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelFit {
    /// True travel of the left wheel per measured travel (k1).
    pub left: f64,
    /// True travel of the right wheel per measured travel (k2).
    pub right: f64,
    /// True track per nominal track (k3).
    pub track: f64,
}

impl WheelFit {
    /// The factors for the core.
    #[must_use]
    pub fn correction(&self) -> WheelCorrection {
        WheelCorrection {
            left: self.left as f32,
            right: self.right as f32,
            track: self.track as f32,
        }
    }
}

/// Fits the factors to segments with measured relative poses, by two linear least squares.
///
/// Ivanjko, Petrovic and Macek 2003 refer to another paper for the calibration; this rule
/// is ours. With S the summed travel of a wheel over a segment:
///
/// 1. turn = a_R S_R - a_L S_L over all segments gives a_L = k1 / (k3 b), a_R = k2 / (k3 b);
/// 2. with these headings, q = sum of (a_L s_L + a_R s_R) / 2 along the middle heading of
///    each step; k3 b = sum(d . q) / sum(q . q) with the measured displacements d;
/// 3. k1 = a_L k3 b, k2 = a_R k3 b, k3 = k3 b / b.
///
/// The fit describes the drive it is made from. On the three recordings `kcma` (segments of
/// 30 records) the factors of one drive change the end error of another one by -0.16 to
/// +0.91 m: check them on a second drive.
///
/// # Errors
/// [`WheelFitError::NotFinite`]: a number is NaN or infinite, or the track is not positive.
/// [`WheelFitError::NoTurns`]: straight segments alone leave k3 open.
/// [`WheelFitError::NoTravel`]: no displacement, as with turns on the spot alone.
pub fn fit_wheels(
    segments: &[WheelSegment],
    nominal_track_m: f64,
) -> Result<WheelFit, WheelFitError> {
    let is_track = nominal_track_m.is_finite() && nominal_track_m > 0.0;
    if !is_track || !segments.iter().all(is_finite) {
        return Err(WheelFitError::NotFinite);
    }
    let (per_left, per_right) = turn_per_travel(segments)?;
    let (mut along, mut squares) = (0.0, 0.0);
    for segment in segments {
        let q = displacement_per_track(segment, per_left, per_right);
        along += segment.displacement.dot(q);
        squares += q.dot(q);
    }
    let track_m = along / squares;
    if !(track_m.is_finite() && track_m > 0.0) {
        return Err(WheelFitError::NoTravel);
    }
    Ok(WheelFit {
        left: per_left * track_m,
        right: per_right * track_m,
        track: track_m / nominal_track_m,
    })
}

fn is_finite(segment: &WheelSegment) -> bool {
    let Vector { x, y } = segment.displacement;
    let mut steps = segment.increments_m.iter();
    steps.all(|(left, right)| left.is_finite() && right.is_finite())
        && [x, y, segment.turn_rad].iter().all(|v| v.is_finite())
}

/// Step 1: a_L and a_R, radians per metre.
fn turn_per_travel(segments: &[WheelSegment]) -> Result<(f64, f64), WheelFitError> {
    let (mut normal, mut right_side) = (Matrix2::<f64>::zeros(), Vector2::zeros());
    for segment in segments {
        let steps = segment.increments_m.iter();
        let row = steps.fold(Vector2::zeros(), |sum, (left, right)| {
            sum + Vector2::new(-left, *right)
        });
        normal += row * row.transpose();
        right_side += row * segment.turn_rad;
    }
    let squares = normal.symmetric_eigenvalues();
    let ratio = libm::sqrt(squares.min().max(0.0) / squares.max());
    if ratio.is_nan() || ratio < LEAST_TURN_SHARE {
        return Err(WheelFitError::NoTurns { ratio });
    }
    let inverse = normal
        .try_inverse()
        .ok_or(WheelFitError::NoTurns { ratio })?;
    let solution = inverse * right_side;
    Ok((solution.x, solution.y))
}

/// Step 2: the displacement of a segment in units of the true track.
fn displacement_per_track(segment: &WheelSegment, per_left: f64, per_right: f64) -> Vector {
    let (mut heading, mut sum) = (0.0, Vector::default());
    for (left, right) in &segment.increments_m {
        let turn = per_right * right - per_left * left;
        let length = 0.5 * (per_left * left + per_right * right);
        let (sine, cosine) = (
            libm::sin(heading + 0.5 * turn),
            libm::cos(heading + 0.5 * turn),
        );
        sum = Vector::new(sum.x + length * cosine, sum.y + length * sine);
        heading += turn;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::random::{Generator, standard_normal_pair};

    const TRACK_M: f64 = 0.33;
    const TRUE: WheelFit = WheelFit {
        left: 1.02,
        right: 0.99,
        track: 1.05,
    };

    /// 12 s in steps of 0.1 s at true speeds over ground, metres per second; `noise` scales
    /// 3 mm/s on the speeds, 5 mm and 0.3 degrees on the pose.
    fn segment(left: f64, right: f64, noise: f64, rng: &mut Generator) -> WheelSegment {
        let true_track_m = TRUE.track * TRACK_M;
        let (mut heading, mut at) = (0.0, Vector::default());
        let mut increments_m = Vec::new();
        for _ in 0..120 {
            let turn = (right - left) / true_track_m * 0.1;
            let (arc, middle) = (0.05 * (left + right), heading + 0.5 * turn);
            at = Vector::new(
                at.x + arc * libm::cos(middle),
                at.y + arc * libm::sin(middle),
            );
            heading += turn;
            let (a, b) = standard_normal_pair(rng);
            increments_m.push((
                0.1 * (left / TRUE.left + 0.003 * noise * f64::from(a)),
                0.1 * (right / TRUE.right + 0.003 * noise * f64::from(b)),
            ));
        }
        let (a, b) = standard_normal_pair(rng);
        let (c, _) = standard_normal_pair(rng);
        let noise_m = 0.005 * noise;
        WheelSegment {
            increments_m,
            displacement: Vector::new(at.x + noise_m * f64::from(a), at.y + noise_m * f64::from(b)),
            turn_rad: heading + 0.3_f64.to_radians() * noise * f64::from(c),
        }
    }

    /// 17 segments: straight ones, arcs both ways, turns on the spot both ways.
    fn drive(noise: f64, seed: u64) -> Vec<WheelSegment> {
        let speeds = [
            (0.2, 0.2),
            (0.15, 0.22),
            (0.22, 0.15),
            (-0.05, 0.05),
            (0.05, -0.05),
        ];
        let mut rng = Generator::seeded(seed);
        (0..17)
            .map(|index| {
                let (left, right) = speeds[index % speeds.len()];
                segment(left, right, noise, &mut rng)
            })
            .collect()
    }

    #[test]
    fn without_noise_the_factors_come_back() {
        let fit = fit_wheels(&drive(0.0, 1), TRACK_M).unwrap();
        for (given, expected) in [
            (fit.left, TRUE.left),
            (fit.right, TRUE.right),
            (fit.track, TRUE.track),
        ] {
            assert!((given - expected).abs() < 1e-12, "{fit:?}");
        }
        assert!((fit.correction().left - 1.02).abs() < 1e-6);
    }

    #[test]
    fn with_noise_the_mean_of_twenty_fits_lies_within_three_deviations_of_one() {
        // Deviations of one fit in another implementation: 0.0005, 0.0004, 0.0024.
        let runs: Vec<_> = (1..=20)
            .map(|seed| fit_wheels(&drive(1.0, seed), TRACK_M).unwrap())
            .collect();
        let mean = |of: fn(&WheelFit) -> f64| runs.iter().map(of).sum::<f64>() / 20.0;
        let means = [mean(|f| f.left), mean(|f| f.right), mean(|f| f.track)];
        assert!((means[0] - TRUE.left).abs() < 0.0015, "{means:?}");
        assert!((means[1] - TRUE.right).abs() < 0.0012, "{means:?}");
        assert!((means[2] - TRUE.track).abs() < 0.0072, "{means:?}");
    }

    #[test]
    fn straight_segments_alone_leave_the_track_open() {
        for noise in [0.0, 1.0] {
            let mut rng = Generator::seeded(1);
            let straight: Vec<_> = (0..17)
                .map(|_| segment(0.2, 0.2, noise, &mut rng))
                .collect();
            let error = fit_wheels(&straight, TRACK_M).unwrap_err();
            assert!(matches!(error, WheelFitError::NoTurns { .. }), "{error}");
        }
        let error = fit_wheels(&[], TRACK_M).unwrap_err();
        assert!(matches!(error, WheelFitError::NoTurns { .. }), "{error}");
    }

    #[test]
    fn what_leads_nowhere_or_is_no_number_is_refused() {
        let mut still = drive(0.0, 1);
        for segment in &mut still {
            segment.displacement = Vector::default();
        }
        assert_eq!(fit_wheels(&still, TRACK_M), Err(WheelFitError::NoTravel));
        for track_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = fit_wheels(&drive(0.0, 1), track_m);
            assert_eq!(error, Err(WheelFitError::NotFinite), "{track_m}");
        }
        let mut bad = drive(0.0, 1);
        bad[3].increments_m[7].1 = f64::NAN;
        assert_eq!(fit_wheels(&bad, TRACK_M), Err(WheelFitError::NotFinite));
    }
}
