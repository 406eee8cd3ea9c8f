//! In what a simulated world differs from the filter's model.

use clap::Args;
use sim_harness::world::{Drift, OdometryModel, Options, OptionsError, Physics};

/// Differences of the world from the filter's model; recorded with the scenario.
#[derive(Debug, Args)]
pub(super) struct Differences {
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
    /// Standard deviation of the sensors' gains, relative, 0 to 0.5; constant over the drive.
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
    /// wheel-errors:PERCENT:DEGREES, wheel-errors:PERCENT:DEGREES:DRIFT:SLIP (degrees per
    /// metre, percent), amiro (as on its bus), or amiro-undated (as amiro, each pose taken for
    /// current).
    #[arg(long, default_value_t, value_name = "ODOMETRY")]
    odometry: OdometryModel,
}

impl Differences {
    /// The options of the simulation.
    ///
    /// # Errors
    /// A value outside its range.
    pub(super) fn options(&self) -> Result<Options, OptionsError> {
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
        options.validate()?;
        Ok(options)
    }
}
