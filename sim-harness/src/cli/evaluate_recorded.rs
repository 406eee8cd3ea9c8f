//! `cargo ipf evaluate --recordings`: every method on recorded series beside known walls.

use std::path::{Path, PathBuf};

use clap::Args;
use sim_harness::evaluation::recorded::{RecordedSeries, RecordedSettings, SERIES_FILE};
use sim_harness::mapping::Method;
use sim_harness::{console, output};

use super::progress::PassProgress;
use super::{CommandResult, ExitStatus, arguments};

/// Arguments of `evaluate` about recorded series.
#[derive(Debug, Args)]
pub(super) struct Recorded {
    /// Judge recorded series instead of simulated drives: the folder of the recordings of a
    /// robot that was put down beside walls of known place. Its file series.toml describes
    /// them; scenarios/recorded_series.toml is an example.
    #[arg(
        long,
        value_name = "FOLDER",
        conflicts_with_all = [
            "scenario", "seeds", "physics", "odometry", "alpha", "gains", "calibrate", "footprint",
            "threads", "check",
        ]
    )]
    recordings: Option<PathBuf>,
    /// Description of the recorded series; by default series.toml in their folder.
    #[arg(long, value_name = "FILE", requires = "recordings")]
    series: Option<PathBuf>,
}

impl Recorded {
    /// Judges the series of a folder, if one was named.
    pub(super) fn run(
        &self,
        methods: &[Method],
        particles_per_sensor: u16,
        json: Option<&Path>,
    ) -> Option<CommandResult> {
        let settings = RecordedSettings {
            methods: arguments::distinct(methods),
            particles_per_sensor,
        };
        let folder = self.recordings.as_deref()?;
        Some(self.judge(folder, &settings, json))
    }

    fn judge(
        &self,
        folder: &Path,
        settings: &RecordedSettings,
        json: Option<&Path>,
    ) -> CommandResult {
        let default = folder.join(SERIES_FILE);
        let description = self.series.as_deref().unwrap_or(&default);
        let series = RecordedSeries::load(folder, description)?;
        if let Some(json) = json {
            arguments::check_file("--json", json)?;
            let files: Vec<&Path> = series.files().iter().map(PathBuf::as_path).collect();
            output::check(&[json.to_owned()], &files)?;
        }
        let mut progress = PassProgress::default();
        let report = series.judge(settings, &mut |done, of| {
            progress.show_count("readings mapped", done, of);
        })?;
        drop(progress);
        if let Some(json) = json {
            output::write(json, report.json()?.as_bytes())?;
        }
        console::print_text(&report);
        Ok(ExitStatus::Good)
    }
}
