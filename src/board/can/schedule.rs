//! The schedule of the ring's eight frames.

use crate::model::{SENSORS, SensorMask};

/// Between the first frames of two cycles, microseconds: the robots' 63 ms.
pub const CYCLE_US: u64 = 63_000;

/// Between two frames of a cycle, microseconds: some receivers lose closer frames.
pub const LEAST_GAP_US: u64 = 3_000;

/// Paces the ring's frames: sensors 0 to 7 once in 63 ms, 3 ms apart at least.
///
/// A sensor without a reading has no frame, because receivers take a zero for free space.
/// After a late call the rest of the cycle follows later, never two frames at once; missed
/// cycles are not made up for.
#[derive(Clone, Copy, Debug, Default)]
pub struct RingSchedule {
    /// When the cycle began and when its last frame was sent, if there was one.
    cycle: Option<(u64, u64)>,
    /// The next sensor of the cycle; 8 at its end.
    next: usize,
}

impl RingSchedule {
    /// Whether it can be time for a frame; otherwise [`RingSchedule::due`] gives none
    /// and `present` need not be computed.
    #[must_use]
    pub const fn may_be_due(&self, now_us: u64) -> bool {
        let Some((began_us, sent_us)) = self.cycle else {
            return true;
        };
        now_us.saturating_sub(sent_us) >= LEAST_GAP_US
            && (self.next < SENSORS || now_us.saturating_sub(began_us) >= CYCLE_US)
    }

    /// The sensor whose frame is to be sent now, of those in `present`; `None` if it is
    /// not time.
    ///
    /// The returned sensor counts as sent. Nothing is due before the last time.
    pub fn due(&mut self, now_us: u64, present: SensorMask) -> Option<usize> {
        let Some((began_us, sent_us)) = self.cycle else {
            return self.next_of_cycle(now_us, now_us, present);
        };
        if now_us.saturating_sub(sent_us) < LEAST_GAP_US {
            return None;
        }
        let rest = self.next_of_cycle(began_us, now_us, present);
        let after_us = now_us.saturating_sub(began_us);
        if rest.is_some() || after_us < CYCLE_US {
            return rest;
        }
        // The next cycle began when it should have, unless that one is over too.
        self.next = 0;
        self.next_of_cycle(now_us - after_us % CYCLE_US, now_us, present)
    }

