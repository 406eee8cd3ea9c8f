//! The measurements of the ring's sensors at any time of a drive.

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{SENSORS, SensorMask};
use amiro_ipf::random::Generator;

use super::OFFSETS;
use crate::world::{Drive, Options, Scenario, Sensing, Shape};

/// Keeps the sensors' noise apart from a filter with the same seed: "robot".
const NOISE_STREAM: u64 = 0x72_6f62_6f74;

/// The world as the sensors of a driving robot measure it.
///
/// A count depends only on the seed, the sensor and the time, not on earlier calls.
#[derive(Clone, Debug)]
pub struct SensedWorld {
    shapes: Vec<Shape>,
    drive: Drive,
    options: Options,
    used: SensorMask,
    sensing: [Sensing; SENSORS],
    seed: u64,
}

impl SensedWorld {
    /// The world of a scenario, with the options of sensors except dropout.
    #[must_use]
    pub fn of(scenario: &Scenario, seed: u64, options: &Options) -> Self {
        // The profile does not matter here: the sensors are the same.
        let config = scenario.config(Profile::Paper);
        let alone = |sensor| {
            Sensing::new(
                config.ring,
                SensorMask::NONE.with(sensor),
                options.photometry(&config.photometry),
                options.physics,
                Generator::seeded(seed),
            )
            .with_gains(options.gains(seed))
        };
        Self {
            shapes: scenario.shapes.clone(),
            drive: Drive::of(scenario),
            options: *options,
            used: config.sensors,
            sensing: core::array::from_fn(alone),
            seed,
        }
    }

    /// The sensors that the robot has.
    #[must_use]
    pub const fn used(&self) -> SensorMask {
        self.used
    }

    /// The robot's drive.
    #[must_use]
    pub const fn drive(&self) -> &Drive {
        &self.drive
    }

    /// The counts of a measurement that ends at a time of the drive, nanoseconds; `None`
    /// for a sensor that the robot does not have. At negative times, before the drive, the
    /// robot stands at its start.
    pub fn raw_counts(&mut self, sensor: usize, drive_ns: i64) -> Option<u16> {
        if !self.used.contains(sensor) {
            return None;
        }
        let drive_us = u64::try_from(drive_ns / 1_000).unwrap_or(0);
        let pose = self.drive.pose_at(drive_us);
        let drift_counts = self.options.drift.at(drive_us, self.drive.end_us());
        let moment = drive_ns.cast_unsigned().rotate_left(20);
        let noise = Generator::seeded(self.seed ^ NOISE_STREAM ^ moment);
        let sensing = self.sensing.get_mut(sensor)?;
        sensing.set_noise(noise);
        let raw = sensing.raw_counts(&self.shapes, &pose, drift_counts, &OFFSETS);
        raw.get(sensor).copied()
    }

    /// Where the robot is at a time of the drive, microseconds.
    #[must_use]
    pub fn pose_at(&self, drive_us: u64) -> Pose {
        self.drive.pose_at(drive_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::standard;

    #[test]
    fn a_count_does_not_depend_on_earlier_counts() {
        let scenario = standard("msod").unwrap().unwrap();
        let mut once = SensedWorld::of(&scenario, 3, &Options::default());
        let mut often = once.clone();
        for sensor in 0..SENSORS {
            often.raw_counts(sensor, 7_000_000);
            let at_ns = 1_000_000_000 + sensor as i64;
            assert_eq!(
                once.raw_counts(sensor, at_ns),
                often.raw_counts(sensor, at_ns)
            );
        }
    }

    #[test]
    fn noise_of_neighbouring_moments_and_seeds_is_not_the_same() {
        let scenario = standard("msod").unwrap().unwrap();
        let mut counts = Vec::new();
        for seed in 1..=3 {
            let mut sensed_world = SensedWorld::of(&scenario, seed, &Options::default());
            // The robot stands before its drive: all that differs is noise.
            let far = (0..1_000).filter_map(|step| sensed_world.raw_counts(0, -8_000_000 * step));
            counts.push(far.map(f64::from).collect::<Vec<_>>());
        }
        for of_seed in &counts {
            let mean = of_seed.iter().sum::<f64>() / 1e3;
            let variance = of_seed.iter().map(|raw| (raw - mean).powi(2)).sum::<f64>() / 1e3;
            // sigma_s^2 is 20.9 counts^2, 4 sqrt(2 / n) of it 18 %; rounding adds 1/12.
            assert!((variance - 21.0).abs() < 3.8, "{variance}");
        }
        assert_ne!(counts[0], counts[1]);
        assert_ne!(counts[1], counts[2]);
    }
}
