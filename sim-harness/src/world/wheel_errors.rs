//! Wheel odometry: a wrong scale, and a random walk of the heading.

use amiro_ipf::geometry::Pose;
use amiro_ipf::random::{Generator, standard_normal_pair};

use crate::geometry::{Turn, Vector, radians};

/// Size of the errors of wheel odometry; by default 1 % and 2 degrees per root metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelErrors {
    /// Standard deviation of the scale of all distances, percent: one draw per drive, as
    /// for wheels of a wrong diameter.
    pub scale_percent: f64,
    /// Standard deviation of the heading after a metre, degrees: a random walk over the
    /// distance that the robot's centre has driven. A turn in place adds nothing.
    pub heading_deg_per_sqrt_m: f64,
}

impl Default for WheelErrors {
    fn default() -> Self {
        Self {
            scale_percent: 1.0,
            heading_deg_per_sqrt_m: 2.0,
        }
    }
}

/// Wheel odometry along a drive.
#[derive(Clone, Debug)]
pub struct WheelWalk {
    scale: f64,
    heading_deg_per_sqrt_m: f64,
    errors: Generator,
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
        let (normal, _) = standard_normal_pair(&mut errors);
        let place = Vector::from(start.position);
        Self {
            scale: 1.0 + 0.01 * model.scale_percent * f64::from(normal),
            heading_deg_per_sqrt_m: model.heading_deg_per_sqrt_m,
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
        let Vector { x, y } = self.believed;
        let heading = pose.heading.radians() + radians(self.ahead_deg);
        Pose::new(x as f32, y as f32, heading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(scale_percent: f64, heading_deg_per_sqrt_m: f64, seed: u64) -> WheelWalk {
        let model = WheelErrors {
            scale_percent,
            heading_deg_per_sqrt_m,
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
