//! The sensors' offsets: measured with nothing near, kept in the memory.
//!
//! A sensor that sees nothing reads 2200 to 2500 counts, each its own number, of light
//! that its own hull throws back. The offset is subtracted from every reading, so a
//! wrong one is a wall that is always there, or one that never is. It is measured as
//! the mean of 20 readings and refused on the slightest doubt.

use core::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::proximity_sensor::DEFAULT_OFFSET;
use crate::sensor::SENSORS;

/// Readings that make an offset: 160 ms at 125 Hz; noise of 4.6 counts leaves 1.0.
pub const READINGS: u8 = 20;

/// Rounds after which a sensor without its 20 readings is given up.
const ROUNDS: u8 = 40;

/// What an offset can be, counts. Two robots have 2150 to 2510.
pub const OFFSET_RANGE: RangeInclusive<u16> = 1_500..=3_500;

/// Most that 20 readings of a steady scene lie apart: 8.7 standard deviations of 4.6
/// counts, where 20 normal numbers have 3.7 on average.
const SPREAD: u16 = 40;

/// Most that one sensor lies above the ring's median. Sensors differ by 180 in all; a
/// white cylinder within 9 cm of one adds 100.
const ABOVE_RING: u16 = 100;

/// Most that a sensor lies above its stored offset: a cylinder within 13 cm.
const ABOVE_STORED: u16 = 40;

/// Bytes of the memory that hold the offsets and what goes before them.
pub const STORE_BYTES: usize = OFFSETS_AT + 2 * SENSORS;

/// Where the offsets begin.
const OFFSETS_AT: usize = 0x14;

/// AMiRo-OS's mark: magic, then major and minor versions of boot loader and hardware.
const MARK: [u8; 5] = [0xaa, 1, 2, 1, 1];

/// Where the offsets in use come from. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OffsetOrigin {
    /// Nowhere: 2450 each. Ranges are wrong by some, and walls may stay unseen.
    #[default]
    Defaults,
    /// The memory.
    Stored,
    /// A measurement since the start.
    Measured,
}

/// Offsets of the ring and where they come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Offsets {
    /// Raw counts with nothing in range, by sensor index.
    pub counts: [u16; SENSORS],
    /// Where they come from.
    pub origin: OffsetOrigin,
}

/// Why the memory's offsets are not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreFault {
    /// The mark is not AMiRo-OS's: the memory is blank or somebody else's.
    NoMark,
    /// This sensor's offset is none.
    Implausible {
        /// The first such sensor.
        sensor: u8,
    },
}

impl Offsets {
    /// What is used when nothing better is known.
    pub const DEFAULTS: Self = Self {
        counts: [DEFAULT_OFFSET; SENSORS],
        origin: OffsetOrigin::Defaults,
    };

    /// The offsets in the first bytes of the memory, in AMiRo-OS's layout: five bytes of
    /// mark, offsets from 0x14 on, two bytes each, low byte first.
    ///
    /// # Errors
    /// [`StoreFault::NoMark`]; [`StoreFault::Implausible`] outside [`OFFSET_RANGE`].
    pub fn decode(bytes: &[u8; STORE_BYTES]) -> Result<Self, StoreFault> {
        if !bytes.starts_with(&MARK) {
            return Err(StoreFault::NoMark);
        }
        let mut counts = [0; SENSORS];
        let (pairs, _) = bytes
            .last_chunk::<{ 2 * SENSORS }>()
            .map_or((&[] as &[[u8; 2]], &[] as &[u8]), |end| end.as_chunks());
        for (sensor, (place, pair)) in counts.iter_mut().zip(pairs).enumerate() {
            *place = u16::from_le_bytes(*pair);
            if !OFFSET_RANGE.contains(place) {
                return Err(StoreFault::Implausible {
                    sensor: sensor as u8,
                });
            }
        }
        Ok(Self {
            counts,
            origin: OffsetOrigin::Stored,
        })
    }

    /// Puts the mark and the offsets where [`Offsets::decode`] finds them; the bytes
    /// between stay as they are.
    pub fn encode(&self, bytes: &mut [u8; STORE_BYTES]) {
        for (place, byte) in bytes.iter_mut().zip(MARK) {
            *place = byte;
        }
        let encoded = self.counts.iter().flat_map(|count| count.to_le_bytes());
        for (place, byte) in bytes.iter_mut().skip(OFFSETS_AT).zip(encoded) {
            *place = byte;
        }
    }
}

