//! What the node emits: configurations taken, steps, particle outcomes.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::{Config, Walls};
use crate::filter::Outcome;
use crate::geometry::{Point, Pose};
use crate::model::{SENSORS, Sample};

/// Particle events in one batch: as many as fill a frame.
pub const BATCH: usize = 38;

/// One event of the node.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// A configuration was taken; all earlier state is cleared.
    Configured(Config),
    /// A step begins: what it consumes.
    StepBegun(StepBegun),
    /// The wall segments that are tracked, between the begin of a step and its particles;
    /// in the profile `wall` only.
    Walls(Walls),
    /// Outcomes of some of the step's particles, in slot order.
    Particles(Particles),
    /// The step is done: its counts and its digest.
    StepDone(StepDone),
    /// The odometry has a new origin: the particles are removed, and poses before and
    /// after this event have no common origin.
    OdometryReset {
        /// Stamp of the first pose with the new origin.
        stamp_us: u64,
    },
}

/// A step begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StepBegun {
    /// Steps since the configuration, from 0.
    pub index: u32,
    /// Stamp of the readings.
    pub stamp_us: u64,
    /// The robot's pose at that stamp; the motion of the step is the way from the
    /// pose of the step before.
    pub pose: Pose,
    /// The readings that are consumed, masked ones as missing.
    pub samples: [Sample; SENSORS],
}

/// Outcomes of up to [`BATCH`] particles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Particles {
    /// The lowest eight bits of the step's index.
    pub step: u8,
    /// The outcomes, in slot order.
    #[serde(with = "packed")]
    pub outcomes: Vec<ParticleEvent, BATCH, u8>,
}

/// The outcomes as one string of bytes, three a particle.
mod packed {
    use core::fmt;

    use heapless::Vec;
    use serde::de::{Error, Visitor};
    use serde::{Deserializer, Serializer};

    use super::{BATCH, ParticleEvent};

    pub(super) fn serialize<S: Serializer>(
        outcomes: &Vec<ParticleEvent, BATCH, u8>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let mut bytes = [[0; 3]; BATCH];
        for (place, event) in bytes.iter_mut().zip(outcomes) {
            *place = event.0;
        }
        let used = bytes.get(..outcomes.len()).unwrap_or_default();
        serializer.serialize_bytes(used.as_flattened())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<ParticleEvent, BATCH, u8>, D::Error> {
        deserializer.deserialize_bytes(Triples)
    }

    struct Triples;

    impl Visitor<'_> for Triples {
        type Value = Vec<ParticleEvent, BATCH, u8>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "at most {BATCH} times three bytes")
        }

        fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
            let (triples, []) = bytes.as_chunks::<3>() else {
                return Err(E::invalid_length(bytes.len(), &self));
            };
            let mut outcomes = Vec::new();
            for triple in triples {
                if outcomes.push(ParticleEvent(*triple)).is_err() {
                    return Err(E::invalid_length(bytes.len(), &self));
                }
            }
            Ok(outcomes)
        }
    }
}

/// The outcome of one particle and its place, in three bytes.
///
/// Little-endian, from the lowest bit: outcome (2 bits), x (11), y (11); places in
/// the body frame of the step's pose, in 0.5 mm, 1024 for zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParticleEvent([u8; 3]);

impl ParticleEvent {
    /// Packs a place in units of 1/64 mm, rounded to 0.5 mm.
    #[must_use]
    #[inline]
    pub fn new((x, y): (i16, i16), outcome: Outcome) -> Self {
        let half_millimetres =
            |units: i16| (((i32::from(units) + 16) >> 5) + 1024).clamp(0, 2047) as u32;
        let outcome = match outcome {
            Outcome::SurvivedPastGate => 0,
            Outcome::SurvivedBelowGate => 1,
            Outcome::RejectedFree => 2,
            Outcome::RejectedUnobserved => 3,
        };
        let bits = outcome | half_millimetres(x) << 2 | half_millimetres(y) << 13;
        let [low, middle, high, _] = bits.to_le_bytes();
        Self([low, middle, high])
    }

    const fn bits(self) -> u32 {
        let [low, middle, high] = self.0;
        u32::from_le_bytes([low, middle, high, 0])
    }

    /// What became of the particle.
    #[must_use]
    pub const fn outcome(self) -> Outcome {
        match self.bits() & 3 {
            0 => Outcome::SurvivedPastGate,
            1 => Outcome::SurvivedBelowGate,
            2 => Outcome::RejectedFree,
            _ => Outcome::RejectedUnobserved,
        }
    }

    /// Where it was, in the body frame, metres; exact to 0.25 mm.
    #[must_use]
    pub fn position(self) -> Point {
        let metres = |bits: u32| ((bits & 2047) as f32 - 1024.0) * 0.0005;
        Point::new(metres(self.bits() >> 2), metres(self.bits() >> 13))
    }
}

/// A step is done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StepDone {
    /// Steps since the configuration, from 0.
    pub index: u32,
    /// Digest of the particle set, redraws included.
    pub digest: u32,
    /// Outcomes "survived past the gate".
    pub past_gate: u16,
    /// Outcomes "survived below the gate".
    pub below_gate: u16,
    /// Outcomes "rejected, free".
    pub free: u16,
    /// Outcomes "rejected, counts nothing".
    pub unobserved: u16,
    /// Particles that left the local radius and have no outcome.
    pub departed: u16,
    /// Whether no particle had any weight: everything was redrawn.
    pub degenerate: bool,
}

impl StepDone {
    /// How many particle events belong to the step.
    #[must_use]
    pub fn outcomes(&self) -> u32 {
        [self.past_gate, self.below_gate, self.free, self.unobserved]
            .into_iter()
            .map(u32::from)
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particle_event_returns_place_and_outcome() {
        for outcome in [
            Outcome::SurvivedPastGate,
            Outcome::SurvivedBelowGate,
            Outcome::RejectedFree,
            Outcome::RejectedUnobserved,
        ] {
            for x in (i16::MIN..=i16::MAX).step_by(97) {
                let y = x.wrapping_mul(31);
                let event = ParticleEvent::new((x, y), outcome);
                assert_eq!(event.outcome(), outcome);
                let exact = Point::new(f32::from(x) / 64_000.0, f32::from(y) / 64_000.0);
                let error = event.position() - exact;
                // Half a step of 0.5 mm; the last step at +512 mm is cut off.
                assert!(error.x.abs() < 0.000_251 || x > 32_735, "x = {x}");
                assert!(error.y.abs() < 0.000_251 || y > 32_735, "y = {y}");
            }
        }
    }

    #[test]
    fn particle_event_has_the_documented_bits() {
        let event = ParticleEvent::new((0, 0), Outcome::RejectedFree);
        // 2 | 1024 << 2 | 1024 << 13
        assert_eq!(event, ParticleEvent([0x02, 0x10, 0x80]));
    }
}
