//! The bytes of a message: a group, a number in the group, the payload.
//!
//! The two tables below are the only place that assigns numbers; `docs/protocol.md`
//! lists the same. The order of the variants of [`Message`], [`Input`] and [`Event`]
//! has no effect on the bytes. Numbers are appended, never changed. Group and number
//! are varints of postcard, one byte each.

use core::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Message, MessageRef};
use crate::node::{Config, Event, Input, Walls};

/// Group of the messages that a host sends; a board repeats its own inputs in it.
const TO_BOARD: u8 = 0;
/// Group of the messages that a board sends.
const FROM_BOARD: u8 = 1;
/// Group of the messages of a simulator.
const TRUTH: u8 = 2;

impl Serialize for MessageRef<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::Hello => (TO_BOARD, 0_u8).serialize(serializer),
            Self::Calibrate => (TO_BOARD, 6_u8).serialize(serializer),
            Self::Input(input) => serialize_input(input, serializer),
            Self::Event(event) => serialize_event(event, serializer),
            Self::Boot(boot) => (FROM_BOARD, 0_u8, boot).serialize(serializer),
            Self::Answer { input, refused } => {
                (FROM_BOARD, 5_u8, input, refused).serialize(serializer)
            }
            Self::Status(status) => (FROM_BOARD, 6_u8, status).serialize(serializer),
            Self::Health(health) => (FROM_BOARD, 8_u8, health).serialize(serializer),
            Self::Offsets(offsets) => (FROM_BOARD, 9_u8, offsets).serialize(serializer),
            Self::PostMortem(record) => (FROM_BOARD, 10_u8, record).serialize(serializer),
            Self::Supervision(state) => (FROM_BOARD, 11_u8, state).serialize(serializer),
            Self::Truth(truth) => (TRUTH, truth).serialize(serializer),
        }
    }
}

impl Serialize for Message {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        MessageRef::from(self).serialize(serializer)
    }
}

/// A configuration, which a host sends and a board repeats: its code is in the image
/// once, which saves 1 kB.
struct Shared<'a>(&'a Config);

impl Serialize for Shared<'_> {
    #[inline(never)]
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

#[inline]
fn serialize_input<S: Serializer>(input: &Input, serializer: S) -> Result<S::Ok, S::Error> {
    match input {
        Input::Configure(config) => (TO_BOARD, 1_u8, Shared(config)).serialize(serializer),
        Input::Proximity { stamp_us, samples } => {
            (TO_BOARD, 2_u8, stamp_us, samples).serialize(serializer)
        }
        Input::Odometry { stamp_us, pose } => {
            (TO_BOARD, 3_u8, stamp_us, pose).serialize(serializer)
        }
        Input::Wheels { stamp_us, speeds } => {
            (TO_BOARD, 4_u8, stamp_us, speeds).serialize(serializer)
        }
        Input::Tick { stamp_us } => (TO_BOARD, 5_u8, stamp_us).serialize(serializer),
        Input::Limit {
            particles_per_sensor,
        } => (TO_BOARD, 7_u8, particles_per_sensor).serialize(serializer),
    }
}

#[inline]
fn serialize_event<S: Serializer>(event: &Event, serializer: S) -> Result<S::Ok, S::Error> {
    match event {
        Event::Configured(config) => (FROM_BOARD, 1_u8, Shared(config)).serialize(serializer),
        Event::StepBegun(step) => (FROM_BOARD, 2_u8, step).serialize(serializer),
        Event::Particles(particles) => (FROM_BOARD, 3_u8, particles).serialize(serializer),
        Event::StepDone(step) => (FROM_BOARD, 4_u8, step).serialize(serializer),
        Event::OdometryReset { stamp_us } => (FROM_BOARD, 7_u8, stamp_us).serialize(serializer),
        Event::Walls(walls) => (FROM_BOARD, 12_u8, walls).serialize(serializer),
    }
}

impl<'de> Deserialize<'de> for Message {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(LONGEST, MessageVisitor)
    }
}

/// Elements of the longest message: group, number, two fields.
const LONGEST: usize = 4;

struct MessageVisitor;

impl<'de> Visitor<'de> for MessageVisitor {
    type Value = Message;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a message of this version")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Message, A::Error> {
        match next::<u32, A>(&mut parts)? {
            0 => to_board(&mut parts),
            1 => from_board(&mut parts),
            2 => next(&mut parts).map(Message::Truth),
            _ => Err(A::Error::custom("no such group of messages")),
        }
    }
}

/// The next element. Not inlined, so that each type is decoded by one copy of the code.
#[inline(never)]
fn next<'de, T: Deserialize<'de>, A: SeqAccess<'de>>(parts: &mut A) -> Result<T, A::Error> {
    let part = parts.next_element()?;
    part.ok_or_else(|| A::Error::custom("the message ends early"))
}

fn to_board<'de, A: SeqAccess<'de>>(parts: &mut A) -> Result<Message, A::Error> {
    Ok(Message::Input(match next::<u32, A>(parts)? {
        0 => return Ok(Message::Hello),
        1 => Input::Configure(next(parts)?),
        2 => Input::Proximity {
            stamp_us: next(parts)?,
            samples: next(parts)?,
        },
        3 => Input::Odometry {
            stamp_us: next(parts)?,
            pose: next(parts)?,
        },
        4 => Input::Wheels {
            stamp_us: next(parts)?,
            speeds: next(parts)?,
        },
        5 => Input::Tick {
            stamp_us: next(parts)?,
        },
        6 => return Ok(Message::Calibrate),
        7 => Input::Limit {
            particles_per_sensor: next(parts)?,
        },
        _ => return Err(A::Error::custom("no such message to a board")),
    }))
}

fn from_board<'de, A: SeqAccess<'de>>(parts: &mut A) -> Result<Message, A::Error> {
    Ok(match next::<u32, A>(parts)? {
        0 => Message::Boot(next(parts)?),
        1 => Message::Event(Event::Configured(next(parts)?)),
        2 => Message::Event(Event::StepBegun(next(parts)?)),
        3 => Message::Event(Event::Particles(next(parts)?)),
        4 => Message::Event(Event::StepDone(next(parts)?)),
        5 => Message::Answer {
            input: next(parts)?,
            refused: next(parts)?,
        },
        6 => Message::Status(next(parts)?),
        7 => Message::Event(Event::OdometryReset {
            stamp_us: next(parts)?,
        }),
        8 => Message::Health(next(parts)?),
        9 => Message::Offsets(next(parts)?),
        10 => Message::PostMortem(next(parts)?),
        11 => Message::Supervision(next(parts)?),
        12 => {
            let walls: Walls = next(parts)?;
            walls.check().map_err(A::Error::custom)?;
            Message::Event(Event::Walls(walls))
        }
        _ => return Err(A::Error::custom("no such message from a board")),
    })
}
