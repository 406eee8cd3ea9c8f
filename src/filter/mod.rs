//! The inverse particle filter: "where are the surfaces?" with the robot in the middle.
//!
//! [`InverseParticleFilter::step`] is Algorithm 1 of the paper, one line a stage:
//! move ([`propagate`](crate::kinematics::InverseMotion)), weigh ([`Scan`]), survive
//! (`survive`), count ([`Outcome`]), redraw (`redraw`, Algorithm 2). What never
//! changes during a run is a [`Model`], what changes is a [`ParticleSet`]; each of
//! the two profiles is a value of [`FilterParameters`].
//!
//! Source key: "the paper" is Korthals, Barther, Schoepping, Herbrechtsmeier,
//! Rueckert: Occupancy Grid Mapping with Highly Uncertain Range Sensors based on
//! Inverse Particle Filters, ICINCO 2016, doi 10.5220/0005960001920200.

mod gating;
mod model;
mod parameters;
mod particles;
mod redraw;
mod step;
mod survive;
mod visibility;
mod weigh;

pub use gating::Outcome;
pub use model::Model;
pub use parameters::{FilterParameters, NothingDraw, ParameterError, Profile, SurvivalRule};
pub use particles::ParticleSet;
pub use step::{InverseParticleFilter, Tally};
pub use weigh::{Scan, View};
