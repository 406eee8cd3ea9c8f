//! Wheel odometry: a wrong scale, a random walk and a drift of the heading, and slips.

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::DifferentialDrive;
use amiro_ipf::random::{Generator, standard_normal_pair, uniform, uniform_below};

use crate::geometry::{Turn, Vector, radians};

/// Separates the slips from the other errors of a drive: "slips".
const SLIP_STREAM: u64 = 0x73_6c69_7073;
/// What a wheel turns in a slip beyond what it rolls, metres.
const SLIP_M: f64 = 0.002;

/// Size of the errors of wheel odometry; by default 1 % and 2 degrees per root metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelErrors {
    /// Standard deviation of the scale of all distances, percent: one draw per drive, as
    /// for wheels of a wrong diameter.
    pub scale_percent: f64,
    /// Standard deviation of the heading after a metre, degrees: a random walk over the
    /// distance that the robot's centre has driven. A turn in place adds nothing.
    pub heading_deg_per_sqrt_m: f64,
    /// Drift of the heading, degrees per metre driven: the same in every drive, as for
    /// wheels of different diameters. Above 0 the odometry turns left of the truth.
    pub drift_deg_per_m: f64,
    /// Mean of what the wheels turn without rolling, percent of the way: slips of 2 mm of
    /// either wheel, at random places. A slip moves the odometry 1 mm ahead and turns it by
    /// 1.7 degrees, the track of 69 mm; 1 percent is five slips per metre.
    pub slip_percent: f64,
}

impl WheelErrors {
    /// Exact odometry.
    pub const NONE: Self = Self {
        scale_percent: 0.0,
        heading_deg_per_sqrt_m: 0.0,
        drift_deg_per_m: 0.0,
        slip_percent: 0.0,
    };
}

impl Default for WheelErrors {
    fn default() -> Self {
        Self {
            scale_percent: 1.0,
            heading_deg_per_sqrt_m: 2.0,
            ..Self::NONE
        }
    }
}

/// Wheel odometry along a drive.
#[derive(Clone, Debug)]
pub struct WheelWalk {
    scale: f64,
    heading_deg_per_sqrt_m: f64,
    drift_deg_per_m: f64,
    errors: Generator,
    slips: Slips,
    /// The robot's position, and its position by odometry.
    true_place: Vector,
    believed: Vector,
    /// The heading by odometry less the true one.
    ahead_deg: f64,
}

impl WheelWalk {
    /// Starts at the true pose; draws the drive's scale.
    #[must_use]
    pub fn new(model: &WheelErrors, start: &Pose, mut errors: Generator) -> Self {
        // Of a copy: the other errors of a seed are the same with and without slips.
        let slips = u64::from(errors.clone().bits()) ^ SLIP_STREAM;
        let (normal, _) = standard_normal_pair(&mut errors);
        let place = Vector::from(start.position);
        Self {
            scale: 1.0 + 0.01 * model.scale_percent * f64::from(normal),
            heading_deg_per_sqrt_m: model.heading_deg_per_sqrt_m,
            drift_deg_per_m: model.drift_deg_per_m,
            slips: Slips::new(model.slip_percent, Generator::seeded(slips)),
            errors,
            true_place: place,
            believed: place,
            ahead_deg: 0.0,
        }
    }

    /// The pose by odometry when the robot has moved on to the given one.
    pub fn moved_to(&mut self, pose: &Pose) -> Pose {
        let place = Vector::from(pose.position);
        let way = place - self.true_place;
        self.true_place = place;
        let ahead = Turn::by_degrees(self.ahead_deg);
        self.believed = self.believed + way.turned(ahead).scaled(self.scale);
        let (normal, _) = standard_normal_pair(&mut self.errors);
        self.ahead_deg += self.heading_deg_per_sqrt_m * way.norm().sqrt() * f64::from(normal);
        self.ahead_deg += self.drift_deg_per_m * way.norm();
        for is_right in self.slips.within(way.norm()) {
            let heading = pose.heading.radians() + radians(self.ahead_deg);
            let ahead = Turn::by_radians(heading).direction();
            self.believed = self.believed + ahead.scaled(0.5 * SLIP_M);
            let turn_rad = SLIP_M / f64::from(DifferentialDrive::AMIRO.track_m);
            let turn_deg = turn_rad.to_degrees();
            self.ahead_deg += if is_right { turn_deg } else { -turn_deg };
        }
        let Vector { x, y } = self.believed;
        let heading = pose.heading.radians() + radians(self.ahead_deg);
        Pose::new(x as f32, y as f32, heading)
    }
}

