//! Three calculi over one model of a sonar, and the box that shortens readings.
//!
//! Ivanjko, Petrovic and Macek 2003 compare Bayes, Dempster-Shafer and fuzzy sets. They
//! print the rules of update; the sensor model is ours, see [`SonarModel`].

mod bayes;
mod bounding_box;
mod cone_evidence;
mod dempster_shafer;
mod fuzzy;
mod sonar_model;

pub use bayes::Bayes;
pub use bounding_box::BoxMapper;
pub use cone_evidence::ConeEvidenceMapper;
pub use dempster_shafer::{DempsterShafer, Masses};
pub use fuzzy::{Complements, Fuzzy, Memberships, safe_membership};
pub use sonar_model::{ConePlace, SonarModel};

#[cfg(test)]
mod tests;
