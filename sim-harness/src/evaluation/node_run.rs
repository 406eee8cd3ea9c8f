//! A node's run over a robot's inputs: events, a map, its scores.

use amiro_ipf::node::{Config, Event, Input, StepBegun};

use super::{Scores, Truth};
use crate::drive::FilterRecords;
use crate::geometry::Pose2;
use crate::mapping::{CountingMapper, Map, Mapper};
use crate::world::Scenario;
use crate::{RunError, RunOutcome, run};

/// The result of a node's run.
#[derive(Clone, Debug)]
pub struct NodeRun {
    /// All its events.
    pub events: Vec<Event>,
    /// Steps and refusals.
    pub outcome: RunOutcome,
    /// The map at the end.
    pub map: Map,
}

/// Runs a node over inputs and counts its events into a map.
///
/// # Errors
/// As [`run`].
pub fn map(scenario: &Scenario, config: &Config, inputs: &[Input]) -> Result<NodeRun, RunError> {
    let mut mapper = CountingMapper::new(scenario.cell_m);
    let mut records = FilterRecords::new(config);
    let mut events = Vec::new();
    let outcome = run(config, inputs, |event| {
        records.translate(event, &mut |record| mapper.take(record));
        events.push(event.clone());
    })?;
    Ok(NodeRun {
        events,
        outcome,
        map: mapper.map(),
    })
}

impl NodeRun {
    /// The begin of each step.
    pub fn steps(&self) -> impl Iterator<Item = &StepBegun> {
        self.events.iter().filter_map(|event| match event {
            Event::StepBegun(step) => Some(step),
            _ => None,
        })
    }

    /// Scores of the map; visibility is from the poses of the steps.
    #[must_use]
    pub fn scores(&self, scenario: &Scenario) -> Scores {
        let poses: Vec<Pose2> = self.steps().map(|step| step.pose.into()).collect();
        Scores::of(&self.map, &Truth::of(scenario, &poses))
    }
}
