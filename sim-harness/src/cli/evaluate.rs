//! `cargo ipf evaluate`: every method on the same drives, and the claims about them.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use clap::Args;
use sim_harness::evaluation::{Assessment, Claims, MethodComparison, json};
use sim_harness::world::OdometryModel;
use sim_harness::{console, output};

use super::comparison_arguments::ComparisonArguments;
use super::evaluate_recorded::Recorded;
use super::progress::PassProgress;
use super::{
    CommandResult, ExitStatus, arguments, evaluate_pairs, evaluate_report, evaluate_tables,
};

/// Least number of seeds that the thresholds are made for.
const ENOUGH_SEEDS: u64 = 10;

/// Arguments of `evaluate`.
#[derive(Debug, Args)]
pub(super) struct Evaluate {
    #[command(flatten)]
    compared: ComparisonArguments,
    /// File for the scores of every drive.
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    json: Option<PathBuf>,
    /// End with exit code 1 if a claim or a threshold does not hold.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    recorded: Recorded,
}

impl Evaluate {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        let out = self.json.as_deref();
        let ComparisonArguments {
            methods, particles, ..
        } = &self.compared;
        if let Some(result) = self.recorded.run(methods, *particles, out) {
            return result;
        }
        if let Some(json) = out {
            arguments::check_file("--json", json)?;
            let scenarios = self.compared.scenario.iter().map(Path::new);
            let read: Vec<_> = scenarios.chain(self.compared.gains.as_deref()).collect();
            output::check(&[json.to_owned()], &read)?;
        }
        let begun = Instant::now();
        let comparison = self.compared.comparison()?;
        let progress = Mutex::new(PassProgress::default());
        let assessment = Assessment::of(&comparison, &Claims::built_in()?, &|made, of| {
            if let Ok(mut progress) = progress.lock() {
                progress.show_count("maps made", made, of);
            }
        })?;
        drop(progress);
        if let Some(path) = &self.json {
            output::write(path, json(&assessment.trials)?.as_bytes())?;
        }
        self.report(&comparison, &assessment);
        console::print(format_args!(
            "{} drives, {} maps, {:.1} s",
            comparison.scenarios.len() as u64
                * (self.compared.seeds.end - self.compared.seeds.start),
            assessment.trials.len(),
            begun.elapsed().as_secs_f64()
        ));
        if !self.check {
            return Ok(ExitStatus::Good);
        }
        let holds = assessment.holds();
        let holds = holds.ok_or("--check, but no claim is about these scenarios and methods")?;
        Ok(if holds {
            ExitStatus::Good
        } else {
            ExitStatus::Failed
        })
    }

    fn report(&self, comparison: &MethodComparison, assessment: &Assessment) {
        let trials = &assessment.trials;
        evaluate_report::world(comparison);
        evaluate_tables::scores(comparison, trials);
        evaluate_tables::together(comparison, trials);
        evaluate_pairs::print(comparison, trials);
        evaluate_report::verdicts("Claims of the paper", &assessment.paper);
        evaluate_report::verdicts("Thresholds", &assessment.thresholds);
        if self.compared.seeds.end - self.compared.seeds.start < ENOUGH_SEEDS {
            console::print(format_args!(
                "Thresholds are made for means over {ENOUGH_SEEDS} seeds or more."
            ));
        }
        evaluate_report::not_reproduced(trials);
        if self.compared.odometry == OdometryModel::Amiro {
            evaluate_report::odometry(&assessment.odometry);
        }
    }
}
