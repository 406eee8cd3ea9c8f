//! Estimates when the pose in an odometry frame was computed; frames carry no stamp.
//!
//! The DiWheelDrive updates its odometry every 50 ms and sends it with another period, so
//! that a received pose is 0 to 50 ms old. One or two updates lie between two frames, and
//! a driving robot covers twice the distance in two. If the distance is twice those before
//! and after it, two updates lie in that interval, the first of them right after the frame
//! before. This gives the time of an update, as exact as the interval exceeds 50 ms. From
//! then on whole periods are counted, and every frame close to an update makes the
//! estimate more exact.

use crate::geometry::Pose;

/// Time between two updates.
const PERIOD_US: u64 = 50_000;

/// Age of the odometry in a frame before there is an estimate: the mean.
pub const ODOMETRY_AGE_US: u64 = 25_000;

/// Distances below this are not used, metres: six of the message's steps of 256 um.
const MIN_DISTANCE_M: f32 = 0.0015;

/// The clocks of two boards differ by less than one part in this.
const DRIFT: u64 = 10_000;

/// One frame and the distance to it.
#[derive(Clone, Copy, Debug)]
struct ReceivedFrame {
    at_us: u64,
    stamp_us: u64,
    pose: Pose,
    distance_m: f32,
}

/// Bounds of the time of an update, the newest before a frame or the one after it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct UpdateWindow {
    low_us: u64,
    high_us: u64,
}

impl UpdateWindow {
    const fn middle_us(self) -> u64 {
        self.low_us + (self.high_us - self.low_us) / 2
    }

    /// Shifted by whole periods so that it begins as late as possible up to `at_us`.
    const fn shifted_to(self, at_us: u64) -> Self {
        let since_us = if at_us >= self.low_us {
            (at_us - self.low_us) % PERIOD_US
        } else {
            PERIOD_US - 1 - (self.low_us - at_us - 1) % PERIOD_US
        };
        let low_us = at_us.saturating_sub(since_us);
        Self {
            low_us,
            high_us: low_us.saturating_add(self.high_us - self.low_us),
        }
    }

    /// Widened by the drift of two clocks in a time; `None` if it spans a period.
    fn widened(self, by_us: u64) -> Option<Self> {
        let widened = Self {
            low_us: self.low_us.saturating_sub(by_us / DRIFT),
            high_us: self.high_us.saturating_add(by_us / DRIFT),
        };
        (widened.high_us - widened.low_us < PERIOD_US).then_some(widened)
    }

    /// The intersection of both, up to whole periods; `None` if it is empty.
    fn and(self, other: Self) -> Option<Self> {
        // Either may begin within the other.
        let first = self.shifted_to(other.low_us);
        let second = other.shifted_to(self.low_us);
        let both = |a: Self, b: Self| {
            (b.low_us <= a.high_us).then(|| Self {
                low_us: b.low_us,
                high_us: a.high_us.min(b.high_us),
            })
        };
        both(first, other).or_else(|| both(second, self))
    }
}

/// Stamps the odometry's frames.
///
/// Without motion, and in its first quarter of a second, poses are stamped
/// [`ODOMETRY_AGE_US`] before their frame, which is off by 25 ms at most; afterwards by
/// some milliseconds, and in the end by one. A frame that coincides with an update, while
/// the robot stands or changes its speed, may be assigned to the update before: one frame
/// in a hundred is then a whole period off.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UpdateClock {
    last: Option<ReceivedFrame>,
    before: Option<ReceivedFrame>,
    window: Option<UpdateWindow>,
    /// The distance from one update to the next, metres.
    distance_per_update_m: f32,
}

impl UpdateClock {
    /// The stamp of the pose in a frame received now; stamps never decrease. About a
    /// hundred instructions.
    pub(super) fn stamp(&mut self, at_us: u64, pose: Pose) -> u64 {
        let Some(last) = self.last else {
            let stamp_us = at_us.saturating_sub(ODOMETRY_AGE_US);
            self.last = Some(ReceivedFrame {
                at_us,
                stamp_us,
                pose,
                distance_m: 0.0,
            });
            return stamp_us;
        };
        let distance_m = (pose.position - last.pose.position).norm();
        self.find_double_update(&last, distance_m);
        let elapsed_us = at_us.saturating_sub(last.at_us);
        self.window = self.window.and_then(|window| window.widened(elapsed_us));
        let stamp_us = match self.window {
            Some(window) => self.newest_update(window.shifted_to(at_us), at_us, &last, distance_m),
            None => at_us.saturating_sub(ODOMETRY_AGE_US),
        };
        let stamp_us = stamp_us.max(last.stamp_us);
        let updates = periods(stamp_us - last.stamp_us);
        if self.window.is_some() && updates > 0.0 {
            self.distance_per_update_m = distance_m / updates;
        }
        self.before = Some(last);
        self.last = Some(ReceivedFrame {
            at_us,
            stamp_us,
            pose,
            distance_m,
        });
        stamp_us
    }

    /// Narrows the window if the distance to the last frame was twice the one before and
    /// this one.
    fn find_double_update(&mut self, last: &ReceivedFrame, distance_m: f32) {
        let Some(before) = self.before else {
            return;
        };
        let (least_m, most_m) = (
            before.distance_m.min(distance_m),
            before.distance_m.max(distance_m),
        );
        let is_double = last.distance_m > 1.6 * most_m && last.distance_m < 2.5 * least_m;
        let spare_us = last
            .at_us
            .saturating_sub(before.at_us)
            .checked_sub(PERIOD_US);
        let (true, Some(spare_us @ 0..PERIOD_US)) =
            (is_double && least_m > MIN_DISTANCE_M, spare_us)
        else {
            return;
        };
        // The first of the two came after the frame before, the second up to the last.
        let seen = UpdateWindow {
            low_us: before.at_us,
            high_us: before.at_us + spare_us,
        };
        let joined = self.window.and_then(|window| window.and(seen));
        self.window = Some(joined.unwrap_or(seen));
    }