    /// The next present sensor of the cycle that began at the given time.
    fn next_of_cycle(&mut self, began_us: u64, now_us: u64, present: SensorMask) -> Option<usize> {
        let sensor = (self.next..SENSORS).find(|sensor| present.contains(*sensor))?;
        self.next = sensor + 1;
        self.cycle = Some((began_us, now_us));
        Some(sensor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What is sent with a call every `period_us` for `length_us`: times and
    /// sensors.
    fn sent(period_us: u64, length_us: u64, present: SensorMask) -> Vec<(u64, usize)> {
        let mut schedule = RingSchedule::default();
        (0..length_us / period_us)
            .map(|turn| 1_000_000 + turn * period_us)
            .filter_map(|now_us| Some((now_us, schedule.due(now_us, present)?)))
            .collect()
    }

    #[test]
    fn eight_frames_take_24_ms_and_then_is_silence_to_the_end_of_63() {
        let sent = sent(1_000, 126_000, SensorMask::ALL);
        let expected: Vec<(u64, usize)> = [0, 63_000]
            .into_iter()
            .flat_map(|cycle| (0..8).map(move |i| (1_000_000 + cycle + 3_000 * i as u64, i)))
            .collect();
        assert_eq!(sent, expected);
    }

    #[test]
    fn missing_sensor_is_left_out_and_the_others_close_up() {
        let present = SensorMask::NONE.with(0).with(3).complement();
        let sensors: Vec<(u64, usize)> = sent(1_000, 63_000, present);
        let expected = [1, 2, 4, 5, 6, 7].into_iter().enumerate();
        let expected: Vec<(u64, usize)> = expected
            .map(|(place, sensor)| (1_000_000 + 3_000 * place as u64, sensor))
            .collect();
        assert_eq!(sensors, expected);
    }

    #[test]
    fn nothing_is_sent_without_sensors_and_the_first_that_comes_back_at_once() {
        let mut schedule = RingSchedule::default();
        assert_eq!(schedule.due(5, SensorMask::NONE), None);
        assert_eq!(schedule.due(6, SensorMask::NONE.with(4)), Some(4));
        assert_eq!(schedule.due(9_000, SensorMask::NONE), None);
        assert_eq!(schedule.due(700_000, SensorMask::NONE), None);
        assert_eq!(schedule.due(700_001, SensorMask::ALL), Some(0));
    }

    #[test]
    fn ticks_of_4_ms_keep_the_cycle_in_the_mean() {
        // No cycle begins on its millisecond, but each on the tick after it.
        let sent = sent(4_000, 63_000_000, SensorMask::ALL);
        assert!(sent.len().abs_diff(8_000) <= 8, "{}", sent.len());
    }

    #[test]
    fn after_the_eighth_frame_nothing_may_be_due_until_the_next_cycle() {
        let mut schedule = RingSchedule::default();
        for sensor in 0..8 {
            let now_us = 3_000 * sensor as u64;
            assert!(schedule.may_be_due(now_us));
            assert_eq!(schedule.due(now_us, SensorMask::ALL), Some(sensor));
            assert!(!schedule.may_be_due(now_us + 2_999));
        }
        for now_us in [24_000, 40_000, 62_999] {
            assert!(!schedule.may_be_due(now_us), "{now_us} us");
        }
        assert!(schedule.may_be_due(63_000));
    }

    #[test]
    fn missed_cycles_are_not_made_up_for() {
        let mut schedule = RingSchedule::default();
        assert_eq!(schedule.due(0, SensorMask::ALL), Some(0));
        // The rest of the late cycle, then one cycle: never a burst.
        let late: Vec<usize> = (0..16)
            .filter_map(|i| schedule.due(10_000_000 + 3_000 * i, SensorMask::ALL))
            .collect();
        assert_eq!(late, [1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn clock_that_goes_back_sends_nothing_until_it_has_caught_up() {
        let mut schedule = RingSchedule::default();
        assert_eq!(schedule.due(1_000_000, SensorMask::ALL), Some(0));
        assert_eq!(schedule.due(5, SensorMask::ALL), None);
        assert_eq!(schedule.due(1_003_000, SensorMask::ALL), Some(1));
        assert_eq!(schedule.due(u64::MAX, SensorMask::ALL), Some(2));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn frames_keep_their_distance_and_their_order(
            waits in proptest::collection::vec(0_u64..100_000, 1..300),
            masks in proptest::collection::vec(any::<u8>(), 1..40),
        ) {
            let mut schedule = RingSchedule::default();
            let mut now_us = 0;
            let mut first_us = None;
            let mut last: Option<(u64, usize)> = None;
            let mut cycles = 0;
            for (turn, wait) in waits.iter().enumerate() {
                now_us += wait;
                let present = SensorMask(masks[turn % masks.len()]);
                let may_be_due = schedule.may_be_due(now_us);
                let Some(sensor) = schedule.due(now_us, present) else {
                    // With all of them there is no other reason than the time.
                    prop_assert!(!may_be_due || present != SensorMask::ALL);
                    continue;
                };
                prop_assert!(may_be_due);
                prop_assert!(present.contains(sensor));
                if let Some((sent_us, before)) = last {
                    prop_assert!(now_us - sent_us >= LEAST_GAP_US);
                    cycles += u64::from(sensor <= before);
                }
                // Sensors that begin again are a new cycle, of which each takes 63 ms.
                let first_us = *first_us.get_or_insert(now_us);
                prop_assert!(cycles * CYCLE_US <= now_us - first_us);
                last = Some((now_us, sensor));
            }
        }
    }
}