impl Default for Offsets {
    fn default() -> Self {
        Self::DEFAULTS
    }
}

/// Why a sensor's offset is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OffsetRefusal {
    /// It did not deliver 20 trusted readings in 40 rounds.
    NotDelivering,
    /// Its readings lie up to this far apart, counts: something moves.
    Unsteady(u16),
    /// Their mean is no offset.
    OutOfRange(u16),
    /// The mean lies this far above the ring's median: something is near this sensor.
    AboveRing(u16),
    /// The mean lies this far above the stored offset: something is near.
    AboveStored(u16),
}

/// What the readings of one sensor come to.
#[derive(Clone, Copy, Debug)]
struct Tally {
    readings: u8,
    sum: u32,
    lowest: u16,
    highest: u16,
}

impl Tally {
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

/// A measurement of all offsets, a round of readings at a time.
#[derive(Clone, Copy, Debug)]
pub struct OffsetMeasurement {
    tallies: [Tally; SENSORS],
    rounds: u8,
    stored: Option<[u16; SENSORS]>,
}

impl OffsetMeasurement {
    /// Begins a measurement; offsets that came from the memory guard against a
    /// robot in a corner, where the whole ring sees something.
    #[must_use]
    pub const fn new(known: &Offsets) -> Self {
        Self {
            tallies: [Tally::NONE; SENSORS],
            rounds: 0,
            stored: match known.origin {
                OffsetOrigin::Defaults => None,
                OffsetOrigin::Stored | OffsetOrigin::Measured => Some(known.counts),
            },
        }
    }

    /// Takes a round's raw values, of the sensors that are trusted; answers whether
    /// the measurement is done, after 20 values of each and 40 rounds at the latest.
    ///
    /// One call a round, or a reading counts twice.
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
        let mut tally = Tally::NONE;
        assert_eq!(tally.mean(), 0);
        tally.take(2_000);
        tally.take(2_001);
        tally.take(2_001);
        assert_eq!(tally.mean(), 2_001);
        let mut full = Tally::NONE;
        (0..30).for_each(|_| full.take(u16::MAX));
        assert_eq!((full.mean(), full.readings), (u16::MAX, READINGS));
    }

    #[test]
    fn a_silent_sensor_is_waited_for_forty_rounds_and_refused() {
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
        // Without stored offsets nothing tells it from a robot of high offsets.
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

    #[test]
    fn the_stored_bytes_are_amiro_os_ones() {
        let mut bytes = [0x5a; STORE_BYTES];
        STORED.encode(&mut bytes);
        assert_eq!(bytes[..5], [0xaa, 1, 2, 1, 1]);
        assert_eq!(bytes[5..0x14], [0x5a; 15], "not ours");
        // 2469 = 0x09a5 and 2320 = 0x0910.
        assert_eq!(bytes[0x14..0x16], [0xa5, 0x09]);
        assert_eq!(bytes[0x22..0x24], [0x10, 0x09]);
        assert_eq!(Offsets::decode(&bytes), Ok(STORED));
    }

    #[test]
    fn a_blank_or_foreign_memory_is_not_believed() {
        let mut bytes = [0xff; STORE_BYTES];
        assert_eq!(Offsets::decode(&bytes), Err(StoreFault::NoMark));
        STORED.encode(&mut bytes);
        for index in 0..5 {
            let mut other = bytes;
            other[index] ^= 1;
            assert_eq!(Offsets::decode(&other), Err(StoreFault::NoMark));
        }
        for (offset, is_sound) in [(1_499, false), (1_500, true), (3_500, true), (3_501, false)] {
            let mut bytes = bytes;
            bytes[0x14 + 10..][..2].copy_from_slice(&u16::to_le_bytes(offset));
            let fault = Offsets::decode(&bytes).err();
            let expected = (!is_sound).then_some(StoreFault::Implausible { sensor: 5 });
            assert_eq!(fault, expected, "{offset}");
        }
        assert_eq!(Offsets::default().origin, OffsetOrigin::Defaults);
    }
}
