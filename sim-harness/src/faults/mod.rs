//! What is to break, in words: `s3=stuck@5s..8s, can=off@10s, link=ber:1e-3`.
//!
//! One language for the simulated robot ([`Faults::on_robot`]), its buses
//! ([`RobotFaults::script`](crate::robot::RobotFaults::script)), the serial line
//! ([`Faults::line`]) and the inputs of a recording ([`Faults::on_inputs`]). The words are
//! those of PX4's failure injection: `ok`, `off`, `stuck`, `garbage`, `wrong`, `slow`,
//! `delayed`, `intermittent`; a sensor may be `saturated` too. A line has words of its
//! own, those of [`LineFaults`](crate::link::LineFaults).
//!
//! A fault is a part, a word and a window, which is `@5s`, `@5s..8s` or `@..8s` and may be
//! left out. Faults of one part add up, in the order in which they are named; `ok` ends for
//! its window what was named before it, so that `ring=off, s3=ok` leaves one sensor.
//!
//! What each word does to each part, and what the robot says then, is in a table of
//! `docs/faults.md`.

mod component;
mod during;
mod error;
mod held;
mod on_inputs;
mod on_robot;
mod parse;
mod simulated;
mod spoken;
mod word;

pub use component::Component;
pub use during::During;
pub use error::FaultError;
pub use on_inputs::{FaultyInputs, NotOnInputs};
pub use simulated::{SimulatedDrive, SimulationRefused};
pub use spoken::{Fault, Faults};
pub use word::Word;
