//! What unequal gains of the sensors cost a map, and what a drive's own estimate gives back.
//!
//! `cargo run --release -p sim-harness --example sensor_gains`: robots whose sensors differ
//! drive through one maze, from which their gains are fitted, and through the other, which
//! is mapped without and with these gains, and with the true ones. The gains of a robot go
//! with its seed, in every world.

use std::error::Error;

use amiro_ipf::filter::Profile;
use amiro_ipf::model::{Gain, Photometry, SENSORS};
use amiro_ipf::node::Config;
use clap::Parser;
use sim_harness::console;
use sim_harness::drive::RingCalibration;
use sim_harness::evaluation::{MethodComparison, Metric, Trial};
use sim_harness::mapping::{Method, RingGainFit, RingGains, WallMapParameters};
use sim_harness::pipeline;
use sim_harness::rig::Rig;
use sim_harness::world::{Options, Physics, Scenario, simulate_with, standard};

/// What unequal gains of the sensors cost, and what a drive's own estimate gives back.
#[derive(Clone, Copy, Debug, Parser)]
struct Study {
    /// The first robot: the seed of its gains, noise and filter.
    #[arg(long, value_name = "N", default_value_t = 100)]
    first_seed: u64,
    /// Number of robots.
    #[arg(long, value_name = "N", default_value_t = 10)]
    robots: u64,
    /// Relative standard deviation of the gains.
    #[arg(long, value_name = "S", default_value_t = 0.12)]
    spread: f64,
    /// Particles for each sensor in use.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    particles: u16,
    /// The fits alone, without maps.
    #[arg(long)]
    fits: bool,
}

/// The methods whose maps are compared.
const METHODS: [Method; 3] = [Method::PLUS, Method::WALL, Method::WALL_MAP];

/// Errors of the logarithms of gains over all fits.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    count: f64,
    sum: f64,
    squares: f64,
    scaled_squares: f64,
}

impl Errors {
    fn take(&mut self, error: f64, sigma: f64) {
        self.count += 1.0;
        self.sum += error;
        self.squares += error * error;
        self.scaled_squares += (error / sigma).powi(2);
    }

    fn print(&self, name: &str) {
        console::print(format_args!(
            "{name}: {} fitted, mean error {:+.1} %, rms {:.1} %, {:.2} standard deviations",
            self.count,
            100.0 * self.sum / self.count,
            100.0 * (self.squares / self.count).sqrt(),
            (self.scaled_squares / self.count).sqrt(),
        ));
    }
}

impl Study {
    fn options(&self) -> Options {
        Options {
            physics: Physics::Patch,
            gain_spread: self.spread,
            ..Options::default()
        }
    }

    /// Gains as one drive gives them; with alpha known, gains alone.
    fn fitted(
        &self,
        scenario: &Scenario,
        seed: u64,
        is_alpha_known: bool,
    ) -> Result<RingGains, Box<dyn Error>> {
        let config = Config::amiro(Profile::Paper);
        let fit = RingGainFit::new(&Rig::from(&config), WallMapParameters::STANDARD);
        let mut fit = if is_alpha_known {
            fit.with_known_common()
        } else {
            fit
        };
        fit.begin_drive();
        let inputs = simulate_with(scenario, seed, &self.options()).inputs;
        pipeline::step_records(&config, &inputs, &mut |record| fit.take(record))?;
        Ok(fit.solve())
    }

    /// All methods in a world by a robot, with some calibration.
    fn trials(
        &self,
        scenario: &Scenario,
        seed: u64,
        calibration: Option<RingCalibration>,
    ) -> Result<Vec<Trial>, Box<dyn Error>> {
        let comparison = MethodComparison {
            scenarios: vec![scenario.clone()],
            methods: METHODS.to_vec(),
            seeds: seed..seed + 1,
            particles_per_sensor: self.particles,
            options: self.options(),
            alpha_counts_m2: None,
            calibration,
            footprint: false,
            threads: 1,
        };
        Ok(comparison.run()?)
    }
}

/// Alpha and gains of a configuration from ratios; a gain that is out of range is 1.
fn calibration(common: f64, ratios: impl Fn(usize) -> f64) -> RingCalibration {
    let alpha = f64::from(Photometry::VCNL4020.alpha_counts_m2);
    RingCalibration {
        alpha_counts_m2: (alpha * common) as f32,
        gains: core::array::from_fn(|n| Gain::of(ratios(n) as f32).unwrap_or(Gain::ONE)),
    }
}

fn of_fit(fit: &RingGains) -> RingCalibration {
    calibration(fit.common.ratio, |sensor| {
        let is_determined = fit.is_determined.get(sensor) == Some(&true);
        let ratio = fit.mounts.get(sensor).map(|gain| gain.ratio);
        ratio.filter(|_| is_determined).unwrap_or(1.0)
    })
}

/// Mean of a figure of a method.
fn mean(trials: &[Trial], method: Method, metric: Metric) -> f64 {
    let of_method = trials.iter().filter(|trial| trial.method == method);
    let values: Vec<f64> = of_method
        .filter_map(|trial| metric.of(&trial.scores))
        .collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn main() -> Result<(), Box<dyn Error>> {
    let study = Study::parse();
    let world = |name| standard(name).ok_or("no such world");
    let worlds = [world("msm_l")??, world("msm_t")??];
    let names = [
        "gains unknown",
        "fitted",
        "fitted, alpha known",
        "true gains",
    ];
    let (mut relative, mut common) = (Errors::default(), Errors::default());
    for (mapped, from) in [(0, 1), (1, 0)] {
        let mut all = names.map(|_| Vec::new());
        for seed in study.first_seed..study.first_seed.saturating_add(study.robots) {
            let truth = study.options().gains(seed);
            let fit = study.fitted(&worlds[from], seed, false)?;
            let known: Vec<usize> = (0..SENSORS).filter(|n| fit.is_determined[*n]).collect();
            let logs = known.iter().map(|sensor| libm::log(truth[*sensor]));
            let mean = logs.sum::<f64>() / known.len() as f64;
            for sensor in known {
                let gain = fit.mounts[sensor];
                let error = libm::log(gain.ratio) - libm::log(truth[sensor]) + mean;
                relative.take(error, gain.sigma);
            }
            common.take(libm::log(fit.common.ratio) - mean, fit.common.sigma);
            if study.fits {
                continue;
            }
            let alone = study.fitted(&worlds[from], seed, true)?;
            let calibrations = [
                None,
                Some(of_fit(&fit)),
                Some(of_fit(&alone)),
                Some(calibration(1.0, |sensor| truth[sensor])),
            ];
            for (all, calibration) in all.iter_mut().zip(calibrations) {
                all.extend(study.trials(&worlds[mapped], seed, calibration)?);
            }
        }
        let (name, other) = (&worlds[mapped].name, &worlds[from].name);
        for (trials, row) in all.iter().zip(names).filter(|(all, _)| !all.is_empty()) {
            for method in METHODS {
                console::print(format_args!(
                    "{name:<6} gains from {other:<6} {method:<9} {row:<20} OE {:5.1} %  recall {:.2}",
                    100.0 * mean(trials, method, Metric::Oe),
                    mean(trials, method, Metric::SurfaceRecall),
                ));
            }
        }
    }
    relative.print("gains relative to their mean");
    common.print("alpha");
    Ok(())
}
