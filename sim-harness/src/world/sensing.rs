//! Readings of a robot's infrared sensors in a world: optics, noise, register.

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{Photometry, Ring, SENSORS, Sample, SensorMask};
use amiro_ipf::random::{Generator, standard_normal_pair};

use super::optics::{FULL, Optics};
use super::{Options, Physics, Scenario, SensorPose, Shape};
use crate::geometry::Vector;

/// Separates the world's noise from a filter with the same seed: "world" in ASCII.
const NOISE_STREAM: u64 = 0x77_6f72_6c64;

/// Surfaces beyond this range are ignored, metres: they return a quarter of a count, a
/// twentieth of the noise.
const REACH_M: f64 = 2.0;
/// Stored offset of a sensor, raw counts: the VCNL4020 reads 2000 to 3000 with nothing
/// in range.
const OFFSET: f64 = 2_516.0;

/// The sensors of one robot: their law, their rays, their noise.
#[derive(Clone, Debug)]
pub struct Sensing {
    ring: Ring,
    used: SensorMask,
    photometry: Photometry,
    /// Gain of each sensor relative to the law's.
    gains: [f64; SENSORS],
    optics: Optics,
    noise: Generator,
}

impl Sensing {
    /// Sensors with the given law and a noise of their own.
    #[must_use]
    pub fn new(
        ring: Ring,
        used: SensorMask,
        photometry: Photometry,
        physics: Physics,
        noise: Generator,
    ) -> Self {
        Self {
            ring,
            used,
            photometry,
            gains: [1.0; SENSORS],
            optics: Optics::new(physics, &photometry),
            noise,
        }
    }

    /// The sensors of a simulated drive.
    #[must_use]
    pub fn of(scenario: &Scenario, seed: u64, options: &Options) -> Self {
        let (ring, used) = scenario.ring();
        Self::new(
            ring,
            used,
            options.photometry(&Photometry::VCNL4020),
            options.physics,
            Generator::seeded(seed ^ NOISE_STREAM),
        )
        .with_gains(options.gains(seed))
    }

    /// The same sensors with gains of their own, relative to the law's.
    #[must_use]
    pub fn with_gains(self, gains: [f64; SENSORS]) -> Self {
        Self { gains, ..self }
    }

    /// Replaces the generator of the noise.
    pub fn set_noise(&mut self, noise: Generator) {
        self.noise = noise;
    }

    /// One sample of each sensor from the given pose; unused ones are missing.
    ///
    /// `drift_counts` is the drift of every sensor's offset from the stored one. Each call
    /// draws the same number of random numbers.
    pub fn sample(
        &mut self,
        shapes: &[Shape],
        pose: &Pose,
        drift_counts: f64,
    ) -> [Sample; SENSORS] {
        self.above_offset(shapes, pose, drift_counts)
            .map(|counts| match counts {
                None => Sample::Missing,
                Some(counts) if counts >= FULL - OFFSET => Sample::Saturated,
                Some(counts) => Sample::Counts(counts.max(-OFFSET) as i32),
            })
    }

    /// The sensors' registers where [`Self::sample`] gives samples; 0 for unused sensors.
    ///
    /// `offsets` are the sensors' stored offsets, raw counts. Unless the register reaches
    /// one of its ends, the counts less the offset are those of the sample, bit for bit.
    pub fn raw_counts(
        &mut self,
        shapes: &[Shape],
        pose: &Pose,
        drift_counts: f64,
        offsets: &[u16; SENSORS],
    ) -> [u16; SENSORS] {
        let mut raw = [0; SENSORS];
        let above = self.above_offset(shapes, pose, drift_counts);
        for ((register, above), offset) in raw.iter_mut().zip(above).zip(offsets) {
            if let Some(above) = above {
                // Whole and within the register's 16 bits.
                *register = (f64::from(*offset) + above).clamp(0.0, FULL) as u16;
            }
        }
        raw
    }

