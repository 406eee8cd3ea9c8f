//! The inverted particle filter for range beams as mapping methods.

use super::{Method, SensorChoice, Setup};
use crate::mapping::{BeamForm, BeamMapper, Mapper};
use crate::sensors::SensorKind;

const BEAMS: &str = "Kleppe and Skavhaug 2013, with resampling for a robot that moves";
const BEAMS_PAPER: &str = "Kleppe and Skavhaug 2013, algorithm 2";

const RANGE_SENSORS: SensorChoice = SensorChoice::FirstOf(&[SensorKind::Scanner, SensorKind::Cone]);

impl Method {
    /// The inverted particle filter for range beams, for a robot that moves.
    pub const KLEPPE: Self = Self {
        maps_every_pose: true,
        ..Self::new("kleppe", BEAMS, RANGE_SENSORS, |s| {
            beams(s, BeamForm::Moving)
        })
    };
    /// The same with the resampling and re-entry of its paper.
    pub const KLEPPE_PAPER: Self = Self {
        maps_every_pose: true,
        ..Self::new("kleppe-paper", BEAMS_PAPER, RANGE_SENSORS, |s| {
            beams(s, BeamForm::Paper)
        })
    };
}

fn beams(setup: &Setup<'_>, form: BeamForm) -> Box<dyn Mapper> {
    Box::new(BeamMapper::new(setup.lattice, setup.rig, form))
}
