//! Kalman filter over wheel speeds and heading (\[IPM\] equations 8 to 14).

use nalgebra::{Matrix3, Vector3};

use super::DeadReckoningModel;
use crate::geometry::{Angle, Point, Pose, Rotation};
use crate::math;
use crate::model::WheelSpeeds;

/// Fastest wheel speed accepted, metres per second.
const MOST_SPEED: f32 = 10.0;

/// Largest variances of the state: an unknown speed, an unknown heading.
const MOST_VARIANCE: [f32; 3] = [MOST_SPEED * MOST_SPEED, MOST_SPEED * MOST_SPEED, 10.0];

/// Which measurements a step used; the others were missing or refused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UsedMeasurements {
    /// The wheel speeds.
    pub speeds: bool,
    /// The compass: measured minus predicted heading, the shorter way round.
    pub compass_residual: Option<Angle>,
}

/// Pose, wheel speeds and their uncertainty.
///
/// State x = (v_L, v_R, heading): measured (uncorrected) speeds, metres per second, and
/// radians. 56 bytes.
///
/// Every value stays finite and bounded: speeds within 10 m/s, the heading in (-pi, pi],
/// variances below 100 (m/s)^2 and 10 rad^2. A position is limited by the travel alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadReckoning {
    position: Point,
    state: Vector3<f32>,
    covariance: Matrix3<f32>,
}

impl DeadReckoning {
    /// A robot that stands at `pose`, known as well as one measurement of each kind would
    /// make it known (P = R).
    ///
    /// A pose that is not finite is taken as the origin.
    #[must_use]
    pub fn starting_at(model: &DeadReckoningModel, pose: &Pose) -> Self {
        let pose = if pose.is_finite() {
            *pose
        } else {
            Pose::default()
        };
        Self {
            position: pose.position,
            state: Vector3::new(0.0, 0.0, pose.heading.radians()),
            covariance: Matrix3::from_diagonal(&model.measurement),
        }
    }

    /// One step of `period_s`: prediction, then the measurements that there are.
    ///
    /// ```text
    /// x = F x              P = F P F' + Q
    /// per measurement i    K = P e_i / (P_ii + R_ii)
    ///                      x = x + K r_i, r_heading wrapped
    ///                      P = (I - K e_i') P (I - K e_i')' + K R_ii K'
    /// ```
    ///
    /// R is diagonal, so one measurement at a time gives what the matrix inverse of
    /// equation 11 gives, without an inverse that can fail; a missing measurement is left
    /// out. The position moves by the filtered speeds along the mean of old and new
    /// heading.
    ///
    /// Speeds that are not finite or beyond 10 m/s, and a compass reading that is no
    /// number, are refused. There is no gate on the compass beside that: a reading that
    /// disagrees by half a turn counts. Gate on [`UsedMeasurements::compass_residual`].
    ///
    /// About 450 operations.
    pub fn step(
        &mut self,
        model: &DeadReckoningModel,
        speeds: Option<WheelSpeeds>,
        compass: Option<Angle>,
    ) -> UsedMeasurements {
        let before = self.heading();
        self.state = model.transition * self.state;
        self.covariance =
            model.transition * self.covariance * model.transition.transpose() + model.process;
        let mut used = UsedMeasurements::default();
        if let Some(speeds) = speeds.filter(are_legal) {
            let WheelSpeeds {
                left_m_per_s,
                right_m_per_s,
            } = speeds;
            self.update(&Vector3::x(), left_m_per_s - self.state.x, model);
            self.update(&Vector3::y(), right_m_per_s - self.state.y, model);
            used.speeds = true;
        }
        if let Some(compass) = compass.filter(|heading| heading.radians().is_finite()) {
            let residual = Angle::from_radians(compass.radians() - self.state.z);
            self.update(&Vector3::z(), residual.radians(), model);
            used.compass_residual = Some(residual);
        }
        self.bound();
        self.move_by(model, before);
        used
    }

    /// The update by one component of the state, chosen by the unit vector `unit`.
    fn update(&mut self, unit: &Vector3<f32>, residual: f32, model: &DeadReckoningModel) {
        let noise = unit.dot(&model.measurement);
        let column = self.covariance * unit;
        let gain = column / (unit.dot(&column) + noise);
        self.state += gain * residual;
        let left = Matrix3::identity() - gain * unit.transpose();
        self.covariance =
            left * self.covariance * left.transpose() + gain * gain.transpose() * noise;
    }

