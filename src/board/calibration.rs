//! Measures the sensors' offsets with nothing in range.
//!
//! An offset is subtracted from every reading, so a wrong one shows a wall that is not
//! there or hides one. It is the mean of 20 readings, and refused if they are unsteady or
//! implausible.

use serde::{Deserialize, Serialize};

use super::offsets::{OFFSET_RANGE, OffsetOrigin, Offsets};
use crate::model::SENSORS;

/// Readings per offset: 160 ms at 125 Hz; noise of 4.6 counts leaves 1.0.
pub const READINGS: u8 = 20;

/// Rounds after which a sensor without its 20 readings is refused.
const ROUNDS: u8 = 40;

/// Largest spread of 20 readings of a steady scene: 8.7 standard deviations of 4.6
/// counts, where 20 normal numbers have 3.7 on average.
const SPREAD: u16 = 40;

/// Largest distance of one sensor above the ring's median. Sensors differ by 180 in all;
/// a white cylinder within 9 cm of one adds 100.
const ABOVE_RING: u16 = 100;

/// Largest distance above the stored offset: a cylinder within 13 cm.
const ABOVE_STORED: u16 = 40;

/// Why a sensor's offset is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OffsetRefusal {
    /// It did not deliver 20 trusted readings in 40 rounds.
    NotDelivering,
    /// Its readings lie up to this far apart, counts: something moves.
    Unsteady(u16),
    /// The mean is outside [`OFFSET_RANGE`].
    OutOfRange(u16),
    /// The mean lies this far above the ring's median: something is near this sensor.
    AboveRing(u16),
    /// The mean lies this far above the stored offset: something is near.
    AboveStored(u16),
}

impl core::fmt::Display for OffsetRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotDelivering => {
                write!(
                    f,
                    "fewer than {READINGS} trusted readings in {ROUNDS} rounds"
                )
            }
            Self::Unsteady(spread) => {
                write!(f, "readings lie {spread} counts apart: something moves")
            }
            Self::OutOfRange(mean) => write!(f, "{mean} counts are no offset"),
            Self::AboveRing(counts) => write!(
                f,
                "{counts} counts above the ring's median: something is near this sensor"
            ),
            Self::AboveStored(counts) => {
                write!(
                    f,
                    "{counts} counts above the offset before: something is near"
                )
            }
        }
    }
}

impl core::error::Error for OffsetRefusal {}

/// Sum and range of one sensor's readings.
#[derive(Clone, Copy, Debug)]
struct ReadingStatistics {
    readings: u8,
    sum: u32,
    lowest: u16,
    highest: u16,
}

impl ReadingStatistics {
    const NONE: Self = Self {
        readings: 0,
        sum: 0,
        lowest: u16::MAX,
        highest: 0,
    };

    fn take(&mut self, raw: u16) {
        if self.readings < READINGS {
            self.readings += 1;
            self.sum = self.sum.saturating_add(u32::from(raw));
            self.lowest = self.lowest.min(raw);
            self.highest = self.highest.max(raw);
        }
    }

    /// Rounded to the nearest; of nothing, 0.
    fn mean(&self) -> u16 {
        let count = u32::from(self.readings).max(1);
        // A mean of numbers of 16 bits has 16.
        ((self.sum + count / 2) / count) as u16
    }

    /// The mean of enough readings that lie close together.
    fn steady_mean(&self) -> Result<u16, OffsetRefusal> {
        if self.readings < READINGS {
            return Err(OffsetRefusal::NotDelivering);
        }
        let spread = self.highest.saturating_sub(self.lowest);
        if spread > SPREAD {
            return Err(OffsetRefusal::Unsteady(spread));
        }
        let mean = self.mean();
        if !OFFSET_RANGE.contains(&mean) {
            return Err(OffsetRefusal::OutOfRange(mean));
        }
        Ok(mean)
    }
}

/// A measurement of all offsets, one round of readings at a time.
#[derive(Clone, Copy, Debug)]
pub struct OffsetMeasurement {
    tallies: [ReadingStatistics; SENSORS],
    rounds: u8,
    stored: Option<[u16; SENSORS]>,
}

