//! `cargo ipf evaluate`: every method on the same drives, and what holds of the claims.

use std::collections::BTreeSet;
use std::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use sim_harness::evaluation::{
    Claim, Comparison, Method, STANDARD, Trial, Verdict, json, paper_claims, standard, thresholds,
};
use sim_harness::output;
use sim_harness::world::Scenario;

use super::evaluate_report;
use super::{Ending, Outcome};

/// Fewest seeds that the thresholds are made for.
const ENOUGH_SEEDS: u64 = 10;
/// Most drives, so that a slip of the keyboard ends at once and not tomorrow.
const MAX_DRIVES: u64 = 100_000;

/// Arguments of `evaluate`.
#[derive(Debug, Args)]
pub(super) struct Evaluate {
    /// Scenarios: names of the paper's or TOML files; all of the paper's by default.
    #[arg(long, value_name = "NAME|FILE", num_args = 1.., value_delimiter = ',')]
    scenario: Vec<String>,
    /// Methods, separated by commas.
    #[arg(
        long,
        value_name = "METHODS",
        value_delimiter = ',',
        default_value = "paper,plus,ism-standard,ism-tuned,ism-standard-dropped,\
                         ism-standard-object,ism-tuned-dropped,ism-tuned-object"
    )]
    methods: Vec<Method>,
    /// Seeds of noise and filters, the end excluded; 0 to 99 were for tuning.
    #[arg(long, value_name = "A..B", default_value = "100..120", value_parser = seeds)]
    seeds: Range<u64>,
    /// Particles for each sensor in use.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    particles: u16,
    /// Threads; 0 for one a processor. The figures do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Where the figures of every drive go.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// End with exit code 1 if a claim or a threshold does not hold.
    #[arg(long)]
    check: bool,
}

impl Evaluate {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        let begun = Instant::now();
        let comparison = self.comparison()?;
        let trials = comparison.run()?;
        let claims = verdicts(&paper_claims(), &trials);
        let bounds = verdicts(&thresholds(), &trials);
        evaluate_report::tables(&comparison, &trials);
        evaluate_report::paired(&comparison, &trials);
        evaluate_report::verdicts("Claims of the paper", &claims);
        evaluate_report::verdicts("Thresholds", &bounds);
        if self.seeds.end - self.seeds.start < ENOUGH_SEEDS {
            println!("Thresholds are made for means over {ENOUGH_SEEDS} seeds or more.");
        }
        evaluate_report::not_reproduced(&trials);
        if let Some(path) = &self.json {
            output::write(path, json(&trials)?.as_bytes())?;
        }
        println!(
            "{} drives, {} maps, {:.1} s",
            comparison.scenarios.len() as u64 * (self.seeds.end - self.seeds.start),
            trials.len(),
            begun.elapsed().as_secs_f64()
        );
        if !self.check {
            return Ok(Ending::Good);
        }
        let mut judged = claims.iter().chain(&bounds).peekable();
        if judged.peek().is_none() {
            return Err("--check, but no claim is about these scenarios and methods".into());
        }
        Ok(if judged.all(Verdict::holds) {
            Ending::Good
        } else {
            Ending::Failed
        })
    }

    fn comparison(&self) -> Result<Comparison, Box<dyn Error>> {
        let mut methods = Vec::new();
        for method in &self.methods {
            if !methods.contains(method) {
                methods.push(*method);
            }
        }
        let scenarios = self.scenarios()?;
        let drives = scenarios.len() as u64;
        let seeds = self.seeds.end - self.seeds.start;
        if drives.saturating_mul(seeds) > MAX_DRIVES {
            return Err(format!("{seeds} seeds: at most {MAX_DRIVES} drives in all").into());
        }
        Ok(Comparison {
            scenarios,
            methods,
            seeds: self.seeds.clone(),
            particles_per_sensor: self.particles,
            threads: self.threads,
        })
    }

    fn scenarios(&self) -> Result<Vec<Scenario>, Box<dyn Error>> {
        let all = STANDARD.map(|(name, _)| name.to_owned());
        let wanted = if self.scenario.is_empty() {
            all.as_slice()
        } else {
            &self.scenario
        };
        let mut scenarios = Vec::new();
        let mut names = BTreeSet::new();
        for wanted in wanted {
            let scenario = scenario(wanted)?;
            if !names.insert(scenario.name.clone()) {
                return Err(format!("two scenarios are named {}", scenario.name).into());
            }
            scenarios.push(scenario);
        }
        Ok(scenarios)
    }
}

/// A scenario of the paper by its name, or another from its file.
fn scenario(wanted: &str) -> Result<Scenario, Box<dyn Error>> {
    if let Some(known) = standard(wanted) {
        return Ok(known?);
    }
    let scenario = Scenario::load(Path::new(wanted))?;
    // The claims go by names: another world must not be judged by the paper's.
    if let Some(known) = standard(&scenario.name)
        && known? != scenario
    {
        let name = &scenario.name;
        return Err(format!("{wanted}: named {name}, but not the paper's; rename it").into());
    }
    Ok(scenario)
}

/// Seeds from `A..B`.
fn seeds(text: &str) -> Result<Range<u64>, String> {
    let bounds = text.split_once("..");
    let number = |text: &str| text.parse::<u64>().ok();
    match bounds.and_then(|(first, end)| Some(number(first)?..number(end)?)) {
        Some(seeds) if !seeds.is_empty() => Ok(seeds),
        _ => Err("two numbers A..B are wanted, A below B".to_owned()),
    }
}

fn verdicts(claims: &[Claim], trials: &[Trial]) -> Vec<Verdict> {
    claims
        .iter()
        .filter_map(|claim| claim.judge(trials))
        .collect()
}
