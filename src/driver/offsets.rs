//! The sensors' offsets and their place in the memory.
//!
//! A sensor that sees nothing reads 2200 to 2500 counts, each its own number, of light
//! that its own hull throws back.

use core::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::proximity_sensor::DEFAULT_OFFSET;
use crate::model::SENSORS;

/// What an offset can be, counts. Two robots have 2150 to 2510.
pub const OFFSET_RANGE: RangeInclusive<u16> = 1_500..=3_500;

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

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot's offsets on a table, as published.
    const TABLE: [u16; SENSORS] = [2469, 2412, 2381, 2491, 2488, 2449, 2413, 2320];

    const STORED: Offsets = Offsets {
        counts: TABLE,
        origin: OffsetOrigin::Stored,
    };

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