/// Slips at random places of a way.
#[derive(Clone, Debug)]
struct Slips {
    /// Mean way between slips, metres; `None` without slips.
    between_m: Option<f64>,
    /// Way to the next slip, metres.
    next_m: f64,
    draws: Generator,
}

impl Slips {
    fn new(slip_percent: f64, draws: Generator) -> Self {
        let mut slips = Self {
            between_m: (slip_percent > 0.0).then(|| SLIP_M / (0.01 * slip_percent)),
            next_m: 0.0,
            draws,
        };
        slips.next_m = slips.draw_m();
        slips
    }

    /// Way from one slip to the next: exponentially distributed.
    fn draw_m(&mut self) -> f64 {
        let Some(between_m) = self.between_m else {
            return f64::INFINITY;
        };
        // In (0, 1]: the logarithm of 0 never occurs.
        let share = 1.0 - f64::from(uniform(&mut self.draws));
        -between_m * libm::log(share)
    }

    /// The slips on a piece of the way: whether it is the right wheel, for each.
    fn within(&mut self, way_m: f64) -> Vec<bool> {
        let mut slips = Vec::new();
        self.next_m -= way_m;
        while self.next_m <= 0.0 {
            slips.push(uniform_below(&mut self.draws, 2) == 1);
            self.next_m += self.draw_m();
        }
        slips
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(scale_percent: f64, heading_deg_per_sqrt_m: f64, seed: u64) -> WheelWalk {
        let model = WheelErrors {
            scale_percent,
            heading_deg_per_sqrt_m,
            ..WheelErrors::NONE
        };
        WheelWalk::new(&model, &Pose::default(), Generator::seeded(seed))
    }

    #[test]
    fn without_errors_odometry_is_the_truth() {
        let mut walk = walk(0.0, 0.0, 1);
        for step in 0..1_000_u16 {
            let pose = Pose::new(f32::from(step) * 7e-4, f32::from(step) * -3e-4, 0.4);
            assert_eq!(walk.moved_to(&pose), pose);
        }
    }

    #[test]
    fn scale_is_drawn_once_a_drive_with_the_stated_deviation() {
        // 4000 drives: 4 sigma / sqrt(n) of the mean are 0.063 %, 4 sqrt(2 / n) of the
        // variance 8.9 %.
        for seed in 1..=3 {
            let drives = (0..4_000).map(|drive| {
                let mut walk = walk(1.0, 0.0, seed * 10_000 + drive);
                let half = walk.moved_to(&Pose::new(1.0, 0.0, 0.0)).position.x;
                let end = walk.moved_to(&Pose::new(2.0, 0.0, 0.0)).position.x;
                assert!((end - 2.0 * half).abs() < 1e-6, "one scale a drive");
                100.0 * (f64::from(half) - 1.0)
            });
            let (sum, squares) = drives.fold((0.0, 0.0), |(sum, squares), percent| {
                (sum + percent, squares + percent * percent)
            });
            let (mean, variance) = (sum / 4_000.0, squares / 4_000.0);
            assert!(mean.abs() < 0.063, "seed {seed}: {mean} %");
            assert!((variance - 1.0).abs() < 0.089, "seed {seed}: {variance}");
        }
    }

    #[test]
    fn heading_wanders_with_the_root_of_the_way() {
        // 20 000 steps of 0.64 mm at 2 degrees a root metre: a step's variance is
        // 4 x 0.64e-3 square degrees; 4 / sqrt(n) of the mean, 4 sqrt(2 / n) = 4 % of
        // the variance. The steps go to and fro: places stay near 0, where f32 is fine.
        let expected = 4.0 * 0.64e-3;
        for seed in 1..=3 {
            let mut walk = walk(0.0, 2.0, seed);
            let (mut sum, mut squares, mut before) = (0.0, 0.0, 0.0);
            for step in 0..20_000 {
                let x = if step % 2 == 0 { 0.64e-3 } else { 0.0 };
                walk.moved_to(&Pose::new(x, 0.0, 0.0));
                let turned = walk.ahead_deg - before;
                before = walk.ahead_deg;
                sum += turned;
                squares += turned * turned;
            }
            let limit = 4.0 * (expected / 20_000.0_f64).sqrt();
            let mean: f64 = sum / 20_000.0;
            assert!(mean.abs() < limit, "seed {seed}: mean {mean}");
            let ratio: f64 = squares / 20_000.0 / expected;
            assert!((ratio - 1.0).abs() < 0.04, "seed {seed}: {ratio}");
        }
    }

    /// Believed poses along 1 m in steps of 0.64 mm, the last one first.
    fn end_of_a_metre(model: &WheelErrors, seed: u64) -> Pose {
        let mut walk = WheelWalk::new(model, &Pose::default(), Generator::seeded(seed));
        let mut end = Pose::default();
        for step in 1..=1_000_u16 {
            end = walk.moved_to(&Pose::new(1e-3 * f32::from(step), 0.0, 0.0));
        }
        end
    }

    #[test]
    fn heading_drifts_by_the_stated_degrees_per_metre() {
        for drift_deg_per_m in [2.0, -2.0, 30.0] {
            let model = WheelErrors {
                drift_deg_per_m,
                ..WheelErrors::NONE
            };
            let end = end_of_a_metre(&model, 1);
            let turned = f64::from(end.heading.radians()).to_degrees();
            assert!((turned - drift_deg_per_m).abs() < 1e-3, "{turned}");
            // A circle: the chord of 1 m of arc lies half the angle beside the heading.
            let beside = f64::from(end.position.y).atan2(f64::from(end.position.x));
            let half = 0.5 * drift_deg_per_m.to_radians();
            assert!((beside - half).abs() < 1e-3, "{beside} against {half}");
        }
    }

    #[test]
    fn slips_have_the_stated_mean_and_turn_to_both_sides() {
        // Five slips per metre of 1.66 degrees and 1 mm ahead each; over 2000 drives the
        // mean number has a deviation of sqrt(5 / 2000) = 0.05, four of them are 0.2.
        let model = WheelErrors {
            slip_percent: 1.0,
            ..WheelErrors::NONE
        };
        let mut count = 0;
        let (mut sum, mut squares) = (0.0, 0.0);
        for seed in 0..2_000 {
            let mut slips = Slips::new(1.0, Generator::seeded(seed));
            for is_right in (0..1_000)
                .flat_map(|_| slips.within(1e-3))
                .collect::<Vec<_>>()
            {
                count += 1;
                sum += if is_right { 1.0 } else { -1.0 };
            }
            if seed < 200 {
                let turned = end_of_a_metre(&model, seed).heading.radians();
                squares += f64::from(turned) * f64::from(turned);
            }
        }
        let mean = f64::from(count) / 2_000.0;
        assert!((mean - 5.0).abs() < 0.2, "{mean} slips per metre");
        // 4 sqrt(10 000).
        assert!(f64::abs(sum) < 400.0, "{sum} more to the left");
        // 5 x (2 / 69)^2 square radians: 4 sqrt(2 / 200) of the variance are 40 %.
        let ratio = squares / 200.0 / (5.0 * (2.0 / 69.0_f64).powi(2));
        assert!((ratio - 1.0).abs() < 0.45, "{ratio}");
    }

    #[test]
    fn believed_heading_bends_the_believed_way() {
        let mut walk = walk(0.0, 50.0, 1);
        let bent = walk.moved_to(&Pose::new(1.0, 0.0, 0.0));
        let end = walk.moved_to(&Pose::new(2.0, 0.0, 0.0));
        let (ahead, way) = (bent.heading.radians(), end.position - bent.position);
        assert!(ahead.abs() > 0.1, "{ahead}");
        let along = Vector::from(way).dot(Turn::by_radians(ahead).direction());
        assert!((along - 1.0).abs() < 1e-6, "{along}");
        // Turning in place adds no error.
        let turned = walk.moved_to(&Pose::new(2.0, 0.0, 1.0));
        assert!((end.motion_to(&turned).turn.radians() - 1.0).abs() < 1e-6);
    }
}
