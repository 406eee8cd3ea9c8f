//! The tracked wall segments after a step, as they are sent.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::filter::{MAX_SEGMENTS, SegmentTracker, TrackedSegment};
use crate::geometry::{Point, Pose};
use crate::math;

/// Units of 0.5 mm from one block to the next: 16.384 m.
const BLOCK: i32 = 1 << 15;

/// Most segments that a message names: those of the step before, and a new one.
const MOST_NAMED: usize = MAX_SEGMENTS + 1;

/// The wall segments that are tracked after a step, in the frame of the odometry.
///
/// Each message is complete in itself. A segment that is out of reach does not move, so
/// only its number is sent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Walls {
    /// Steps since the configuration, from 0.
    pub index: u32,
    /// Where the ends are counted from, x and y, in blocks of 16.384 m: the block that is
    /// nearest to the robot.
    pub block: [i16; 2],
    /// The segments within reach.
    #[serde(with = "packed")]
    pub seen: Vec<TrackedWall, MAX_SEGMENTS, u8>,
    /// Numbers of the segments that are out of reach, and kept for the robot's return.
    pub out_of_reach: Vec<u16, MAX_SEGMENTS, u8>,
    /// Numbers of the segments that were left behind in this step: they stay where they
    /// were, and are no longer tracked.
    pub left: Vec<u16, MAX_SEGMENTS, u8>,
}

/// A segment within reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TrackedWall {
    /// A number that no other segment has while this one is tracked.
    pub id: u16,
    /// x and y of both ends, in 0.5 mm from the block.
    pub ends: [[i16; 2]; 2],
    /// Standard deviation of each end along the segment, in 0.5 mm; 255 for more, and
    /// for none.
    pub along: [u8; 2],
    /// Standard deviation of each end across the segment, likewise.
    pub across: [u8; 2],
    /// Cost that the segment has saved (chi^2), rounded down; 255 for more.
    pub evidence: u8,
}

impl Walls {
    /// A message without segments.
    pub(super) fn new(index: u32) -> Self {
        Self {
            index,
            ..Self::default()
        }
    }

    /// Adds a segment that was left behind.
    pub(super) fn leave(&mut self, segment: &TrackedSegment) {
        let _ = self.left.push(segment.id());
    }

    /// Adds the segments of a tracker for a robot at a pose.
    ///
    /// An end more than 8 m away from the robot has no place in the message, and such a
    /// segment is left out; the sensors reach 0.3 m.
    pub(super) fn track(&mut self, tracker: &SegmentTracker, pose: &Pose) {
        let robot = half_millimetres(pose.position);
        self.block = robot.map(nearest_block);
        for segment in tracker.segments() {
            if self.is_listed(segment.id()) {
                continue;
            }
            if segment.is_frozen() {
                let _ = self.out_of_reach.push(segment.id());
                continue;
            }
            let ends = segment.ends().map(|end| {
                let end = half_millimetres(pose.world_from_body(tracker.body_from_track(end)));
                offset(end, self.block)
            });
            if let [Some(from), Some(to)] = ends
                && from != to
            {
                let _ = self.seen.push(TrackedWall::new(segment, [from, to]));
            }
        }
        while self.named() > MOST_NAMED && self.left.pop().is_some() {}
    }

    /// The ends of a segment in the frame of the odometry: x and y, in 0.5 mm.
    #[must_use]
    pub fn ends_half_mm(&self, wall: &TrackedWall) -> [[i32; 2]; 2] {
        let [block_x, block_y] = self.block.map(|block| BLOCK * i32::from(block));
        wall.ends
            .map(|[x, y]| [block_x + i32::from(x), block_y + i32::from(y)])
    }

    /// Checks what the types do not.
    ///
    /// # Errors
    /// Why no tracker can have sent this.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        if self.seen.len() + self.out_of_reach.len() > MAX_SEGMENTS || self.named() > MOST_NAMED {
            return Err("more walls than a board tracks");
        }
        if self.seen.iter().any(|wall| {
            let [from, to] = wall.ends;
            from == to
        }) {
            return Err("a wall without length");
        }
        let is_twice = |(index, id)| self.ids().skip(index + 1).any(|other| other == id);
        if self.ids().enumerate().any(is_twice) {
            return Err("two walls of one number");
        }
        Ok(())
    }

    fn named(&self) -> usize {
        self.seen.len() + self.out_of_reach.len() + self.left.len()
    }

    /// The numbers of the tracked segments.
    fn ids(&self) -> impl Iterator<Item = u16> {
        let seen = self.seen.iter().map(|wall| wall.id);
        seen.chain(self.out_of_reach.iter().copied())
    }

    fn is_listed(&self, id: u16) -> bool {
        self.ids().any(|other| other == id)
    }
}

impl TrackedWall {
    fn new(segment: &TrackedSegment, ends: [[i16; 2]; 2]) -> Self {
        let sigmas = segment.end_sigmas();
        Self {
            id: segment.id(),
            ends,
            along: sigmas.map(|end| sigma_byte(end.along_m)),
            across: sigmas.map(|end| sigma_byte(end.across_m)),
            // The cast saturates, and stops below the next whole number.
            evidence: segment.evidence() as u8,
        }
    }
}

/// x and y in 0.5 mm; beyond 1000 km the highest number.
fn half_millimetres(place: Point) -> [i32; 2] {
    [place.x, place.y].map(|metres| math::round_to_i32(metres * 2000.0))
}

