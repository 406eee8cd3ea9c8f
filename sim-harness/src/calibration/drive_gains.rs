//! Gains of the sensors of a ring from recorded drives.

use std::fmt;
use std::path::{Path, PathBuf};

use amiro_ipf::model::{Gain, SENSORS, SensorMask};
use amiro_ipf::node::Config;

use super::GainFile;
use crate::drive::{InputCheck, NoSteps, StepRecords, replayed_config};
use crate::escape::whole_escaped;
use crate::log::{LogError, StoredRecording};
use crate::mapping::{RingGainFit, RingGains, WallMapParameters};
use crate::rig::Rig;

/// What recorded drives are read with.
#[derive(Clone, Copy, Debug, Default)]
pub struct DriveGainSettings {
    /// Sensors that are left out, in all drives.
    pub masked: SensorMask,
    /// Alpha, counts m^2, if it is known; else it is fitted, beginning with that of the
    /// first recording.
    pub alpha_counts_m2: Option<f32>,
}

/// Gains of the sensors of a ring, with the recordings that they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveGains {
    /// Alpha that the gains are relative to, counts m^2: the one to begin with.
    pub first_alpha_counts_m2: f64,
    /// The gains.
    pub ring: RingGains,
    /// Names of the recordings.
    pub sources: Vec<String>,
}

/// Why drives give no gains.
#[derive(Debug, thiserror::Error)]
pub enum DriveGainError {
    /// A recording cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A recording has no steps.
    #[error("{file}: {reason}")]
    NoSteps {
        /// The file's name, escaped.
        file: String,
        /// Why.
        reason: NoSteps,
    },
    /// A recording is of another ring or another lobe than the first.
    #[error("{file}: its ring of sensors or their lobe is not that of the first recording")]
    OtherRing {
        /// The file's name, escaped.
        file: String,
    },
    /// A value of the configuration is illegal.
    #[error("{0}")]
    Config(String),
}

impl DriveGains {
    /// Fits gains to recordings of either format.
    ///
    /// The signals are counts above each recording's own beta. All recordings are of the
    /// same robot beside surfaces of the same kind.
    ///
    /// # Errors
    /// [`DriveGainError`] for the first recording that cannot be used.
    pub fn of(paths: &[PathBuf], settings: DriveGainSettings) -> Result<Self, DriveGainError> {
        let mut fit: Option<(Config, RingGainFit)> = None;
        for path in paths {
            let file = || whole_escaped(path.to_string_lossy().chars());
            let mut recording = StoredRecording::open(path, |_, _| {})?;
            let config = configured(recording.overview().config, settings)?;
            let (first, fit) = fit.get_or_insert_with(|| {
                let rig = Rig::from(&config);
                let fit = RingGainFit::new(&rig, WallMapParameters::STANDARD);
                let is_known = settings.alpha_counts_m2.is_some();
                (
                    config,
                    if is_known {
                        fit.with_known_common()
                    } else {
                        fit
                    },
                )
            });
            if !is_same_ring(first, &config) {
                return Err(DriveGainError::OtherRing { file: file() });
            }
            fit.begin_drive();
            if let Some(reason) = read(&mut recording, config, fit)? {
                return Err(DriveGainError::NoSteps {
                    file: file(),
                    reason,
                });
            }
        }
        let (first, fit) = fit.ok_or_else(|| DriveGainError::Config("no recording".to_owned()))?;
        Ok(Self {
            first_alpha_counts_m2: f64::from(first.photometry.alpha_counts_m2),
            ring: fit.solve(),
            sources: paths.iter().map(|path| name(path)).collect(),
        })
    }

    /// Alpha as the drives give it, counts m^2.
    #[must_use]
    pub fn alpha_counts_m2(&self) -> f64 {
        self.first_alpha_counts_m2 * self.ring.common.ratio
    }

    /// What a file says: alpha and gains, those to begin with where the drives determine
    /// none, with an infinite deviation.
    #[must_use]
    pub fn file(&self) -> GainFile {
        let alpha_counts_m2 = if self.ring.is_common_determined() {
            self.alpha_counts_m2()
        } else {
            self.first_alpha_counts_m2
        };
        let mut file = GainFile {
            alpha_counts_m2,
            alpha_sigma_counts_m2: if self.ring.is_common_determined() {
                alpha_counts_m2 * self.ring.common.sigma
            } else {
                f64::INFINITY
            },
            gains: [1.0; SENSORS],
            gain_sigmas: [f64::INFINITY; SENSORS],
            sources: self.sources.clone(),
        };
        let slots = file.gains.iter_mut().zip(&mut file.gain_sigmas);
        let found = self.ring.mounts.iter().zip(&self.ring.is_determined);
        for ((gain, sigma), (found, is_determined)) in slots.zip(found) {
            if *is_determined {
                *sigma = found.sigma;
                *gain = found.ratio;
            }
        }
        file
    }
}

