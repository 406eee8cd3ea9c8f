//! Checks whether the raw samples of one sensor can be measurements.
//!
//! Two checks in integers, on raw samples of 16 bits at 125 Hz. Neither changes a sample;
//! a single spike passes.
//!
//! **Stuck.** A working sensor is noisy. With a standard deviation of one count, the
//! smallest seen on the robot is 2, and a mean on a count's centre, two samples are
//! equal with a probability below p = 0.39 (the central cell holds 0.383 of the normal
//! distribution and two samples agree with the sum of the cells' squares, 0.27; more
//! noise makes both smaller). A run of 125 equal ones begins at a given sample with a
//! probability below p^124 = 2e-51; ten hours have 4.5 million samples. A full register
//! is no fault: something touches the hull.
//!
//! **Garbage.** A surface that the robot drives past makes slopes, not spikes. A sample is
//! an error if it is a spike, beyond both neighbours in the same direction by more than
//! noise and proximity explain, or lies farther below the offset than in any sensor. A
//! spike right after an error does not count: the valley between two spikes is sound. The
//! density of errors decides, averaged with a time constant of 64 samples. Of uniform
//! random samples about 0.31 are errors; over 250 samples the density always rises above
//! 0.248 (20 000 sequences). Up to three random spikes in each 15 samples, the most that
//! the median over such a step bears, never raise it above 0.228 (18 million samples).

/// Equal samples in a row, of a moving robot, that show a stuck sensor: one second.
pub const STUCK_AFTER: u8 = 125;

/// A spike exceeds its neighbours by more than this, counts: ten standard deviations of
/// the noise.
const SPIKE: i32 = 50;

/// A sample farther below the offset than this is an error, counts. Sound offsets lie
/// down to 1500, 950 below the default of 2450.
const FAR_BELOW: i32 = 1_000;

/// Shift of the density's time constant: 64 samples, half a second. With 32 a run of
/// spikes takes the density to 0.264; with 128 garbage is not found within two seconds.
const MEMORY_SHIFT: u32 = 6;

/// A density of 1.
const ONE: u16 = 1 << 15;

/// Errors per sample above which a sensor is garbage: 0.236, between the two.
const GARBAGE_ABOVE: u16 = 7_733;

/// Errors per sample below which it is sound again: 0.15.
const SOUND_BELOW: u16 = 4_915;

/// Ambient light that saturates the proximity measurement, counts: 10 klx at 0.25 lx each.
pub const AMBIENT_SATURATION: u16 = 40_000;

/// State of the checks of one sensor.
#[derive(Clone, Copy, Debug)]
pub struct SignalCheck {
    last: Option<u16>,
    before: Option<u16>,
    equal: u8,
    /// Errors per sample, an exponential average, in units of 1 / [`ONE`].
    errors: u16,
    was_error: bool,
    garbage: bool,
}

impl SignalCheck {
    /// No sample yet, no fault.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            last: None,
            before: None,
            equal: 0,
            errors: 0,
            was_error: false,
            garbage: false,
        }
    }

    /// Takes the next raw sample of a sensor with this offset.
    ///
    /// While the robot stands, equal samples are not counted; a different one still ends
    /// a run.
    pub fn take(&mut self, raw: u16, offset: u16, moving: bool) {
        self.check_run(raw, moving);
        self.check_spike(raw, offset);
        self.before = self.last.replace(raw);
    }

    fn check_run(&mut self, raw: u16, moving: bool) {
        if raw == u16::MAX || self.last != Some(raw) {
            // The sample itself is the first of a run.
            self.equal = 1;
        } else if moving {
            self.equal = self.equal.saturating_add(1);
        }
    }

    /// A spike is detected one sample late, at the neighbour after it.
    fn check_spike(&mut self, raw: u16, offset: u16) {
        let offset = i32::from(offset);
        let is_spike = match (self.before, self.last) {
            (Some(before), Some(middle)) => {
                let middle = i32::from(middle);
                let margin = SPIKE.max((middle - offset) / 4);
                let from_before = middle - i32::from(before);
                let from_after = middle - i32::from(raw);
                (from_before > margin && from_after > margin)
                    || (from_before < -margin && from_after < -margin)
            }
            _ => false,
        };
        let is_far_below = i32::from(raw) < offset - FAR_BELOW;
        let is_error = is_far_below || (is_spike && !self.was_error);
        self.was_error = is_error;
        self.errors -= self.errors >> MEMORY_SHIFT;
        if is_error {
            self.errors += ONE >> MEMORY_SHIFT;
        }
        if self.errors > GARBAGE_ABOVE {
            self.garbage = true;
        } else if self.errors < SOUND_BELOW {
            self.garbage = false;
        }
    }

    /// Whether the sensor has delivered the same value for a second of driving.
    #[must_use]
    pub const fn is_stuck(&self) -> bool {
        self.equal >= STUCK_AFTER
    }

    /// Whether the samples cannot be measurements.
    #[must_use]
    pub const fn is_garbage(&self) -> bool {
        self.garbage
    }
}

impl Default for SignalCheck {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether this much ambient light saturates the proximity measurement.
#[must_use]
pub const fn is_ambient_saturated(ambient: u16) -> bool {
    ambient >= AMBIENT_SATURATION
}

#[cfg(test)]
mod tests {
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus as Generator;

    use super::*;

    const OFFSET: u16 = 2_450;

    /// A normal number of variance 1, from the sum of twelve uniform ones.
    fn normal(random: &mut Generator) -> f64 {
        (0..12)
            .map(|_| f64::from(random.next_u32()) / 4_294_967_296.0)
            .sum::<f64>()
            - 6.0
    }