fn nearest_block(units: i32) -> i16 {
    let block = units.saturating_add(BLOCK / 2).div_euclid(BLOCK);
    i16::try_from(block).unwrap_or(if block < 0 { i16::MIN } else { i16::MAX })
}

/// A place as seen from a block; `None` if it is too far from it.
fn offset(place: [i32; 2], block: [i16; 2]) -> Option<[i16; 2]> {
    let [x, y] = place;
    let [block_x, block_y] = block.map(|block| BLOCK * i32::from(block));
    let from = |units: i32, block: i32| i16::try_from(units.checked_sub(block)?).ok();
    Some([from(x, block_x)?, from(y, block_y)?])
}

/// A standard deviation in 0.5 mm, at least 1; 255 for more, and for what is no number.
fn sigma_byte(metres: f32) -> u8 {
    let units = metres * 2000.0;
    if units < 254.5 {
        math::round_to_u32(units).clamp(1, 255) as u8
    } else {
        u8::MAX
    }
}

/// The segments within reach as one string of bytes, fifteen for each.
mod packed {
    use core::fmt;

    use heapless::Vec;
    use serde::de::{Error, Visitor};
    use serde::{Deserializer, Serializer};

    use super::TrackedWall;
    use crate::filter::MAX_SEGMENTS;

    /// Bytes of a segment.
    const BYTES: usize = 15;

    pub(super) fn serialize<S: Serializer>(
        seen: &Vec<TrackedWall, MAX_SEGMENTS, u8>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let mut bytes = [[0; BYTES]; MAX_SEGMENTS];
        for (place, wall) in bytes.iter_mut().zip(seen) {
            *place = to_bytes(wall);
        }
        let used = bytes.get(..seen.len()).unwrap_or_default();
        serializer.serialize_bytes(used.as_flattened())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<TrackedWall, MAX_SEGMENTS, u8>, D::Error> {
        deserializer.deserialize_bytes(Fifteens)
    }

    struct Fifteens;

    impl Visitor<'_> for Fifteens {
        type Value = Vec<TrackedWall, MAX_SEGMENTS, u8>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "at most {MAX_SEGMENTS} times {BYTES} bytes")
        }

        fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
            let (walls, []) = bytes.as_chunks::<BYTES>() else {
                return Err(E::invalid_length(bytes.len(), &self));
            };
            let mut seen = Vec::new();
            for wall in walls {
                if seen.push(from_bytes(wall)).is_err() {
                    return Err(E::invalid_length(bytes.len(), &self));
                }
            }
            Ok(seen)
        }
    }

    fn to_bytes(wall: &TrackedWall) -> [u8; BYTES] {
        let [id_low, id_high] = wall.id.to_le_bytes();
        let [from, to] = wall.ends;
        let [x0, y0] = from.map(i16::to_le_bytes);
        let [x1, y1] = to.map(i16::to_le_bytes);
        let [along_0, along_1] = wall.along;
        let [across_0, across_1] = wall.across;
        [
            id_low,
            id_high,
            x0[0],
            x0[1],
            y0[0],
            y0[1],
            x1[0],
            x1[1],
            y1[0],
            y1[1],
            along_0,
            along_1,
            across_0,
            across_1,
            wall.evidence,
        ]
    }

    fn from_bytes(bytes: &[u8; BYTES]) -> TrackedWall {
        let [id, x0, y0, x1, y1] = {
            let [a, b, c, d, e, f, g, h, i, j, ..] = *bytes;
            [[a, b], [c, d], [e, f], [g, h], [i, j]]
        };
        let [.., along_0, along_1, across_0, across_1, evidence] = *bytes;
        TrackedWall {
            id: u16::from_le_bytes(id),
            ends: [[x0, y0], [x1, y1]].map(|end| end.map(i16::from_le_bytes)),
            along: [along_0, along_1],
            across: [across_0, across_1],
            evidence,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_its_block_and_an_offset_from_it() {
        for metres in [0.0, 0.3, -0.3, 8.19, 8.2, -8.2, 100.0, -524.0, 5000.0] {
            let robot = half_millimetres(Point::new(metres, -metres));
            let walls = Walls {
                block: robot.map(nearest_block),
                ..Walls::default()
            };
            for side in [-8.0, 0.0, 8.0] {
                let end = half_millimetres(Point::new(metres + side, -metres + 0.1));
                let wall = TrackedWall {
                    ends: [offset(end, walls.block).unwrap(), [0; 2]],
                    ..TrackedWall::default()
                };
                assert_eq!(walls.ends_half_mm(&wall)[0], end, "{metres} m");
            }
        }
    }

    #[test]
    fn what_is_too_far_away_has_no_offset_and_nothing_overflows() {
        for metres in [f32::MAX, f32::MIN, f32::INFINITY, f32::NAN, 1e6] {
            let robot = half_millimetres(Point::new(metres, 0.0));
            let block = robot.map(nearest_block);
            let _ = offset(robot, block);
            assert_eq!(offset([i32::MIN, 0], [i16::MAX, 0]), None);
        }
        assert_eq!(offset([40_000, 0], [0, 0]), None);
    }

    #[test]
    fn deviations_saturate_and_are_never_zero() {
        let cases = [
            (0.0, 1),
            (0.0001, 1),
            (0.0032, 6),
            (0.127, 254),
            (0.1273, 255),
            (1.0, 255),
            (f32::INFINITY, 255),
            (f32::NAN, 255),
        ];
        for (metres, byte) in cases {
            assert_eq!(sigma_byte(metres), byte, "{metres} m");
        }
    }
}