    /// Symmetry, bounded variances, bounded speeds, a wrapped heading.
    ///
    /// A variance beyond its bound is scaled down together with its row and column, which
    /// keeps the matrix positive.
    fn bound(&mut self) {
        let symmetric = (self.covariance + self.covariance.transpose()) * 0.5;
        let variances = symmetric.diagonal();
        let scale = Vector3::from(MOST_VARIANCE).zip_map(&variances, |most, variance| {
            if variance > most {
                math::sqrt(most / variance)
            } else {
                1.0
            }
        });
        self.covariance = symmetric.component_mul(&(scale * scale.transpose()));
        self.state = Vector3::new(
            self.state.x.clamp(-MOST_SPEED, MOST_SPEED),
            self.state.y.clamp(-MOST_SPEED, MOST_SPEED),
            math::wrap_angle(self.state.z),
        );
    }

    /// Position: v T along the mean heading (eq. 1, 2 and 6, corrected).
    fn move_by(&mut self, model: &DeadReckoningModel, before: Angle) {
        let parameters = model.parameters();
        let turn = Angle::from_radians(self.state.z - before.radians());
        let mean = before.radians() + 0.5 * turn.radians();
        let arc_m = parameters.drive.forward_m_per_s(self.speeds()) * parameters.period_s;
        self.position = self.position + Point::new(arc_m, 0.0).rotated(Rotation::by(mean));
    }

    /// Position and filtered heading.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose {
            position: self.position,
            heading: self.heading(),
        }
    }

    /// Filtered heading.
    #[must_use]
    pub fn heading(&self) -> Angle {
        Angle::from_radians(self.state.z)
    }

    /// Filtered speeds as the encoders measure them: not corrected.
    #[must_use]
    pub fn speeds(&self) -> WheelSpeeds {
        WheelSpeeds {
            left_m_per_s: self.state.x,
            right_m_per_s: self.state.y,
        }
    }

    /// Covariance of (v_L, v_R, heading): (m/s)^2, m rad / s, rad^2.
    #[must_use]
    pub const fn covariance(&self) -> &Matrix3<f32> {
        &self.covariance
    }
}

