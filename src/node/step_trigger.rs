//! The sample-per-speed rule: a step is due after a given travelled distance.

/// Counts the travelled distance until a step is due.
///
/// Distance is the signed travel along the robot's heading, so the jitter of an
/// odometry at rest cancels and turning in place counts nothing. What exceeds a step
/// is carried over: over a long way the mean step is exact at any sampling rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepTrigger {
    travelled_m: f32,
}

impl StepTrigger {
    /// Adds a travelled distance, metres; returns whether a step is due at its end.
    ///
    /// At most one step a call: a piece longer than a step gives one step and loses
    /// the whole steps inside it, not the remainder.
    pub fn advance(&mut self, travel_m: f32, step_m: f32) -> bool {
        self.travelled_m += travel_m;
        let whole_steps = (self.travelled_m / step_m) as i32;
        self.travelled_m -= whole_steps as f32 * step_m;
        whole_steps != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(pieces: impl Iterator<Item = f32>) -> usize {
        let mut trigger = StepTrigger::default();
        pieces
            .filter(|&piece| trigger.advance(piece, 0.010))
            .count()
    }

    #[test]
    fn a_metre_has_a_hundred_steps_at_any_speed() {
        for speed_m_per_s in [0.04_f32, 0.08, 0.16, 0.5, 1.2] {
            let piece = speed_m_per_s / 125.0;
            let samples = (1.0 / piece) as usize;
            let steps = steps(core::iter::repeat_n(piece, samples));
            assert!(steps.abs_diff(100) <= 1, "{speed_m_per_s} m/s: {steps}");
        }
    }

    #[test]
    fn rows_of_six_millimetres_still_give_a_step_per_ten() {
        assert_eq!(steps(core::iter::repeat_n(0.006_001, 100)), 60);
    }

    #[test]
    fn jitter_at_rest_never_steps() {
        let jitter = (0..100_000).map(|i| if i % 2 == 0 { 256e-6 } else { -256e-6 });
        assert_eq!(steps(jitter), 0);
    }

    #[test]
    fn backward_steps_as_forward() {
        assert_eq!(steps(core::iter::repeat_n(-0.001, 101)), 10);
    }
}