    /// The newest update up to a frame, of a window that begins before it.
    ///
    /// A window that reaches beyond the frame leaves open whether its update is in the
    /// frame. The distance decides, if it fits a whole number of updates.
    fn newest_update(
        &mut self,
        window: UpdateWindow,
        at_us: u64,
        last: &ReceivedFrame,
        distance_m: f32,
    ) -> u64 {
        if window.high_us <= at_us {
            return window.middle_us();
        }
        let in_time = UpdateWindow {
            high_us: at_us,
            ..window
        };
        let too_late = UpdateWindow {
            low_us: at_us,
            ..window
        };
        let fresh_us = in_time.middle_us();
        let old_us = too_late.middle_us().saturating_sub(PERIOD_US);
        let off_m = |stamp_us: u64| {
            let updates = periods(stamp_us.saturating_sub(last.stamp_us));
            (distance_m - updates * self.distance_per_update_m).abs()
        };
        let is_fresh = off_m(fresh_us) < off_m(old_us);
        let (stamp_us, narrowed) = if is_fresh {
            (fresh_us, in_time)
        } else {
            (old_us, too_late)
        };
        let is_clear = off_m(stamp_us) < 0.25 * self.distance_per_update_m;
        if self.distance_per_update_m > MIN_DISTANCE_M && is_clear {
            self.window = Some(narrowed);
        }
        stamp_us
    }
}

/// Whole periods in a time, to the nearest.
fn periods(time_us: u64) -> f32 {
    (time_us.saturating_add(PERIOD_US / 2) / PERIOD_US) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Generator, uniform_below};

    const FRAME_US: u64 = 63_000;

    /// Errors of the stamps, milliseconds, of so many frames of a robot that has always
    /// driven at a speed; frames are late by up to `jitter_us`.
    fn errors_ms(phase_us: u64, speed_m_per_s: f32, jitter_us: u32, frames: u64) -> Vec<f32> {
        let mut clock = UpdateClock::default();
        let mut generator = Generator::seeded(phase_us);
        let mut last_us = 0;
        (1..=frames)
            .map(|frame| {
                let late_us = u64::from(uniform_below(&mut generator, jitter_us + 1));
                let at_us = 1_000_000 + frame * FRAME_US + late_us;
                let updated_us = at_us - (at_us - phase_us) % PERIOD_US;
                let distance_m = (updated_us - phase_us) as f32 * 1e-6 * speed_m_per_s;
                // As the message leaves it.
                let x = (distance_m / 256e-6) as u32 as f32 * 256e-6;
                let stamp_us = clock.stamp(at_us, Pose::new(x, 0.0, 0.0));
                assert!(stamp_us >= last_us && stamp_us <= at_us);
                last_us = stamp_us;
                (stamp_us as f32 - updated_us as f32) * 1e-3
            })
            .collect()
    }

    fn worst(errors: &[f32]) -> f32 {
        errors
            .iter()
            .fold(0.0, |worst, error| worst.max(error.abs()))
    }

    #[test]
    fn updates_are_found_within_a_second_and_then_to_a_millisecond_or_two() {
        for phase_us in (0..PERIOD_US).step_by(700) {
            let errors = errors_ms(phase_us, 0.08, 0, 120);
            // A double way comes every fourth or fifth frame; half of its 13 ms remain.
            let soon = worst(&errors[10..]);
            assert!(soon < 6.6, "phase {phase_us}: {errors:?}");
            let late = worst(&errors[60..]);
            assert!(late < 2.1, "phase {phase_us}: {errors:?}");
        }
    }

    #[test]
    fn frames_that_are_late_by_some_milliseconds_are_counted_all_the_same() {
        for phase_us in (0..PERIOD_US).step_by(700) {
            let errors = errors_ms(phase_us, 0.08, 4_000, 120);
            let late = worst(&errors[20..]);
            assert!(late < 8.6, "phase {phase_us}: {errors:?}");
        }
    }

    #[test]
    fn a_robot_that_stands_or_creeps_is_stamped_with_the_mean_age() {
        for speed in [0.0, 0.002] {
            let errors = errors_ms(3_000, speed, 0, 100);
            assert!(worst(&errors) < 25.1, "{errors:?}");
            let mean = errors.iter().sum::<f32>() / 100.0;
            assert!(mean.abs() < 1.0, "{mean}");
        }
    }

    #[test]
    fn a_board_that_restarts_is_found_again() {
        let mut clock = UpdateClock::default();
        let mut errors = Vec::new();
        for frame in 1..=200_u64 {
            let at_us = frame * FRAME_US;
            let phase_us = if frame < 100 { 5_000 } else { 31_000 };
            let updated_us = at_us - (at_us - phase_us) % PERIOD_US;
            let x = updated_us as f32 * 1e-6 * 0.08;
            let stamp_us = clock.stamp(at_us, Pose::new(x, 0.0, 0.0));
            errors.push((stamp_us as f32 - updated_us as f32) * 1e-3);
        }
        assert!(worst(&errors[80..99]) < 2.1, "{errors:?}");
        assert!(worst(&errors[180..]) < 2.1, "{errors:?}");
    }
}