fn are_legal(speeds: &WheelSpeeds) -> bool {
    // A comparison with NaN does not hold.
    speeds.left_m_per_s.abs() <= MOST_SPEED && speeds.right_m_per_s.abs() <= MOST_SPEED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dead_reckoning::{DeadReckoningParameters, WheelCorrection};
    use crate::model::DifferentialDrive;
    use crate::random::{Generator, standard_normal_pair, uniform};

    const PIONEER: DifferentialDrive = DifferentialDrive { track_m: 0.33 };

    fn speeds(left_m_per_s: f32, right_m_per_s: f32) -> WheelSpeeds {
        WheelSpeeds {
            left_m_per_s,
            right_m_per_s,
        }
    }

    fn model(change: impl FnOnce(&mut DeadReckoningParameters)) -> DeadReckoningModel {
        let mut parameters = DeadReckoningParameters::of(PIONEER);
        change(&mut parameters);
        DeadReckoningModel::new(parameters).unwrap()
    }

    #[test]
    fn g12_one_wheel_is_the_scalar_filter() {
        let model = model(|p| {
            p.speed_change_m_per_s = 0.1;
            p.speed_sigma_m_per_s = math::sqrt(0.05);
            // The printed filter multiplies the speed by it.
            p.drive.correction.left = 1.02;
        });
        let mut filter = DeadReckoning::starting_at(&model, &Pose::default());
        filter.state = Vector3::new(1.0, 1.0, 0.0);
        filter.covariance = Matrix3::from_diagonal(&Vector3::new(0.04, 0.04, 0.01));
        filter.step(&model, Some(speeds(1.2, 1.2)), None);
        for (given, expected) in [
            (filter.state.x, 1.1),
            (filter.state.y, 1.1),
            (filter.covariance.m11, 0.025),
            (filter.covariance.m22, 0.025),
        ] {
            assert!((given - expected).abs() < 2e-7, "{given} is not {expected}");
        }
    }

    /// The scalar filter with a factor on the diagonal, as printed for k1: gain and
    /// estimate after a step.
    fn printed(factor: f64, state: f64, variance: f64, z: f64, q: f64, r: f64) -> [f64; 3] {
        let (state, variance) = (factor * state, factor * factor * variance + q);
        let gain = variance / (variance + r);
        [gain, state + gain * (z - state), (1.0 - gain) * variance]
    }

    #[test]
    fn g12_the_printed_factor_on_the_diagonal_gives_another_estimate() {
        let [gain, state, _] = printed(1.02, 1.0, 0.04, 1.2, 0.01, 0.05);
        assert!((gain - 0.507_951_504).abs() < 1e-9, "{gain}");
        assert!((state - 1.111_431_271).abs() < 1e-9, "{state}");
    }

    #[test]
    fn g12_the_printed_factor_makes_a_constant_speed_up_to_twice_too_fast() {
        for (q, expected) in [(4.0, 1.0041), (0.01, 1.1846), (0.0001, 1.8759)] {
            let (mut state, mut variance) = (1.0, 1.0);
            for _ in 0..20_000 {
                [_, state, variance] = printed(1.02, state, variance, 1.0, q, 1.0);
            }
            assert!((state - expected).abs() < 5e-5, "Q/R = {q}: {state}");
            let model = model(|p| {
                p.drive.correction.left = 1.02;
                p.speed_sigma_m_per_s = 0.01;
                p.speed_change_m_per_s = 0.01 * math::sqrt(q as f32);
            });
            let mut filter = DeadReckoning::starting_at(&model, &Pose::default());
            for _ in 0..2000 {
                filter.step(&model, Some(speeds(1.0, 1.0)), None);
            }
            let left = filter.speeds().left_m_per_s;
            assert!((left - 1.0).abs() < 1e-5, "Q/R = {q}: {left}");
        }
    }

    #[test]
    fn one_measurement_at_a_time_equals_the_matrix_inverse_of_equation_11() {
        let model = model(|p| p.drive.correction.right = 0.97);
        let mut rng = Generator::seeded(1);
        let mut filter = DeadReckoning::starting_at(&model, &Pose::default());
        for step in 0..50 {
            let (a, b) = standard_normal_pair(&mut rng);
            let measured = Vector3::new(0.3 + 0.1 * a, 0.3 + 0.1 * b, 0.2 * (a - b));
            let f = model.transition;
            let predicted = f * filter.covariance * f.transpose() + model.process;
            let r = Matrix3::from_diagonal(&model.measurement);
            let gain = predicted * (predicted + r).try_inverse().unwrap();
            let state = f * filter.state + gain * (measured - f * filter.state);
            let covariance = (Matrix3::identity() - gain) * predicted;
            let compass = Angle::from_radians(measured.z);
            filter.step(&model, Some(speeds(measured.x, measured.y)), Some(compass));
            // Single precision through an inverse: 1e-5 relative.
            let error = (filter.state - state).amax();
            assert!(error < 1e-5, "step {step}: {error}");
            let error = (filter.covariance - covariance).amax() / covariance.amax();
            assert!(error < 1e-4, "step {step}: {error}");
        }
    }

    #[test]
    fn a_compass_beyond_half_a_turn_corrects_the_shorter_way() {
        let model = model(|_| ());
        let start = Pose::new(0.0, 0.0, 179.0_f32.to_radians());
        let mut filter = DeadReckoning::starting_at(&model, &start);
        let compass = Angle::from_radians((-179.0_f32).to_radians());
        let used = filter.step(&model, Some(speeds(0.0, 0.0)), Some(compass));
        let residual = used.compass_residual.unwrap().radians();
        assert!((residual - 2.0_f32.to_radians()).abs() < 1e-5, "{residual}");
        let turned = Angle::from_radians(filter.heading().radians() - start.heading.radians());
        assert!((0.0..residual).contains(&turned.radians()), "{turned:?}");
    }

    #[test]
    fn without_noise_a_circle_is_driven_along_its_arc() {
        let model = model(|_| ());
        let mut filter = DeadReckoning::starting_at(&model, &Pose::new(1.0, 2.0, 0.5));
        let measured = speeds(0.168, 0.432);
        filter.state = Vector3::new(0.168, 0.432, 0.5);
        let mut exact = Pose::new(1.0, 2.0, 0.5);
        for step in 0..79 {
            exact = exact.moved(&model.parameters().drive.motion(measured, 0.1));
            filter.step(&model, Some(measured), Some(exact.heading));
            let error = (filter.pose().position - exact.position).norm();
            assert!(error < 0.000_25, "step {step}: {error}");
        }
    }

    /// Errors at the end of 190 s along squares, metres: the measured speeds alone, and the
    /// filter with `correction` and a compass.
    fn end_errors(correction: WheelCorrection, seed: u64) -> (f32, f32) {
        let truth = WheelCorrection {
            left: 1.02,
            right: 0.99,
            track: 1.05,
        };
        let model = model(|p| p.drive.correction = correction);
        let [real, raw] = [truth, WheelCorrection::NONE].map(|correction| {
            let mut drive = model.parameters().drive;
            drive.correction = correction;
            drive
        });
        let mut rng = Generator::seeded(seed);
        let (mut exact, mut reckoned) = (Pose::default(), Pose::default());
        let mut filter = DeadReckoning::starting_at(&model, &exact);
        for step in 0..1900 {
            // 7 s straight, then 2.5 s on the spot.
            let commanded = if step % 95 < 70 {
                speeds(0.2, 0.2)
            } else {
                speeds(-0.11, 0.11)
            };
            exact = exact.moved(&real.motion(commanded, 0.1));
            let (left, right) = standard_normal_pair(&mut rng);
            let measured = speeds(
                commanded.left_m_per_s + 0.003 * left,
                commanded.right_m_per_s + 0.003 * right,
            );
            let noise = 3.0_f32.to_radians() * standard_normal_pair(&mut rng).0;
            let compass = Angle::from_radians(exact.heading.radians() + noise);
            reckoned = reckoned.moved(&raw.midpoint_motion(measured, 0.1));
            filter.step(&model, Some(measured), Some(compass));
        }
        let error = |pose: Pose| (pose.position - exact.position).norm();
        (error(reckoned), error(filter.pose()))
    }

    #[test]
    fn a_compass_removes_most_of_the_error_of_uncalibrated_wheels() {
        for seed in 1..=5 {
            let (raw, filtered) = end_errors(WheelCorrection::NONE, seed);
            assert!(raw > 0.8, "seed {seed}: {raw}");
            assert!(filtered < 0.2, "seed {seed}: {filtered}");
        }
    }

    #[test]
    fn missing_and_hostile_measurements_are_refused_one_by_one() {
        let model = model(|_| ());
        let mut filter = DeadReckoning::starting_at(&model, &Pose::new(f32::NAN, 0.0, 0.0));
        assert_eq!(filter.pose(), Pose::default());
        let heading = Angle::from_radians(0.1);
        let good = Some(speeds(0.1, 0.2));
        let none = UsedMeasurements::default();
        assert_eq!(filter.step(&model, None, None), none);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 10.1, -1e30] {
            for wheels in [speeds(bad, 0.1), speeds(0.1, bad)] {
                let used = filter.step(&model, Some(wheels), Some(heading));
                assert!(!used.speeds && used.compass_residual.is_some(), "{bad}");
            }
        }
        for bad in [f32::NAN, f32::INFINITY] {
            let used = filter.step(&model, good, Some(Angle::from_radians(bad)));
            assert!(used.speeds && used.compass_residual.is_none(), "{bad}");
        }
    }

    fn assert_bounded(filter: &DeadReckoning, step: u32) {
        let (pose, p) = (filter.pose(), filter.covariance);
        assert!(pose.is_finite(), "step {step}: {filter:?}");
        assert!(filter.state.x.abs() <= 10.0 && filter.state.y.abs() <= 10.0);
        assert_eq!(p, p.transpose(), "step {step}");
        for (variance, most) in p.diagonal().iter().zip(MOST_VARIANCE) {
            // A rounding of the scale.
            assert!(
                *variance > 0.0 && *variance <= most * 1.000_001,
                "step {step}: {p}"
            );
        }
        assert!(
            p.fixed_view::<2, 2>(0, 0).determinant() > 0.0,
            "step {step}: {p}"
        );
        let scale = p.m11 * p.m22 * p.m33;
        assert!(p.determinant() > -1e-5 * scale, "step {step}: {p}");
    }

    #[test]
    fn the_filter_takes_56_bytes() {
        assert_eq!(core::mem::size_of::<DeadReckoning>(), 56);
    }

    #[test]
    fn covariance_stays_positive_for_a_hundred_thousand_steps() {
        let model = model(|_| ());
        let mut filter = DeadReckoning::starting_at(&model, &Pose::default());
        for step in 0..100_000 {
            filter.step(&model, Some(speeds(0.2, 0.3)), Some(Angle::default()));
            assert_bounded(&filter, step);
        }
    }

    #[test]
    fn any_sequence_of_measurements_leaves_the_state_bounded() {
        for seed in 1..=3 {
            let mut rng = Generator::seeded(seed);
            let model = model(|p| {
                p.speed_change_m_per_s = 10.0;
                p.slip_rad = 1.0;
                p.period_s = 1.0;
                p.drive.nominal.track_m = 0.01;
                p.drive.correction.track = 0.5;
            });
            let mut filter = DeadReckoning::starting_at(&model, &Pose::default());
            for step in 0..20_000 {
                let bits = |rng: &mut Generator| f32::from_bits(rng.bits());
                let wheels = match rng.bits() % 4 {
                    0 => None,
                    1 => Some(speeds(bits(&mut rng), bits(&mut rng))),
                    2 => Some(speeds(10.0, -10.0)),
                    _ => Some(speeds(10.0 * uniform(&mut rng), -10.0)),
                };
                let compass = match rng.bits() % 3 {
                    0 => None,
                    1 => Some(Angle::from_radians(bits(&mut rng))),
                    _ => Some(Angle::from_radians(6.0 * uniform(&mut rng))),
                };
                filter.step(&model, wheels, compass);
                assert_bounded(&filter, step);
            }
        }
    }
}
