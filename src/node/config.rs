//! The configuration of a run: seed, robot, sensors, filter, pace.

use serde::{Deserialize, Serialize};

use crate::filter::{FilterParameters, Model, ParameterError, Profile};
use crate::math;
use crate::model::{
    DifferentialDrive, Gain, Photometry, Reading, Ring, SENSORS, Sample, SensorMask,
};

/// When the filter steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StepRule {
    /// A step per travelled distance: the paper's constant sample-per-speed ratio
    /// (equation 1). 10 mm are 8 Hz at 80 mm/s; at standstill and while turning in
    /// place the particles move, but nothing steps.
    PerDistance {
        /// Distance between steps, metres.
        step_m: f32,
    },
    /// One step per tick, moving or not. At standstill this finds walls in
    /// the sensors' noise, as the paper warns.
    PerTick {
        /// Whether the board makes the ticks, at 8 Hz of its own clock; otherwise
        /// they come in with the other inputs, and the run is exactly repeatable.
        own_clock: bool,
    },
}

/// Which of a sensor's samples since the step before a step consumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SampleSelection {
    /// The newest one, if it is not too old.
    Newest,
    /// The median of the last fifteen: up to seven spikes among them change nothing,
    /// but the value lags by half their time, 5 mm at 80 mm/s.
    Median,
}

/// Who reads the sensors and the odometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Source {
    /// A host sends them over the link; what the board reads itself is left out.
    Link,
    /// The board reads its own; a host's are refused.
    Board,
}

/// Everything that a run depends on beside its readings.
///
/// It travels in one frame: a recording that begins with its configuration replays
/// itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Seed of the generator; any value.
    pub seed: u64,
    /// Particles for each sensor in use.
    pub particles_per_sensor: u16,
    /// The sensors in use; the others are as if absent.
    pub sensors: SensorMask,
    /// When the filter steps.
    pub step_rule: StepRule,
    /// The filter's choices.
    pub parameters: FilterParameters,
    /// The sensors' law.
    pub photometry: Photometry,
    /// Where the sensors sit.
    pub ring: Ring,
    /// The wheels' geometry.
    pub drive: DifferentialDrive,
    /// Which samples a step consumes.
    pub choice: SampleSelection,
    /// Who reads the sensors and the odometry; nothing to the filter.
    pub source: Source,
    /// Gain of each sensor relative to the law's alpha.
    pub gains: [Gain; SENSORS],
}

impl Config {
    /// The AMiRo with the given profile: whole ring, 1000 particles a sensor, a step
    /// per 10 mm, the newest samples, from the link, seed 1.
    #[must_use]
    pub const fn amiro(profile: Profile) -> Self {
        Self {
            seed: 1,
            particles_per_sensor: 1000,
            sensors: SensorMask::ALL,
            step_rule: StepRule::PerDistance { step_m: 0.010 },
            parameters: profile.parameters(),
            photometry: Photometry::VCNL4020,
            ring: Ring::AMIRO,
            drive: DifferentialDrive::AMIRO,
            choice: SampleSelection::Newest,
            source: Source::Link,
            gains: [Gain::ONE; SENSORS],
        }
    }

    /// Particles in total.
    #[must_use]
    pub const fn particles(&self) -> usize {
        self.particles_per_sensor as usize * self.sensors.len()
    }

    /// The model that this configuration describes.
    #[must_use]
    pub fn model(&self) -> Model {
        Model::new(self.parameters, self.photometry, &self.ring, self.drive)
    }

    /// The readings of samples, each by the law of its own sensor.
    #[must_use]
    pub fn readings(&self, samples: &[Sample; SENSORS]) -> [Reading; SENSORS] {
        let mut readings = [Reading::Faulty; SENSORS];
        let sensors = samples.iter().zip(&self.gains);
        for (reading, (sample, gain)) in readings.iter_mut().zip(sensors) {
            *reading = self.photometry.with_gain(*gain).read(*sample);
        }
        readings
    }

    /// The samples as sensors with a gain of 1 would have delivered them, to a whole count;
    /// those of a gain of 1 are unchanged.
    #[must_use]
    pub fn samples_at_gain_one(&self, samples: &[Sample; SENSORS]) -> [Sample; SENSORS] {
        let beta_counts = self.photometry.beta_counts;
        let mut normalised = *samples;
        for (sample, gain) in normalised.iter_mut().zip(&self.gains) {
            if let Sample::Counts(counts) = sample
                && *gain != Gain::ONE
            {
                let signal = (*counts as f32 - beta_counts) / gain.ratio();
                *counts = math::round_to_i32(signal + beta_counts);
            }
        }
        normalised
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// The first parameter that is outside its range, NaN included.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let unless = ParameterError::unless;
        unless(
            self.particles_per_sensor >= 1,
            "particles_per_sensor",
            "at least 1",
        )?;
        unless(
            !self.sensors.is_empty(),
            "sensors",
            "at least one of the ring",
        )?;
        if let StepRule::PerDistance { step_m } = self.step_rule {
            unless((0.001..=0.1).contains(&step_m), "step_m", "0.001 to 0.1 m")?;
        }
        self.parameters.validate()?;
        validate_photometry(&self.photometry)?;
        unless(
            (0.0..=0.25).contains(&self.ring.radius_m),
            "ring radius_m",
            "0 to 0.25 m",
        )?;
        unless(
            self.ring.axis_rad.iter().all(|axis| axis.abs() <= 7.0),
            "ring axis_rad",
            "-7 to 7 rad",
        )?;
        unless(
            (0.01..=1.0).contains(&self.drive.track_m),
            "track_m",
            "0.01 to 1 m",
        )?;
        let are_legal = self.gains.iter().all(|gain| gain.is_legal());
        unless(are_legal, "gains", "0.25 to 4")
    }
}

