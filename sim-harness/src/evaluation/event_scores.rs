//! Scores of a run whose events were kept.

use std::io;

use amiro_ipf::node::Config;

use super::{DriveJudge, DriveScores, Truth};
use crate::drive::{FilterRecords, Record};
use crate::geometry::Pose2;
use crate::log::Overview;
use crate::mapping::{CountingMapper, FootprintMapper};
use crate::pipeline;
use crate::spool::EventSpool;
use crate::world::{Scenario, ScenarioError};

/// The world that a simulated recording carries.
///
/// # Errors
/// As [`Scenario::parse`].
pub fn recorded_scenario(overview: &Overview) -> Result<Option<Scenario>, ScenarioError> {
    let truth = overview.truth.as_ref();
    let text = truth.and_then(|truth| truth.scenario.as_ref());
    text.map(|text| Scenario::parse(text)).transpose()
}

/// Scores on the way of a run in a known world, from its events.
///
/// `poses` are those of its steps; with a radius, metres, the footprint of that hull is
/// free in the map.
///
/// # Errors
/// The events cannot be read again.
pub fn event_scores(
    config: &Config,
    scenario: &Scenario,
    hull_radius_m: Option<f64>,
    poses: &[Pose2],
    events: EventSpool,
) -> io::Result<DriveScores> {
    let truth = Truth::of(scenario, poses);
    let mapper = CountingMapper::new(scenario.cell_m);
    let mut mapper = FootprintMapper::new(mapper, scenario.cell_m, hull_radius_m);
    let mut events = events.events()?;
    let mut judge = DriveJudge::new(scenario, &truth, poses);
    let mut records = FilterRecords::new(config);
    let read = |take: &mut dyn FnMut(&Record)| {
        events
            .by_ref()
            .for_each(|event| records.translate(&event, take));
        events.finish()
    };
    pipeline::run(read, &mut mapper, &mut |record, mapper| {
        judge.take(record, mapper);
    })?;
    Ok(judge.finish(&mapper))
}
