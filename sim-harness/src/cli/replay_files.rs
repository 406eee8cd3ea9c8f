//! The files of a replay, and what of them is printed.

use std::error::Error;
use std::path::Path;

use sim_harness::device::{ReplayPlan, Replayed};
use sim_harness::evaluation::{ScoreRecord, event_scores};
use sim_harness::log::StoredRecording;
use sim_harness::output;
use sim_harness::report::{RunSummary, WallCount, WallReports, run_picture, save_run_map};
use sim_harness::world::Scenario;

use super::replay_report;

/// Where the files of a replay go, and what they say of it.
pub(super) struct ReplayFiles<'a> {
    /// The folder.
    pub(super) out: &'a Path,
    /// Title of the picture.
    pub(super) title: &'a str,
    /// Where the filter ran.
    pub(super) ran_on: &'static str,
    /// The world, where the recording carries it.
    pub(super) scenario: Option<&'a Scenario>,
}

impl ReplayFiles<'_> {
    /// Writes the files, then prints what was found.
    pub(super) fn report(
        &self,
        plan: &ReplayPlan<'_>,
        recording: &mut StoredRecording,
        mut run: Replayed,
    ) -> Result<(), Box<dyn Error>> {
        let run_record = &run.run_record;
        let figures = run_record.statistics();
        let hull = plan.hull_radius_m;
        let scores = match self.scenario.zip(run.events.all.take()) {
            Some((scenario, events)) => Some(event_scores(
                plan.config,
                scenario,
                hull,
                run_record.poses(),
                events,
            )?),
            None => None,
        };
        let walls = self.scenario.is_none().then(|| WallReports::of(run_record));
        output::create_folder(self.out)?;
        let picture = run_picture(run_record, self.title, self.scenario, None);
        save_run_map(run_record, &picture, self.out)?;
        plan.save_stream(&self.out.join("stream.ipf"), recording, run.answered)?;
        let overview = recording.overview();
        let summary = RunSummary {
            format: overview.format.to_string(),
            refused: overview.refusals.count(),
            ran_on: self.ran_on,
            config: *plan.config,
            figures,
            scores: scores.as_ref().map(ScoreRecord::from),
            walls,
            wall_segments: WallCount::of(run_record),
            comparison: run.comparison,
        };
        summary.save(self.out)?;
        replay_report::found(&summary, scores.as_ref(), run.events.resets);
        Ok(())
    }
}