    #[test]
    fn f10_125_equal_samples_are_stuck_and_124_are_not() {
        let mut check = SignalCheck::new();
        for sample in 1..=300 {
            check.take(2_470, OFFSET, true);
            assert_eq!(check.is_stuck(), sample >= 125, "sample {sample}");
        }
        check.take(2_471, OFFSET, true);
        assert!(!check.is_stuck());
    }

    #[test]
    fn f10_a_standing_robot_has_no_stuck_sensor() {
        let mut check = SignalCheck::new();
        for _ in 0..10_000 {
            check.take(2_470, OFFSET, false);
        }
        assert!(!check.is_stuck());
        // It drives off: one second later the sensor is stuck.
        for _ in 0..124 {
            check.take(2_470, OFFSET, true);
        }
        assert!(check.is_stuck());
    }

    #[test]
    fn f10_a_full_register_is_never_stuck() {
        let mut check = SignalCheck::new();
        for _ in 0..10_000 {
            check.take(u16::MAX, OFFSET, true);
            assert!(!check.is_stuck() && !check.is_garbage());
        }
    }

    #[test]
    fn f10_f14_ten_hours_of_clean_noise_raise_no_alarm() {
        // Ten hours at 125 Hz, a count of noise and more, with and without a surface.
        for (seed, sigma, mean) in [(1, 1.0, 2_450.0), (2, 1.0, 9_000.0), (3, 5.0, 2_600.5)] {
            let mut random = Generator::seed_from_u64(seed);
            let mut check = SignalCheck::new();
            let mut longest = 0;
            for sample in 0..4_500_000 {
                let raw = (mean + sigma * normal(&mut random)).round() as u16;
                check.take(raw, OFFSET, true);
                longest = longest.max(check.equal);
                let quiet = !check.is_stuck() && !check.is_garbage();
                assert!(quiet, "seed {seed}, sample {sample}");
            }
            // 0.39^(n - 1) * 4.5e6 < 1 from n = 18 on; 124 stay far away.
            assert!(longest < 25, "seed {seed}: {longest} equal samples");
        }
    }

    #[test]
    fn f14_uniform_random_samples_are_garbage_within_two_seconds() {
        for seed in 0..2_000 {
            let mut random = Generator::seed_from_u64(seed);
            let mut check = SignalCheck::new();
            let found = (0..250).any(|_| {
                check.take(random.next_u32() as u16, OFFSET, true);
                check.is_garbage()
            });
            assert!(found, "seed {seed}");
        }
    }

    #[test]
    fn f14_garbage_stays_garbage_and_ends_within_a_second() {
        let mut random = Generator::seed_from_u64(5);
        let mut check = SignalCheck::new();
        let mut sound = 0;
        for sample in 0..125_000 {
            check.take(random.next_u32() as u16, OFFSET, true);
            sound += u32::from(sample > 250 && !check.is_garbage());
        }
        assert_eq!(sound, 0, "of 1000 s");
        let after = (0..).find(|sample| {
            check.take(OFFSET + (sample % 3), OFFSET, true);
            !check.is_garbage()
        });
        // From a density of 0.6 even: 64 ln(0.6 / 0.15) = 89.
        assert!(after.unwrap() < 89, "{after:?} samples");
    }

    #[test]
    fn f11_up_to_three_spikes_in_fifteen_samples_are_not_garbage() {
        for seed in 0..20 {
            let mut random = Generator::seed_from_u64(seed);
            for spikes in 1..=3 {
                let mut check = SignalCheck::new();
                for _ in 0..2_000 {
                    let mut step = [OFFSET + 100; 15];
                    for _ in 0..spikes {
                        step[random.next_u32() as usize % 15] = random.next_u32() as u16 | 0x4000;
                    }
                    for raw in step {
                        check.take(raw, OFFSET, true);
                        assert!(!check.is_garbage(), "{spikes} spikes, seed {seed}");
                    }
                }
            }
        }
    }

    #[test]
    fn f11_the_worst_three_spikes_are_not_garbage() {
        let mut check = SignalCheck::new();
        for sample in 0..15_000 {
            let spike = matches!(sample % 15, 1 | 3 | 5);
            check.take(if spike { 60_000 } else { 2_500 }, OFFSET, true);
            assert!(!check.is_garbage(), "sample {sample}");
        }
    }

    #[test]
    fn f14_far_below_the_offset_is_no_measurement() {
        let mut check = SignalCheck::new();
        let found = (0..).find(|_| {
            check.take(0, OFFSET, false);
            check.is_garbage()
        });
        assert!(found.unwrap() < 20, "{found:?}");
        // A healthy sensor of a low offset that was never calibrated.
        let mut check = SignalCheck::new();
        for _ in 0..1_000 {
            check.take(1_500, OFFSET, false);
        }
        assert!(!check.is_garbage());
    }

    #[test]
    fn driving_past_a_corner_is_no_spike() {
        // 2340 counts at 20 mm, at 500 mm/s: toward a wall and away from it again.
        let mut check = SignalCheck::new();
        for _ in 0..1_000 {
            for millimetres in (20..=100).rev().step_by(4).chain((20..=100).step_by(4)) {
                let counts = 943_000 / (millimetres * millimetres);
                check.take(OFFSET + counts as u16, OFFSET, true);
                assert!(!check.is_garbage());
            }
        }
    }

    #[test]
    fn f12_ten_kilolux_saturate() {
        assert!(is_ambient_saturated(AMBIENT_SATURATION) && is_ambient_saturated(u16::MAX));
        assert!(!is_ambient_saturated(AMBIENT_SATURATION - 1));
    }
}
