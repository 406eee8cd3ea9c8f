//! Two steps of the filter towards an object, with every particle on record.

use amiro_ipf::filter::{InverseParticleFilter, Outcome, ParticleSet, Profile};
use amiro_ipf::geometry::Point;
use amiro_ipf::model::Ring;
use amiro_ipf::node::{BATCH, Event, ParticleEvent, Particles, StepBegun};

use super::one_sensor;

/// Particles of the one sensor, as in the paper.
pub(super) const PARTICLES: usize = 1000;

/// Distance of the object from the sensor at the start, metres.
pub(super) const OBJECT_M: f32 = 0.1;

/// Length of a step, metres.
const STEP_M: f32 = 0.01;

/// Survived steps after which a particle counts as a surface.
const GATE: u8 = 2;

/// Particles in the plane, millimetres ahead of the sensor and to its left.
pub(super) type Cloud = Vec<(f64, f64)>;

/// One of the steps.
pub(super) struct RecordedStep {
    /// The input of the step.
    pub(super) begun: StepBegun,
    /// Distance since the start, metres.
    pub(super) travelled_m: f32,
    /// Every outcome, in the body frame.
    pub(super) outcomes: Vec<ParticleEvent>,
    /// The particles that survived.
    pub(super) survived: Cloud,
    /// The particles that were rejected.
    pub(super) rejected: Cloud,
    /// The particles that the step drew.
    pub(super) drawn: Cloud,
}

impl RecordedStep {
    /// The step as a node reports it.
    pub(super) fn events(&self) -> Vec<Event> {
        let batch = |outcomes: &[ParticleEvent]| {
            Event::Particles(Particles {
                step: self.begun.index as u8,
                outcomes: outcomes.iter().copied().collect(),
            })
        };
        let begun = Event::StepBegun(self.begun);
        let batches = self.outcomes.chunks(BATCH).map(batch);
        std::iter::once(begun).chain(batches).collect()
    }
}

/// The steps at t = 0, 1 and 2.
pub(super) fn take(profile: Profile, seed: u64) -> Vec<RecordedStep> {
    let mut config = one_sensor::config(profile);
    config.parameters.gate = GATE;
    let model = config.model();
    let mut set = Box::new(ParticleSet::<PARTICLES>::new());
    let mut filter = InverseParticleFilter::new(&mut set, PARTICLES, seed);
    let mut last = None;
    let mut steps = Vec::new();
    for index in 0_u8..3 {
        let travelled_m = STEP_M * f32::from(index);
        let counts = one_sensor::counts_at(OBJECT_M - travelled_m);
        let begun = one_sensor::step(u32::from(index), travelled_m, counts);
        let motion = last.unwrap_or(begun.pose).motion_to(&begun.pose);
        last = Some(begun.pose);
        let readings = config.readings(&begun.samples);
        let mut outcomes = Vec::new();
        filter.step(&model, &motion, &readings, |place, outcome| {
            outcomes.push(ParticleEvent::new(place, outcome));
        });
        let of = |wanted: [Outcome; 2]| {
            let outcomes = outcomes.iter();
            let wanted = outcomes.filter(|event| wanted.contains(&event.outcome()));
            wanted
                .map(|event| before_sensor_mm(event.position()))
                .collect()
        };
        steps.push(RecordedStep {
            travelled_m,
            survived: of([Outcome::SurvivedPastGate, Outcome::SurvivedBelowGate]),
            rejected: of([Outcome::RejectedFree, Outcome::RejectedUnobserved]),
            drawn: filter
                .live()
                .filter(|(_, age)| *age == 0)
                .map(|(place, _)| before_sensor_mm(place))
                .collect(),
            begun,
            outcomes,
        });
    }
    steps
}

/// A point of the body frame relative to the sensor, millimetres.
fn before_sensor_mm(place: Point) -> (f64, f64) {
    let ahead_m = place.x - Ring::AMIRO.radius_m;
    (1e3 * f64::from(ahead_m), 1e3 * f64::from(place.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn about_four_fifths_survive_the_first_step_as_in_the_paper() {
        let steps = take(Profile::Paper, 1);
        let [start, first, second] = &steps[..] else {
            panic!("{} steps", steps.len());
        };
        assert_eq!((start.drawn.len(), start.outcomes.len()), (PARTICLES, 0));
        // 82 % of many particles; 4 sigma of 1000 are 5 %.
        let survived = first.survived.len();
        assert!((770..=870).contains(&survived), "{survived}");
        assert_eq!(survived + first.rejected.len(), PARTICLES);
        assert_eq!(first.drawn.len(), first.rejected.len());
        assert_eq!(second.outcomes.len(), PARTICLES);
    }
}