/// The configuration that a recording is read with.
fn configured(
    recorded: Option<Config>,
    settings: DriveGainSettings,
) -> Result<Config, DriveGainError> {
    let mut config = replayed_config(recorded.unwrap_or_default());
    // Gains are relative to the law, whatever the recorded ones are.
    config.gains = [Gain::ONE; SENSORS];
    config.sensors = SensorMask(config.sensors.0 & settings.masked.complement().0);
    if let Some(alpha) = settings.alpha_counts_m2 {
        config.photometry.alpha_counts_m2 = alpha;
    }
    let refused = |error| DriveGainError::Config(format!("{error}"));
    config.validate().map_err(refused)?;
    Ok(config)
}

/// Whether two configurations have the same sensors in the same places; gain, dark value
/// and noise may differ.
fn is_same_ring(one: &Config, other: &Config) -> bool {
    let lobe = |config: &Config| {
        let photometry = &config.photometry;
        [photometry.xi, photometry.theta_max_rad].map(f32::to_bits)
    };
    one.ring == other.ring && lobe(one) == lobe(other)
}

/// Passes the steps of a recording to the fit; why there are none.
fn read(
    recording: &mut StoredRecording,
    config: Config,
    fit: &mut RingGainFit,
) -> Result<Option<NoSteps>, DriveGainError> {
    let mut steps = StepRecords::new(config);
    let mut check = InputCheck::default();
    let mut rows = recording.inputs(|_| {})?;
    let mut refused = crate::RunOutcome::default();
    for input in rows.by_ref() {
        check.take(&input);
        if let Err(fault) = steps.take(&input, &mut |record| fit.take(record)) {
            refused.count(fault);
        }
    }
    rows.finish()?;
    Ok(check.finish(&config, steps.steps().into(), refused.faults()))
}

/// The name of a file without its folder, or what there is.
fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// The table of gains.
impl fmt::Display for DriveGains {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ring = &self.ring;
        let lit: usize = ring.lit.iter().sum();
        writeln!(
            f,
            "{} drives, {} walls, {lit} lit readings, chi^2 per reading {:.2}",
            self.sources.len(),
            ring.walls.iter().sum::<usize>(),
            ring.chi2_per_reading,
        )?;
        writeln!(
            f,
            "by the law of extended surfaces: walls, not small objects"
        )?;
        let (alpha, sigma) = (self.alpha_counts_m2(), ring.common.sigma);
        write!(f, "alpha     {alpha:.4} +- {:.4} counts m^2", alpha * sigma)?;
        if ring.is_common_known() {
            writeln!(f, "  given")?;
        } else if ring.is_common_determined() {
            writeln!(f)?;
        } else {
            let first = self.first_alpha_counts_m2;
            writeln!(f, "  not determined: stays {first:.4}; give --alpha")?;
        }
        for (sensor, gain) in ring.mounts.iter().enumerate() {
            let lit = ring.lit.get(sensor).copied().unwrap_or(0);
            let (ratio, sigma) = (gain.ratio, gain.ratio * gain.sigma);
            write!(
                f,
                "sensor {sensor}  {ratio:.4} +- {sigma:.4}  {lit:6} lit readings"
            )?;
            let is_determined = ring.is_determined.get(sensor) == Some(&true);
            writeln!(
                f,
                "{}",
                if is_determined {
                    ""
                } else {
                    "  not determined: stays 1"
                }
            )?;
        }
        writeln!(
            f,
            "Gains are relative to alpha. Standard deviations are those of the fit; errors of \
             the law,\nsuch as in the near field, are not in them. Determined: within {:.0} % \
             for a gain, {:.0} % for alpha;\nchi^2 per reading up to {:.0} and {:.0}.",
            100.0 * RingGains::LARGEST_SIGMA,
            100.0 * RingGains::LARGEST_COMMON_SIGMA,
            RingGains::LARGEST_GAIN_CHI2,
            RingGains::LARGEST_CHI2,
        )
    }
}
