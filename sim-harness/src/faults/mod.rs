//! Faults in words: `s3=stuck@5s..8s, can=off@10s, link=ber:1e-3`.
//!
//! A [`Fault`] is a component, a kind and a window. One parser reads them; the simulated
//! robot with its buses, the serial line ([`FaultInjector`](crate::device::FaultInjector))
//! and the inputs of a recording ([`Faults::on_inputs`]) interpret them. The words are
//! those of PX4's failure injection: `ok`, `off`, `stuck`, `garbage`, `wrong`, `slow`,
//! `delayed`, `intermittent`; a sensor may be `saturated` too. The line has words of its
//! own, joined by `+`: `link=ber:1e-3+off@2s..5s`.
//!
//! A window is `@5s`, `@5s..8s` or `@..8s` and may be left out. Faults of one component add
//! up, in the order in which they are named; `ok` ends earlier faults for its window, so
//! that `ring=off, s3=ok` leaves one sensor.
//!
//! A table of `docs/faults.md` lists the effect of each word on each component, and the
//! robot's report of it.

mod active;
mod component;
mod error;
mod fault;
mod kind;
mod line_words;
mod on_inputs;
mod parse;
mod window;

pub use active::{ActiveFault, ActiveFaults};
pub use component::Component;
pub use error::FaultError;
pub use fault::{Fault, Faults};
pub use kind::Kind;
pub(crate) use kind::period_us;
pub use on_inputs::{FaultyInputs, NotOnInputs};
pub use window::Window;
