//! Methods in worlds that differ from their model: other surfaces, sensors and odometry.
//!
//! `cargo run --release -p sim-harness --example robustness -- --methods plus,wall-map`

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;
use sim_harness::evaluation::{Mismatch, Number, RobustnessRow, RobustnessTrials, json_lines};
use sim_harness::mapping::Method;
use sim_harness::world::{Physics, standard};
use sim_harness::{console, output};

/// Scores of methods in worlds that differ from their model, means over the seeds.
#[derive(Debug, Parser)]
struct Arguments {
    /// Methods, separated by commas.
    #[arg(
        long,
        value_name = "METHODS",
        value_delimiter = ',',
        default_value = "plus,wall-map"
    )]
    methods: Vec<Method>,
    /// Scenarios of the paper, separated by commas.
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        default_value = "msod,msm_l,msm_t"
    )]
    scenarios: Vec<String>,
    /// Rule of the signal: matched or patch.
    #[arg(long, value_name = "PHYSICS", default_value_t = Physics::Patch)]
    physics: Physics,
    /// The first seed; 0 to 99 were for tuning.
    #[arg(long, value_name = "N", default_value_t = 100)]
    first_seed: u64,
    /// Number of drives per scenario.
    #[arg(long, value_name = "N", default_value_t = 5)]
    drives: u64,
    /// Particles for each sensor in use.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    particles: u16,
    /// File for the figures.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let scenario = |name: &String| match standard(name) {
        Some(scenario) => Ok(scenario?),
        None => Err(format!("--scenarios: {name} is not one of the paper's").into()),
    };
    let scenarios: Result<Vec<_>, Box<dyn Error>> =
        arguments.scenarios.iter().map(scenario).collect();
    let trials = RobustnessTrials {
        scenarios: scenarios?,
        methods: arguments.methods,
        seeds: arguments.first_seed..arguments.first_seed.saturating_add(arguments.drives),
        particles_per_sensor: arguments.particles,
        mismatches: Mismatch::all(arguments.physics).to_vec(),
    };
    let rows = trials.run(&mut |_, _| {})?;
    if let Some(path) = &arguments.json {
        output::write(path, json_lines(&rows)?.as_bytes())?;
    }
    console::print(format_args!(
        "Simulated; physics {}, {} drives from seed {} on. OE % (recall, coverage)",
        arguments.physics, arguments.drives, arguments.first_seed
    ));
    for method in &trials.methods {
        console::print("");
        let names = trials.scenarios.iter().map(|it| format!("{:>18}", it.name));
        console::print(format_args!(
            "{:22}{}",
            method.name,
            names.collect::<String>()
        ));
        for mismatch in &trials.mismatches {
            let is_of_line =
                |row: &&RobustnessRow| (row.mismatch, row.method) == (mismatch.name, method.name);
            let cells = rows.iter().filter(is_of_line).map(cell);
            console::print(format_args!(
                "{:22}{}",
                mismatch.name,
                cells.collect::<String>()
            ));
        }
    }
    Ok(())
}

/// The figures of one scenario in a column.
fn cell(row: &RobustnessRow) -> String {
    let number = |value, decimals| Number { value, decimals };
    let text = format!(
        "{} ({}, {})",
        number(row.oe.map(|share| 100.0 * share), 1),
        number(row.surface_recall, 2),
        number(row.coverage, 2)
    );
    format!("{text:>18}")
}