impl OffsetMeasurement {
    /// Begins a measurement. Known offsets guard against a robot in a corner, where
    /// something is in range of the whole ring.
    #[must_use]
    pub const fn new(known: &Offsets) -> Self {
        Self {
            tallies: [ReadingStatistics::NONE; SENSORS],
            rounds: 0,
            stored: match known.origin {
                OffsetOrigin::Defaults => None,
                OffsetOrigin::Stored | OffsetOrigin::Measured => Some(known.counts),
            },
        }
    }

    /// Takes the raw values of a round's trusted sensors; whether the measurement is done,
    /// after 20 values of each and 40 rounds at the latest.
    ///
    /// To be called once per round, or a reading counts twice.
    pub fn take(&mut self, raw: &[Option<u16>; SENSORS]) -> bool {
        self.rounds = self.rounds.saturating_add(1);
        for (tally, raw) in self.tallies.iter_mut().zip(raw) {
            if let Some(raw) = raw {
                tally.take(*raw);
            }
        }
        self.is_done()
    }

    fn is_done(&self) -> bool {
        self.rounds >= ROUNDS || self.tallies.iter().all(|tally| tally.readings >= READINGS)
    }

    /// Each sensor's offset, or why it is refused. Before the measurement is done the
    /// sensors do not deliver.
    pub fn results(&self) -> [Result<u16, OffsetRefusal>; SENSORS] {
        let mut results = [Err(OffsetRefusal::NotDelivering); SENSORS];
        for (result, tally) in results.iter_mut().zip(&self.tallies) {
            *result = tally.steady_mean();
        }
        let median = median(&results);
        for (index, result) in results.iter_mut().enumerate() {
            let Ok(mean) = *result else { continue };
            let above_ring = mean.saturating_sub(median);
            let known = self.stored.and_then(|stored| stored.get(index).copied());
            let above_stored = known.map_or(0, |known| mean.saturating_sub(known));
            if above_ring > ABOVE_RING {
                *result = Err(OffsetRefusal::AboveRing(above_ring));
            } else if above_stored > ABOVE_STORED {
                *result = Err(OffsetRefusal::AboveStored(above_stored));
            }
        }
        results
    }

    /// The offsets of the whole ring; `None` if a single sensor's is refused.
    #[must_use]
    pub fn offsets(&self) -> Option<Offsets> {
        let mut counts = [0; SENSORS];
        for (place, result) in counts.iter_mut().zip(self.results()) {
            *place = result.ok()?;
        }
        Some(Offsets {
            counts,
            origin: OffsetOrigin::Measured,
        })
    }
}

