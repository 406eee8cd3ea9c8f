//! Studies of a simulated robot, in the paper's scenarios of several sensors.
//!
//! `cargo run --release -p sim-harness --example robot_studies -- sensor-faults`: the cost of
//! a broken sensor; the exit code is 1 if it is too high. `... -- stamps`: the cost of
//! odometry frames without the time of their pose.

use std::error::Error;
use std::process::ExitCode;

use clap::{Args, Parser};
use sim_harness::console;
use sim_harness::evaluation::{MeanStd, Number, SCORES_IN_WORDS, SensorFaultTrials, StampTrials};
use sim_harness::mapping::Method;
use sim_harness::world::{Physics, standard_scenarios};

/// Studies of a simulated robot.
#[derive(Debug, Parser)]
enum Study {
    /// The cost of a sensor that breaks.
    SensorFaults {
        #[command(flatten)]
        seeds: Seeds,
        /// Rule of the signal: matched or patch.
        #[arg(long, value_name = "PHYSICS", default_value_t = Physics::Matched)]
        physics: Physics,
        /// When the sensor breaks, as a share of the drive's time; the middle of the
        /// mazes' drives lies in a turn in place.
        #[arg(long, value_name = "SHARE", default_value_t = 0.5)]
        breaks_at: f64,
        /// Methods, separated by commas.
        #[arg(
            long,
            value_name = "METHODS",
            value_delimiter = ',',
            default_value = "paper,plus"
        )]
        methods: Vec<Method>,
        /// Particles for each sensor in use.
        #[arg(long, value_name = "N", default_value_t = 1000)]
        particles: u16,
    },
    /// The cost of odometry frames without the time of their pose.
    Stamps(Seeds),
}

/// Seeds of noise, clocks and filters.
#[derive(Debug, Args)]
struct Seeds {
    /// The first seed.
    #[arg(long, value_name = "N", default_value_t = 100)]
    first_seed: u64,
    /// Number of drives per scenario.
    #[arg(long, value_name = "N", default_value_t = 20)]
    drives: u64,
}

impl Seeds {
    fn range(&self) -> std::ops::Range<u64> {
        self.first_seed..self.first_seed.saturating_add(self.drives)
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut scenarios = standard_scenarios()?;
    scenarios.retain(|scenario| scenario.ring().1.len() > 1);
    match Study::parse() {
        Study::SensorFaults {
            seeds,
            physics,
            breaks_at,
            methods,
            particles,
        } => sensor_faults(&SensorFaultTrials {
            scenarios,
            physics,
            seeds: seeds.range(),
            breaks_at: breaks_at.clamp(0.0, 1.0),
            methods,
            particles_per_sensor: particles,
        }),
        Study::Stamps(seeds) => {
            let seeds = seeds.range();
            stamps(&StampTrials { scenarios, seeds })
        }
    }
}

/// The cost of a broken sensor, and whether it is within its bounds.
fn sensor_faults(trials: &SensorFaultTrials) -> Result<ExitCode, Box<dyn Error>> {
    console::print(format_args!(
        "A robot of which one sensor breaks after {:.0} % of the drive, another one for each \
         seed; physics {}, {} drives",
        100.0 * trials.breaks_at,
        trials.physics,
        trials.scenarios.len() as u64 * (trials.seeds.end - trials.seeds.start) * 4
    ));
    console::print_text(format_args!("\n{SCORES_IN_WORDS}\n"));
    let rows = trials.run()?;
    rows.iter().for_each(console::print_text);
    let failed = rows.iter().filter(|row| !row.holds()).count();
    console::print(format_args!(
        "{failed} of {} rows cost a drive more than they may",
        rows.len()
    ));
    Ok(ExitCode::from(u8::from(failed > 0)))
}

/// The cost of the stamps of the odometry.
fn stamps(trials: &StampTrials) -> Result<ExitCode, Box<dyn Error>> {
    console::print(
        "A robot's OE % with exact poses / frames with the time of their pose / as its senses \
         stamp them / 25 ms before they came;",
    );
    console::print(
        "plain OE % of the same four; and how far the last three put a step from the truth, RMS, mm",
    );
    console::print_text(format_args!("\n{SCORES_IN_WORDS}\n"));
    for row in trials.run()? {
        let number = |value: Option<f64>, scale: f64, decimals| Number {
            value: value.map(|value| scale * value),
            decimals,
        };
        let percent = |share: MeanStd| number(share.mean, 100.0, 2);
        let [exact, dated, stamped, aged] = row.plain.map(percent);
        let [true_mm, own_mm, age_mm] = row.off_m.map(|off_m| number(off_m.mean, 1e3, 1));
        console::print(format_args!(
            "{:6} {:6} {:5} / {:5} / {:5} / {:5}   \
             {exact:5} / {dated:5} / {stamped:5} / {aged:5}   {true_mm:4} / {own_mm:4} / {age_mm:4}",
            row.scenario,
            format!("{:?}", row.profile).to_lowercase(),
            percent(row.exact),
            percent(row.true_stamps),
            percent(row.own_stamps),
            percent(row.mean_age),
        ));
    }
    Ok(ExitCode::SUCCESS)
}