/// Checks the ranges of a sensor law's constants.
fn validate_photometry(photometry: &Photometry) -> Result<(), ParameterError> {
    let unless = ParameterError::unless;
    unless(
        (0.001..=100.0).contains(&photometry.alpha_counts_m2),
        "alpha_counts_m2",
        "0.001 to 100 counts m^2",
    )?;
    unless(
        (-5000.0..=5000.0).contains(&photometry.beta_counts),
        "beta_counts",
        "-5000 to 5000 counts",
    )?;
    unless(
        (-0.01..=0.01).contains(&photometry.delta_m2),
        "delta_m2",
        "-0.01 to 0.01 m^2",
    )?;
    unless((0.5..=1.45).contains(&photometry.xi), "xi", "0.5 to 1.45")?;
    unless(
        photometry.sigma_counts > 0.0 && photometry.sigma_counts <= 1000.0,
        "sigma_counts",
        "above 0, to 1000 counts",
    )?;
    unless(
        (0.02..=0.45).contains(&photometry.x_max_m),
        "x_max_m",
        "0.02 to 0.45 m",
    )?;
    unless(
        (0.1..=1.05).contains(&photometry.theta_max_rad),
        "theta_max_rad",
        "0.1 to 1.05 rad",
    )
}

impl Default for Config {
    fn default() -> Self {
        Self::amiro(Profile::Paper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_legal_and_use_eight_thousand_particles() {
        assert_eq!(Config::default().validate(), Ok(()));
        assert_eq!(Config::default().particles(), 8000);
    }

    #[test]
    fn a_gain_moves_the_range_of_its_sensor_alone_and_a_gain_of_one_changes_no_bit() {
        let good = Config::default();
        let mut config = good;
        config.gains[2] = Gain::of(1.21).unwrap();
        for counts in [-30, 8, 40, 110, 361, 5000] {
            let samples = [Sample::Counts(counts); SENSORS];
            let plain = good.readings(&samples);
            assert_eq!(plain, samples.map(|sample| good.photometry.read(sample)));
            let gained = config.readings(&samples);
            for (sensor, (one, other)) in plain.iter().zip(&gained).enumerate() {
                if sensor != 2 {
                    assert_eq!(one, other);
                } else if let (Reading::Range(one), Reading::Range(other)) = (one, other) {
                    // The same counts come from sqrt(1.21) times as far.
                    assert!((other.range_m / one.range_m - 1.1).abs() < 1e-4);
                }
            }
        }
        // The limit is the same range for every sensor.
        let dark = config.readings(&[Sample::Counts(-16); SENSORS]);
        for reading in dark {
            let Reading::NothingInRange(limit) = reading else {
                unreachable!("{reading:?}");
            };
            assert!((limit.range_m - config.photometry.x_max_m).abs() < 1e-6);
        }
    }

    #[test]
    fn every_field_out_of_range_is_refused_by_name() {
        let good = Config::default();
        let photometry = |change: fn(&mut Photometry)| {
            let mut config = good;
            change(&mut config.photometry);
            config
        };
        let cases = [
            (
                Config {
                    particles_per_sensor: 0,
                    ..good
                },
                "particles_per_sensor",
            ),
            (
                Config {
                    sensors: SensorMask::NONE,
                    ..good
                },
                "sensors",
            ),
            (
                Config {
                    step_rule: StepRule::PerDistance { step_m: 0.0 },
                    ..good
                },
                "step_m",
            ),
            (photometry(|p| p.alpha_counts_m2 = 0.0), "alpha_counts_m2"),
            (photometry(|p| p.beta_counts = f32::INFINITY), "beta_counts"),
            (photometry(|p| p.delta_m2 = 1.0), "delta_m2"),
            (photometry(|p| p.xi = 1.6), "xi"),
            (photometry(|p| p.sigma_counts = 0.0), "sigma_counts"),
            (photometry(|p| p.x_max_m = f32::NAN), "x_max_m"),
            (photometry(|p| p.theta_max_rad = 2.0), "theta_max_rad"),
            (
                Config {
                    ring: Ring {
                        radius_m: -0.1,
                        ..Ring::AMIRO
                    },
                    ..good
                },
                "ring radius_m",
            ),
            (
                Config {
                    ring: Ring {
                        axis_rad: [f32::NAN; 8],
                        ..Ring::AMIRO
                    },
                    ..good
                },
                "ring axis_rad",
            ),
            (
                Config {
                    drive: DifferentialDrive { track_m: 0.0 },
                    ..good
                },
                "track_m",
            ),
            (
                Config {
                    gains: [Gain::from_code(0); SENSORS],
                    ..good
                },
                "gains",
            ),
        ];
        for (config, parameter) in cases {
            assert_eq!(config.validate().unwrap_err().parameter, parameter);
        }
    }
}
