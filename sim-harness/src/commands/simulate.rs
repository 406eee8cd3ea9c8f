//! `cargo ipf simulate`: a scenario, driven and recorded.

use std::error::Error;
use std::fmt::Display;
use std::io::Write;
use std::path::PathBuf;
use std::slice;

use amiro_ipf::board::health::{BusState, Health};
use amiro_ipf::model::SENSORS;
use clap::Args;
use sim_harness::faults::Faults;
use sim_harness::robot::SimulatedDrive;
use sim_harness::world::{Drift, Odometry, Options, OptionsError, Physics, Scenario};
use sim_harness::{console, output};

use super::health_text::{counters, counters_in_words};
use super::{Ending, Outcome, arguments};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub(super) struct Simulate {
    /// The scenario, a TOML file; `-` for standard input. A first line of options in it, as recordings have it,
    /// does not count: the flags do.
    scenario: PathBuf,
    /// Seed of the sensors' noise, and of the filter when the recording is replayed.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = arguments::seed)]
    seed: u64,
    /// Where the recording goes; `-` for standard output, the report then goes to standard
    /// error.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// What breaks when: PART=WORD with @FROM, @FROM..TO, @..TO or nothing behind it, and
    /// commas between.
    ///
    /// Parts are s0 to s7, ring (all of these), bus1, bus2, mux1, mux2, can (the odometry)
    /// and link. Words are ok, off, stuck, garbage, wrong:+200 (counts; of can wrong:+500mm),
    /// slow:20Hz, delayed:50ms, intermittent:0.3 and saturated; the link has its own, such
    /// as link=ber:1e-3+off@2s..5s. Times are those of the drive. With a part other than
    /// the link, if only ring=ok, a whole robot is simulated, with its buses and senses.
    #[arg(
        long,
        default_value_t,
        hide_default_value = true,
        value_name = "FAULTS"
    )]
    fault: Faults,
    /// Seed of what is random about the faults.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "fault", value_parser = arguments::seed)]
    seed_of_faults: u64,
    #[command(flatten)]
    differences: Differences,
}

/// Differences of the world from the filter's model; recorded with the scenario.
#[derive(Debug, Args)]
struct Differences {
    /// Rule of the signal: matched (the strongest return) or patch (the sum of all).
    #[arg(long, default_value_t, value_name = "PHYSICS")]
    physics: Physics,
    /// Sensor noise, times the model's.
    #[arg(long, default_value_t = 1.0, value_name = "F")]
    noise: f64,
    /// Offset of the sensors, counts: 10 for a constant one, 0..10 growing over the drive.
    #[arg(long, default_value_t = Drift::NONE, value_name = "COUNTS", allow_hyphen_values = true)]
    drift: Drift,
    /// Reflectivity of everything, times the scenario's.
    #[arg(long, default_value_t = 1.0, value_name = "F")]
    reflectivity: f64,
    /// Standard deviation of the sensors' gains, relative; constant over the drive.
    #[arg(long, default_value_t = 0.0, value_name = "S")]
    gain_spread: f64,
    /// Probability that a sample is missing.
    #[arg(long, default_value_t = 0.0, value_name = "P")]
    dropout: f64,
    /// Shape of the world's lobe; default: the model's.
    #[arg(long, value_name = "XI")]
    xi: Option<f64>,
    /// Dependence of the world's gain on the signal, m^2; default: the model's.
    #[arg(long, value_name = "M2", allow_hyphen_values = true)]
    delta: Option<f64>,
    /// Odometry: truth, wheel-errors (1 %, 2 degrees per root metre),
    /// wheel-errors:PERCENT:DEGREES[:DRIFT:SLIP] (degrees per metre, percent), amiro (as
    /// on its bus), or amiro-undated (as amiro, each pose taken for current).
    #[arg(long, default_value_t, value_name = "ODOMETRY")]
    odometry: Odometry,
}

impl Differences {
    fn options(&self) -> Result<Options, OptionsError> {
        let options = Options {
            physics: self.physics,
            noise_factor: self.noise,
            drift: self.drift,
            reflectivity_factor: self.reflectivity,
            gain_spread: self.gain_spread,
            dropout: self.dropout,
            xi: self.xi,
            delta_m2: self.delta,
            odometry: self.odometry,
        };
        options.validate().map(|()| options)
    }
}

impl Simulate {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        let options = self.differences.options();
        let options = options.map_err(|error| format!("--{error}"))?;
        self.check_out()?;
        let (scenario, text) = Scenario::load_with_text(&self.scenario)?;
        let drive = SimulatedDrive {
            scenario: &scenario,
            text: &text,
            seed: self.seed,
            options,
            faults: &self.fault,
            seed_of_faults: self.seed_of_faults,
        };
        let (simulation, healths) = drive.simulate()?;
        let write = |file: &mut dyn Write| drive.write(&simulation, file).map(drop);
        // Lines of a report would lie within the recording.
        let report: fn(&dyn Display) = if self.is_to_stdout() {
            console::print_bytes(write)?;
            |line| console::warn(line)
        } else {
            output::write_with(&self.out, write)?;
            |line| console::print(line)
        };
        report(&format_args!(
            "{}: {} samples of {:.1} s, {}",
            self.out.display(),
            simulation.poses.len(),
            scenario.duration_s(),
            scenario.name
        ));
        if options != Options::default() {
            report(&format_args!("simulated with: {options}"));
        }
        if !self.fault.are_none() {
            report(&format_args!(
                "faults: {}, seed {}",
                self.fault, self.seed_of_faults
            ));
        }
        print_untrusted(&healths, report);
        if let Some((_, last)) = healths.last() {
            let counters = counters_in_words(&counters(last));
            counters.iter().for_each(|line| report(line));
        }
        Ok(Ending::Good)
    }

    fn is_to_stdout(&self) -> bool {
        self.out.as_os_str() == "-"
    }

    fn check_out(&self) -> Result<(), Box<dyn Error>> {
        if !self.is_to_stdout() {
            arguments::check_file("--out", &self.out)?;
            output::check(slice::from_ref(&self.out), &[&self.scenario])?;
        } else if console::is_stdout_interactive() {
            return Err("--out -: a recording is no text, and standard output a terminal".into());
        }
        Ok(())
    }
}

/// Reports the sensors that the acquisition did not trust and the buses that did not work,
/// with the times of the changes.
fn print_untrusted(healths: &[(u64, Health)], report: fn(&dyn Display)) {
    let mut known = [None; SENSORS];
    let mut known_buses = [BusState::Working; 2];
    for (at_us, health) in healths {
        for (number, (known, now)) in (1..).zip(known_buses.iter_mut().zip(&health.buses)) {
            if std::mem::replace(known, now.state) != now.state {
                report(&format_args!(
                    "{:6.2} s: bus{number} {:?}",
                    *at_us as f64 * 1e-6,
                    now.state
                ));
            }
        }
        for (sensor, (known, now)) in known.iter_mut().zip(&health.sensors).enumerate() {
            let is_news = *known != Some(now.state)
                && (known.is_some_and(|before| !before.is_trusted()) || !now.state.is_trusted());
            if is_news {
                report(&format_args!(
                    "{:6.2} s: s{sensor} {:?}",
                    *at_us as f64 * 1e-6,
                    now.state
                ));
            }
            *known = Some(now.state);
        }
    }
}
