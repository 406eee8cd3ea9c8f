//! The settings of a run that the command line may override.

use std::path::{Path, PathBuf};

use amiro_ipf::filter::{ParameterError, Profile};
use amiro_ipf::model::{SENSORS, SensorMask};
use amiro_ipf::node::{Config, StepRule};
use clap::{Args, ValueEnum};

use super::arguments;

/// The filters that ship.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ProfileName {
    /// The faithful filter of the paper.
    Paper,
    /// Ours: Bernoulli survival, side test, veto.
    Plus,
    /// Particles weighed against tracked wall segments, for real walls.
    Wall,
    /// Readings as upper bounds, without wall segments.
    Arcs,
}

impl From<ProfileName> for Profile {
    fn from(name: ProfileName) -> Self {
        match name {
            ProfileName::Paper => Self::Paper,
            ProfileName::Plus => Self::Plus,
            ProfileName::Wall => Self::Wall,
            ProfileName::Arcs => Self::Arcs,
        }
    }
}

/// Overrides of a configuration; what is not given stays as recorded, or at its default.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct Overrides {
    /// The filter's profile.
    #[arg(long, value_enum)]
    profile: Option<ProfileName>,
    /// Seed of the filter's random numbers.
    #[arg(long, value_name = "N", value_parser = arguments::seed)]
    seed: Option<u64>,
    /// Particles for each sensor in use.
    #[arg(long, value_name = "N")]
    particles: Option<u16>,
    /// Range limit of the sensors, metres.
    #[arg(long, value_name = "M")]
    x_max: Option<f32>,
    /// Gain of sensor and surface (alpha), counts m^2.
    #[arg(long, value_name = "A")]
    alpha: Option<f32>,
    /// Alpha and gains of the sensors, as `calibrate --from-drive` writes them; --alpha wins.
    #[arg(long, value_name = "FILE")]
    gains: Option<PathBuf>,
    /// Sensors to leave out, by index: those that see something else, such as a guide robot.
    #[arg(long, value_name = "I,J", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(0..SENSORS as i64))]
    mask: Vec<u8>,
    /// Step at a fixed 8 Hz instead of every 10 mm.
    #[arg(long)]
    fixed: bool,
}

impl Overrides {
    /// The file of --gains.
    pub(super) fn gains(&self) -> Option<&Path> {
        self.gains.as_deref()
    }

    /// Whether nothing is overridden.
    pub(super) fn are_default(&self) -> bool {
        self.profile.is_none()
            && self.seed.is_none()
            && self.particles.is_none()
            && self.x_max.is_none()
            && self.alpha.is_none()
            && self.gains.is_none()
            && self.mask.is_empty()
            && !self.fixed
    }

    /// Whether the filter steps at a fixed rate.
    pub(super) fn fixed(&self) -> bool {
        self.fixed
    }

    /// The option that set a parameter, if one is given; a recorded one has none.
    fn option_of(&self, parameter: &str) -> Option<&'static str> {
        arguments::option_of(parameter).filter(|option| match *option {
            "--particles" => self.particles.is_some(),
            "--mask" => !self.mask.is_empty(),
            "--alpha" => self.alpha.is_some(),
            _ => self.x_max.is_some(),
        })
    }

    /// The recorded configuration, or the AMiRo's, with the overrides.
    pub(super) fn apply(&self, recorded: Option<Config>) -> Result<Config, String> {
        let mut config = recorded.unwrap_or_default();
        if let Some(profile) = self.profile {
            config.parameters = Profile::from(profile).parameters();
        }
        config.seed = self.seed.unwrap_or(config.seed);
        config.particles_per_sensor = self.particles.unwrap_or(config.particles_per_sensor);
        config.photometry.x_max_m = self.x_max.unwrap_or(config.photometry.x_max_m);
        if let Some(calibration) = arguments::calibration(self.gains.as_deref())? {
            calibration.apply(&mut config);
        }
        config.photometry.alpha_counts_m2 = self.alpha.unwrap_or(config.photometry.alpha_counts_m2);
        let masked: SensorMask = self
            .mask
            .iter()
            .map(|sensor| usize::from(*sensor))
            .collect();
        config.sensors = SensorMask(config.sensors.0 & masked.complement().0);
        if self.fixed {
            config.step_rule = StepRule::PerTick { own_clock: false };
        }
        let named = |error: ParameterError| match self.option_of(error.parameter) {
            Some(option) => format!("{option}: {error}"),
            None => error.to_string(),
        };
        config.validate().map_err(named)?;
        Ok(config)
    }
}