    /// Whole counts above the stored offset, without the limits of the register.
    fn above_offset(
        &mut self,
        shapes: &[Shape],
        pose: &Pose,
        drift_counts: f64,
    ) -> [Option<f64>; SENSORS] {
        let centre = Vector::from(pose.position);
        let near = |shape: &&Shape| {
            let from_robot = (shape.centre() - centre).norm();
            from_robot < REACH_M + f64::from(self.ring.radius_m) + shape.reach_m()
        };
        let near: Vec<Shape> = shapes.iter().filter(near).copied().collect();
        let noise = self.noise();
        let mut counts = [None; SENSORS];
        for sensor_pose in SensorPose::of(&self.ring, self.used, pose) {
            let signal = self.optics.signal(&near, &sensor_pose);
            if let (Some(counts), Some(gain), Some(noise)) = (
                counts.get_mut(sensor_pose.sensor),
                self.gains.get(sensor_pose.sensor),
                noise.get(sensor_pose.sensor),
            ) {
                let above_beta = gain * signal + noise + drift_counts;
                let raw = OFFSET + f64::from(self.photometry.beta_counts) + above_beta;
                *counts = Some(raw.round() - OFFSET);
            }
        }
        counts
    }

    fn noise(&mut self) -> [f64; SENSORS] {
        let sigma = f64::from(self.photometry.sigma_counts);
        let mut noise = [0.0; SENSORS];
        for pair in noise.chunks_exact_mut(2) {
            let (first, second) = standard_normal_pair(&mut self.noise);
            for (value, normal) in pair.iter_mut().zip([first, second]) {
                *value = sigma * f64::from(normal);
            }
        }
        noise
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Scenario;

    /// One sensor straight ahead, 50 mm before the robot's centre at the origin.
    fn sensing(sigma_counts: f32, seed: u64) -> Sensing {
        let mut ring = Ring::AMIRO;
        ring.axis_rad[0] = 0.0;
        let photometry = Photometry {
            sigma_counts,
            ..Photometry::VCNL4020
        };
        let used = SensorMask::NONE.with(0);
        Sensing::new(
            ring,
            used,
            photometry,
            Physics::Matched,
            Generator::seeded(seed),
        )
    }

    fn shapes(tables: &str) -> Vec<Shape> {
        let text = format!(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\nspeed_m_per_s = 0.08\n\
             start = [0, 0, 0]\n{tables}"
        );
        Scenario::parse(&text).unwrap().shapes
    }

    fn counts(tables: &str) -> Sample {
        sensing(0.0, 1).sample(&shapes(tables), &Pose::default(), 0.0)[0]
    }

    fn number(sample: Sample) -> Option<i32> {
        match sample {
            Sample::Counts(counts) => Some(counts),
            Sample::Saturated | Sample::Missing => None,
        }
    }

    const WALL: &str = "[[box]]\nmin = [0.15, -0.2]\nmax = [0.2, 0.2]\n";

    #[test]
    fn a_wall_across_the_axis_gives_the_counts_of_the_law() {
        // 0.942694 / 0.1^2 - 16.25 = 78.02.
        assert_eq!(counts(WALL), Sample::Counts(78));
        // A cylinder's nearest point is on the axis as well.
        let cylinder = "[[cylinder]]\ncenter = [0.2, 0]\nradius_m = 0.05\n";
        assert_eq!(counts(cylinder), Sample::Counts(78));
        assert_eq!(counts(""), Sample::Counts(-16));
    }

    #[test]
    fn signal_is_proportional_to_reflectivity() {
        // 2 x 94.27 - 16.25 = 172.3, 0.5 x 94.27 - 16.25 = 30.9.
        let with = |share| counts(&format!("{WALL}reflectivity = {share}\n"));
        assert_eq!(with(2.0), Sample::Counts(172));
        assert_eq!(with(0.5), Sample::Counts(31));
    }

    #[test]
    fn signal_is_proportional_to_a_sensor_s_gain_and_noise_and_offset_are_not() {
        // 0.5 x 94.27 - 16.25 = 30.9.
        let mut gains = [1.0; SENSORS];
        gains[0] = 0.5;
        let mut dim = sensing(0.0, 1).with_gains(gains);
        let read = |sensing: &mut Sensing, tables| {
            sensing.sample(&shapes(tables), &Pose::default(), 0.0)[0]
        };
        assert_eq!(read(&mut dim, WALL), Sample::Counts(31));
        assert_eq!(read(&mut dim, ""), Sample::Counts(-16));
        let mut noisy = sensing(4.57, 1);
        let mut noisy_and_dim = noisy.clone().with_gains(gains);
        assert_eq!(read(&mut noisy, ""), read(&mut noisy_and_dim, ""));
    }

    #[test]
    fn what_stands_in_front_hides_what_is_behind() {
        // A dark plate before a bright wall: 0.1 x 0.942694 / 0.05^2 - 16.25 = 21.5.
        let plate = "[[box]]\nmin = [0.10, -0.2]\nmax = [0.11, 0.2]\nreflectivity = 0.1\n";
        assert_eq!(counts(&format!("{WALL}{plate}")), Sample::Counts(21));
        let beside = "[[box]]\nmin = [-0.2, -0.2]\nmax = [-0.1, 0.2]\n";
        assert_eq!(counts(beside), Sample::Counts(-16), "behind the sensor");
    }

    #[test]
    fn off_the_axis_the_lobe_weakens_the_return() {
        // A small post at 45 degrees and 100 mm, surface at 99 mm:
        // 0.942694 cos(1.2365 x 45 deg) / 0.099^2 - 16.25 = 38.1 counts.
        let post = "[[cylinder]]\ncenter = [0.120711, 0.070711]\nradius_m = 0.001\n";
        let read = number(counts(post)).unwrap();
        assert!((read - 38).abs() <= 1, "{read}");
    }

    #[test]
    fn contact_fills_the_register() {
        // 3 mm: 104 744 counts.
        let touching = "[[box]]\nmin = [0.053, -0.2]\nmax = [0.2, 0.2]\n";
        assert_eq!(counts(touching), Sample::Saturated);
        let inside = "[[box]]\nmin = [0.04, -0.2]\nmax = [0.2, 0.2]\n";
        assert_eq!(counts(inside), Sample::Saturated);
    }

    #[test]
    fn noise_has_the_moments_of_the_law() {
        // 40 000 samples: 4 sigma / sqrt(n) of the mean is 0.091 counts, 4 sqrt(2/n) of
        // the variance 2.8 %; rounding to whole counts adds a variance of 1/12.
        let sigma = Photometry::VCNL4020.sigma_counts;
        for seed in 1..=3 {
            let mut sensing = sensing(sigma, seed);
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..40_000 {
                let sample = sensing.sample(&[], &Pose::default(), 0.0)[0];
                let read = number(sample).unwrap();
                sum += f64::from(read);
                squares += f64::from(read) * f64::from(read);
            }
            let mean = sum / 40_000.0;
            let variance = squares / 40_000.0 - mean * mean;
            let expected = f64::from(sigma * sigma) + 1.0 / 12.0;
            assert!((mean + 16.252).abs() < 0.091, "seed {seed}: mean {mean}");
            assert!(
                (variance / expected - 1.0).abs() < 0.028,
                "seed {seed}: {variance}"
            );
        }
    }

    #[test]
    fn a_register_holds_the_sample_and_the_sensors_own_offset() {
        let shapes = shapes(WALL);
        for seed in 1..=3 {
            let (mut samples, mut registers) = (sensing(4.57, seed), sensing(4.57, seed));
            for step in 0..100 {
                // From 95 mm before the wall to contact.
                let pose = Pose::new(1e-3 * step as f32, 0.0, 0.0);
                let offset = 2_300 + 7 * step;
                let sample = samples.sample(&shapes, &pose, 1.25)[0];
                let raw = registers.raw_counts(&shapes, &pose, 1.25, &[offset; SENSORS]);
                assert_eq!(raw[1..], [0; SENSORS - 1], "unused ones");
                match sample {
                    Sample::Counts(counts) if raw[0] < u16::MAX => {
                        assert_eq!(i32::from(raw[0]) - i32::from(offset), counts);
                    }
                    _ => assert!(step > 90 && raw[0] == u16::MAX, "{step}: {sample:?}"),
                }
            }
        }
    }

    #[test]
    fn a_register_ends_at_both_its_ends() {
        let touching = shapes("[[box]]\nmin = [0.053, -0.2]\nmax = [0.2, 0.2]\n");
        let raw = |shapes: &[Shape], offset| {
            let offsets = [offset; SENSORS];
            sensing(0.0, 1).raw_counts(shapes, &Pose::default(), 0.0, &offsets)[0]
        };
        assert_eq!(raw(&touching, 2_300), u16::MAX);
        // 16 counts below its offset with nothing in range.
        assert_eq!(raw(&[], 2_300), 2_284);
        assert_eq!(raw(&[], 3), 0);
    }
}
