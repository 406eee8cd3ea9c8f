//! The inverse particle filter: "where are the surfaces?" with the robot in the middle.
//!
//! [`InverseParticleFilter::step`] is Algorithm 1 of the paper: it propagates
//! (`propagate`), weighs ([`Scan`]), resamples (`resample`), counts ([`Tally`],
//! [`Outcome`]) and redraws (`redraw`, Algorithm 2). A [`Model`] is constant during a
//! run; a [`ParticleSet`] changes in every step. Each of the two profiles is a value
//! of [`FilterParameters`].
//!
//! Source key: "the paper" is Korthals, Barther, Schoepping, Herbrechtsmeier,
//! Rueckert: Occupancy Grid Mapping with Highly Uncertain Range Sensors based on
//! Inverse Particle Filters, ICINCO 2016, doi 10.5220/0005960001920200.

mod gating;
mod model;
mod parameters;
mod particles;
mod propagate;
mod redraw;
mod resample;
mod seen_wall;
mod segments;
mod step;
mod tally;
mod visibility;
mod wall_parameters;
mod wall_scan;
mod weigh;

pub use gating::Outcome;
pub use model::Model;
pub use parameters::{FilterParameters, NothingDraw, ParameterError, Profile, SurvivalRule};
pub use particles::ParticleSet;
pub use segments::{
    EndSigma, MAX_SEGMENTS, MAX_WINDOW, SegmentModel, SegmentParameters, SegmentTracker,
    TrackedSegment,
};
pub use step::InverseParticleFilter;
pub use tally::Tally;
pub use wall_parameters::WallParameters;
pub use weigh::{Evaluation, Scan};
