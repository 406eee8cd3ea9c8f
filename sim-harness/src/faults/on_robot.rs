//! The faults of a simulated robot.

use super::held::Held;
use super::word::{micros, period_us};
use super::{Component, Faults, Word};
use crate::robot::{BusTrouble, MuxTrouble, RobotFaults, Trouble};

impl Faults {
    /// The same for a simulated robot: times are those of its drive, and what is broken
    /// when that begins has been so since the power came up.
    ///
    /// Its buses' scripts follow from it; what is random is drawn from the seed.
    #[must_use]
    pub fn on_robot(&self, seed: u64) -> RobotFaults {
        let none = RobotFaults::none().seeded(seed);
        let held = self.held().into_iter();
        held.filter_map(|held| Some((trouble_of(&held)?, held.when_us)))
            .fold(none, |faults, (trouble, when_us)| {
                faults.during(when_us, trouble)
            })
    }
}

/// What a word means to a part; `None` for pairs that no text can name.
fn trouble_of(held: &Held) -> Option<Trouble> {
    Some(match held.component {
        Component::Sensor(sensor) => match held.word {
            Word::Off => Trouble::Unplugged { sensor },
            Word::Stuck => Trouble::Stuck { sensor },
            Word::Garbage => Trouble::Garbage { sensor },
            Word::Wrong(counts) => Trouble::Wrong { sensor, counts },
            Word::Slow(rate_hz) => Trouble::Slow {
                sensor,
                period_us: period_us(rate_hz),
            },
            Word::Delayed(by) => Trouble::Late {
                sensor,
                by_us: micros(by),
            },
            Word::Intermittent(share) => Trouble::Loose { sensor, share },
            Word::Saturated => Trouble::Saturated { sensor },
            Word::Ok => return None,
        },
        Component::Bus(bus) => {
            let trouble = match held.word {
                Word::Off => BusTrouble::Off,
                Word::Stuck => BusTrouble::HeldLow,
                Word::Garbage => BusTrouble::Disturbed,
                Word::Intermittent(share) => BusTrouble::Loose { share },
                _ => return None,
            };
            Trouble::Bus { bus, trouble }
        }
        Component::Mux(bus) => {
            let trouble = match held.word {
                Word::Off => MuxTrouble::Off,
                Word::Stuck => MuxTrouble::Stuck,
                Word::Garbage => MuxTrouble::Jumping,
                Word::Intermittent(share) => MuxTrouble::Loose { share },
                _ => return None,
            };
            Trouble::Mux { bus, trouble }
        }
        Component::Can => match held.word {
            Word::Off => Trouble::NoFrames,
            Word::Stuck => Trouble::SameFrames,
            Word::Garbage => Trouble::GarbledFrames,
            Word::Wrong(by_mm) => Trouble::Elsewhere {
                by_m: [by_mm as f32 * 1e-3, 0.0],
            },
            Word::Slow(rate_hz) => Trouble::SeldomFrames {
                period_us: period_us(rate_hz),
            },
            Word::Delayed(by) => Trouble::LateFrames { by_us: micros(by) },
            Word::Intermittent(share) => Trouble::LooseFrames { share },
            Word::Ok | Word::Saturated => return None,
        },
        Component::Ring => return None,
    })
}