/// The lower median of the means; of none, the highest number.
fn median(results: &[Result<u16, OffsetRefusal>; SENSORS]) -> u16 {
    let means = || results.iter().flatten();
    let half = means().count().div_ceil(2);
    means()
        .filter(|middle| means().filter(|mean| mean <= middle).count() >= half)
        .min()
        .copied()
        .unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot's offsets on a table, as published.
    const TABLE: [u16; SENSORS] = [2469, 2412, 2381, 2491, 2488, 2449, 2413, 2320];

    const STORED: Offsets = Offsets {
        counts: TABLE,
        origin: OffsetOrigin::Stored,
    };

    /// Twenty rounds of these means, each with noise of -2 to 2 about it.
    fn measured(known: &Offsets, means: [u16; SENSORS]) -> OffsetMeasurement {
        let mut measurement = OffsetMeasurement::new(known);
        for round in 0..READINGS {
            let raw = means.map(|mean| Some(mean + u16::from(round % 5) - 2));
            assert_eq!(measurement.take(&raw), round == READINGS - 1);
        }
        measurement
    }

    fn with(sensor: usize, counts: u16) -> [u16; SENSORS] {
        let mut means = TABLE;
        means[sensor] = counts;
        means
    }

    #[test]
    fn twenty_readings_make_their_mean() {
        for known in [Offsets::DEFAULTS, STORED] {
            let offsets = measured(&known, TABLE).offsets().unwrap();
            assert_eq!(offsets.counts, TABLE);
            assert_eq!(offsets.origin, OffsetOrigin::Measured);
        }
    }

    #[test]
    fn the_mean_is_rounded_to_the_nearest() {
        let mut tally = ReadingStatistics::NONE;
        assert_eq!(tally.mean(), 0);
        tally.take(2_000);
        tally.take(2_001);
        tally.take(2_001);
        assert_eq!(tally.mean(), 2_001);
        let mut full = ReadingStatistics::NONE;
        (0..30).for_each(|_| full.take(u16::MAX));
        assert_eq!((full.mean(), full.readings), (u16::MAX, READINGS));
    }

    #[test]
    fn a_sensor_that_does_not_deliver_is_refused_after_forty_rounds() {
        let mut measurement = OffsetMeasurement::new(&STORED);
        for round in 1..=40 {
            let mut raw = TABLE.map(Some);
            // Every other reading arrives, but for the first.
            raw[6] = raw[6].filter(|_| round % 2 == 0 && round > 2);
            assert_eq!(measurement.take(&raw), round == 40);
        }
        let results = measurement.results();
        assert_eq!(results[6], Err(OffsetRefusal::NotDelivering));
        assert_eq!(results[5], Ok(TABLE[5]));
        assert_eq!(measurement.offsets(), None);
    }

    #[test]
    fn a_spread_above_forty_is_refused() {
        for (spread, expected) in [
            (40, Ok(TABLE[0] + 20)),
            (41, Err(OffsetRefusal::Unsteady(41))),
        ] {
            let mut measurement = OffsetMeasurement::new(&STORED);
            for round in 0..READINGS {
                let mut raw = TABLE.map(Some);
                raw[0] = Some(TABLE[0] + if round % 2 == 0 { spread } else { 0 });
                measurement.take(&raw);
            }
            assert_eq!(measurement.results()[0], expected);
        }
    }

    #[test]
    fn a_mean_that_is_no_offset_is_refused() {
        for (mean, refused) in [(1_499, true), (1_500, false), (3_501, true)] {
            let results = measured(&Offsets::DEFAULTS, with(3, mean)).results();
            let expected = Err(OffsetRefusal::OutOfRange(mean));
            assert_eq!(results[3] == expected, refused, "{mean}");
            assert_eq!(results[2], Ok(TABLE[2]));
        }
    }

    #[test]
    fn something_near_one_sensor_is_refused_against_the_ring() {
        // The lower median of the eight with a high one in place of 2381: 2449.
        let at = |counts| measured(&Offsets::DEFAULTS, with(2, counts));
        assert_eq!(at(2_549).results()[2], Ok(2_549));
        let refused = Err(OffsetRefusal::AboveRing(101));
        assert_eq!(at(2_550).results()[2], refused);
        assert_eq!(at(2_550).offsets(), None);
        assert_eq!(at(2_550).results()[1], Ok(TABLE[1]));
    }

    #[test]
    fn something_around_the_whole_ring_is_refused_against_the_stored_offsets() {
        let near = TABLE.map(|offset| offset + 41);
        let refused = [Err(OffsetRefusal::AboveStored(41)); SENSORS];
        assert_eq!(measured(&STORED, near).results(), refused);
        // Without stored offsets it looks like a robot of high offsets.
        assert!(measured(&Offsets::DEFAULTS, near).offsets().is_some());
        let within = TABLE.map(|offset| offset + 40);
        assert!(measured(&STORED, within).offsets().is_some());
    }

    #[test]
    fn the_median_leaves_refused_sensors_out() {
        let refused = Err(OffsetRefusal::NotDelivering);
        let mut results = [refused; SENSORS];
        assert_eq!(median(&results), u16::MAX);
        results[4] = Ok(9);
        assert_eq!(median(&results), 9);
        results[0] = Ok(5);
        assert_eq!(median(&results), 5, "the lower one");
        results[7] = Ok(7);
        assert_eq!(median(&results), 7);
        assert_eq!(median(&[Ok(3); SENSORS]), 3);
    }
}
