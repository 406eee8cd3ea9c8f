//! What a step consumes of the samples that came since the step before.
//!
//! The sensors deliver at 125 Hz and the filter steps at about 8 Hz: fifteen samples per
//! step. The paper's section 5 mentions supersampling without the use of the samples;
//! averaging them costs as much in lag as it gains in noise.

use crate::model::{SENSORS, Sample};
use crate::node::SampleSelection;

/// Samples older than this when a step consumes them are as if missing: two periods of
/// 125 Hz.
pub const MAX_SAMPLE_AGE_US: u64 = 16_000;

/// Samples that a median is taken of: those of one step at 8 Hz.
pub const WINDOW: usize = 15;

/// The recent samples of the whole ring.
#[derive(Clone, Copy, Debug)]
pub struct SampleWindow {
    sensors: [Recent; SENSORS],
    newest_us: u64,
}

/// The recent samples of one sensor.
#[derive(Clone, Copy, Debug)]
struct Recent {
    /// The newest that was not missing, and when.
    newest: Option<(u64, Sample)>,
    /// The last counts since a step, in a circle.
    counts: [i32; WINDOW],
    /// How many came since a step.
    taken: u32,
}

impl Recent {
    const NONE: Self = Self {
        newest: None,
        counts: [0; WINDOW],
        taken: 0,
    };

    fn take(&mut self, stamp_us: u64, sample: Sample) {
        if sample == Sample::Missing {
            return;
        }
        self.newest = Some((stamp_us, sample));
        if let Sample::Counts(counts) = sample {
            if let Some(place) = self.counts.get_mut(self.taken as usize % WINDOW) {
                *place = counts;
            }
            self.taken = self.taken.wrapping_add(1);
        }
    }

    fn at(&self, now_us: u64, choice: SampleSelection) -> Sample {
        match self.newest {
            Some((stamp_us, sample)) if now_us.saturating_sub(stamp_us) <= MAX_SAMPLE_AGE_US => {
                match (choice, sample) {
                    (SampleSelection::Median, Sample::Counts(newest)) => {
                        Sample::Counts(self.median().unwrap_or(newest))
                    }
                    _ => sample,
                }
            }
            _ => Sample::Missing,
        }
    }

    /// The middle one of the counts since a step; of an even number the lower one.
    fn median(&self) -> Option<i32> {
        let mut sorted = self.counts;
        let filled = WINDOW.min(self.taken as usize);
        let sorted = sorted.get_mut(..filled)?;
        sorted.sort_unstable();
        sorted.get(filled.checked_sub(1)? / 2).copied()
    }
}

impl Default for SampleWindow {
    fn default() -> Self {
        Self {
            sensors: [Recent::NONE; SENSORS],
            newest_us: 0,
        }
    }
}

impl SampleWindow {
    /// Takes one sample of each sensor. Missing ones leave those before in place.
    pub fn take(&mut self, stamp_us: u64, samples: &[Sample; SENSORS]) {
        self.newest_us = stamp_us;
        for (recent, sample) in self.sensors.iter_mut().zip(samples) {
            recent.take(stamp_us, *sample);
        }
    }

    /// What a step at the newest stamp consumes, by sensor index.
    ///
    /// A sensor whose last sample is more than [`MAX_SAMPLE_AGE_US`] older than the
    /// newest stamp is missing; if its last sample is saturated, so is the result.
    #[must_use]
    pub fn select(&self, choice: SampleSelection) -> [Sample; SENSORS] {
        self.sensors.map(|recent| recent.at(self.newest_us, choice))
    }

    /// Begins the next step's window.
    pub fn begin_window(&mut self) {
        for recent in &mut self.sensors {
            recent.taken = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(counts: i32) -> [Sample; SENSORS] {
        [Sample::Counts(counts); SENSORS]
    }

    #[test]
    fn the_newest_sample_is_chosen_until_it_is_two_periods_old() {
        let mut window = SampleWindow::default();
        assert_eq!(
            window.select(SampleSelection::Newest),
            [Sample::Missing; SENSORS]
        );
        window.take(0, &counts(7));
        window.take(8_000, &counts(9));
        for (stamp_us, expected) in [
            (16_000, Sample::Counts(9)),
            (24_000, Sample::Counts(9)),
            (24_001, Sample::Missing),
        ] {
            window.take(stamp_us, &[Sample::Missing; SENSORS]);
            assert_eq!(window.select(SampleSelection::Newest), [expected; SENSORS]);
            assert_eq!(
                window.select(SampleSelection::Median)[3] == Sample::Missing,
                expected == Sample::Missing
            );
        }
    }

    #[test]
    fn f11_spikes_do_not_move_the_median() {
        // One to three spikes of any size, at any place among the fifteen.
        for spikes in 1..=3 {
            for place in 0..WINDOW - spikes {
                let mut window = SampleWindow::default();
                for sample in 0..WINDOW {
                    let is_spike = (place..place + spikes).contains(&sample);
                    // A wall that the robot passes, one count a sample.
                    let value = if is_spike {
                        60_000
                    } else {
                        100 + sample as i32
                    };
                    window.take(sample as u64 * 8_000, &counts(value));
                }
                let [Sample::Counts(median), ..] = window.select(SampleSelection::Median) else {
                    panic!("no counts");
                };
                // 107 without spikes; each takes a value from one side of the middle, so
                // that it moves by a place, here a count. Two sigma are 9 counts.
                let moved = median.abs_diff(107) as usize;
                assert!(moved <= spikes, "{spikes} at {place}: {median}");
            }
        }
    }

    #[test]
    fn a_step_begins_a_new_window_and_the_newest_stays() {
        let mut window = SampleWindow::default();
        for sample in 0..20 {
            window.take(sample * 8_000, &counts(50));
        }
        window.begin_window();
        assert_eq!(window.select(SampleSelection::Median), counts(50));
        window.take(160_000, &counts(80));
        assert_eq!(window.select(SampleSelection::Median), counts(80));
        window.take(168_000, &counts(90));
        assert_eq!(
            window.select(SampleSelection::Median),
            counts(80),
            "the lower of two"
        );
    }

    #[test]
    fn a_saturated_sensor_is_saturated_whatever_its_median() {
        let mut window = SampleWindow::default();
        window.take(0, &counts(50));
        window.take(8_000, &[Sample::Saturated; SENSORS]);
        assert_eq!(
            window.select(SampleSelection::Median),
            [Sample::Saturated; SENSORS]
        );
    }
}
