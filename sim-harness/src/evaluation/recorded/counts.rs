//! Counts that the simulator expects of the stations, against those recorded there.

use amiro_ipf::model::{Photometry, Ring, SENSORS, Sample};
use amiro_ipf::random::Generator;
use serde::Serialize;

use super::error::NoAlpha;
use super::series::{Series, Station};
use crate::calibration::{Fixed, Parameter, Table, fit};
use crate::world::{Physics, Sensing, SensorPose, Turn, first_surface};

/// Least counts for a meaningful ratio: four times the sensors' noise.
const LEAST_COUNTS: f64 = 20.0;
/// A gain for comparing shapes, counts m^2: much, so that whole counts do not matter.
const TRIAL_GAIN: f32 = 10.0;
/// Seed of the simulated readings' noise.
const NOISE_SEED: u64 = 1;

/// How the simulator's counts for one sensor differ from the recorded ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SensorError {
    /// Index on the ring; `None` for all sensors together.
    pub sensor: Option<usize>,
    /// Readings compared.
    pub rows: usize,
    /// RMS of expected less recorded, counts.
    pub rms_counts: f64,
    /// Readings of which both sides are at least 20 counts.
    pub lit_rows: usize,
    /// Mean of ln(expected / recorded) over those; above 0 expects too much.
    pub mean_log_ratio: Option<f64>,
    /// RMS of ln(expected / recorded) over those.
    pub rms_log_ratio: Option<f64>,
}

/// Pairs of expected and recorded counts of some sensor.
type Pairs = Vec<(f64, f64)>;

/// Expected and recorded counts by sensor.
#[derive(Clone, Debug)]
pub(super) struct CountComparison {
    pairs: [Pairs; SENSORS],
}

impl CountComparison {
    /// Expects what the simulator's sensing gives without noise, clipped at 0 as the
    /// recorder did.
    pub(super) fn of(series: &[Series], photometry: &Photometry, physics: Physics) -> Self {
        let mut pairs = [const { Vec::new() }; SENSORS];
        for series in series {
            for (station, expected) in expected(series, photometry, physics) {
                let both = expected.into_iter().zip(station.samples);
                for (pairs, (expected, recorded)) in pairs.iter_mut().zip(both) {
                    if let (Some(expected), Some(recorded)) = (number(expected), number(recorded)) {
                        pairs.push((expected.max(0.0), recorded));
                    }
                }
            }
        }
        Self { pairs }
    }

    /// The errors of the sensors that were compared.
    pub(super) fn sensors(&self) -> Vec<SensorError> {
        let all = self.pairs.iter().enumerate();
        all.filter(|(_, pairs)| !pairs.is_empty())
            .map(|(sensor, pairs)| SensorError::of(Some(sensor), pairs))
            .collect()
    }

    /// The errors of all of them together.
    pub(super) fn together(&self) -> SensorError {
        let all: Pairs = self.pairs.iter().flatten().copied().collect();
        SensorError::of(None, &all)
    }
}

impl SensorError {
    fn of(sensor: Option<usize>, pairs: &[(f64, f64)]) -> Self {
        let differences: Vec<f64> = pairs
            .iter()
            .map(|(expected, recorded)| expected - recorded)
            .collect();
        let ratios: Vec<f64> = pairs
            .iter()
            .filter(|(expected, recorded)| expected.min(*recorded) >= LEAST_COUNTS)
            .map(|(expected, recorded)| (expected / recorded).ln())
            .collect();
        let mean = |sum: f64, count: usize| (count > 0).then(|| sum / count as f64);
        let squares = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        Self {
            sensor,
            rows: pairs.len(),
            rms_counts: mean(squares(&differences), pairs.len()).map_or(0.0, f64::sqrt),
            lit_rows: ratios.len(),
            mean_log_ratio: mean(ratios.iter().sum(), ratios.len()),
            rms_log_ratio: mean(squares(&ratios), ratios.len()).map(f64::sqrt),
        }
    }
}

/// Counts of a sample; `None` for none and for a full register.
fn number(sample: Sample) -> Option<f64> {
    match sample {
        Sample::Counts(counts) => Some(f64::from(counts)),
        Sample::Saturated | Sample::Missing => None,
    }
}

fn expected<'s>(
    series: &'s Series,
    photometry: &Photometry,
    physics: Physics,
) -> impl Iterator<Item = (&'s Station, [Sample; SENSORS])> {
    let silent = Photometry {
        sigma_counts: 0.0,
        ..*photometry
    };
    let noise = Generator::seeded(0);
    let mut sensing = Sensing::new(Ring::AMIRO, series.used, silent, physics, noise);
    series.stations.iter().map(move |station| {
        let samples = sensing.sample(&series.shapes, &station.pose, 0.0);
        (station, samples)
    })
}

/// The series as the simulator reads it, with the law's noise and clipped at 0 as the
/// recorder did.
pub(super) fn simulated(series: &Series, law: &Photometry, physics: Physics) -> Series {
    let noise = Generator::seeded(NOISE_SEED);
    let mut sensing = Sensing::new(Ring::AMIRO, series.used, *law, physics, noise);
    let mut simulated = series.clone();
    simulated.readings = match physics {
        Physics::Matched => "matched",
        Physics::Patch => "patch",
    };
    for station in &mut simulated.stations {
        let samples = sensing.sample(&series.shapes, &station.pose, 0.0);
        station.samples = samples.map(|sample| match sample {
            Sample::Counts(counts) => Sample::Counts(counts.max(0)),
            other => other,
        });
    }
    simulated
}

/// The sensors of a station that have a wall's face abeam.
fn abeam(series: &Series, station: &Station) -> impl Iterator<Item = SensorPose> {
    SensorPose::of(&Ring::AMIRO, series.used, &station.pose)
        .filter(|sensor_pose| series.faces.iter().any(|face| face.is_abeam(sensor_pose)))
}

/// Counts of one of a station's sensors.
fn reading(samples: &[Sample; SENSORS], sensor_pose: &SensorPose) -> Option<f64> {
    samples.get(sensor_pose.sensor).copied().and_then(number)
}

/// Alpha for which the law explains the readings abeam, everything else held: a row a
/// reading, range and bearing those of the strongest return, where the reading's arc
/// touches the face.
pub(super) fn matched_alpha(series: &Series, law: &Photometry) -> Result<f64, NoAlpha> {
    let mut text = "range_m,angle_rad,counts\n".to_owned();
    for station in &series.stations {
        for sensor_pose in abeam(series, station) {
            let counts = reading(&station.samples, &sensor_pose);
            let strongest = strongest(series, law, &sensor_pose);
            if let (Some(counts), Some((range, bearing))) = (counts, strongest) {
                text += &format!("{range},{bearing},{counts}\n");
            }
        }
    }
    let held = [Parameter::Beta, Parameter::Xi, Parameter::Delta];
    let fixed = held.into_iter().try_fold(Fixed::default(), |fixed, held| {
        fixed.with(held, held.of(law))
    })?;
    Ok(fit(&Table::parse(&text)?, &fixed)?.value(Parameter::Alpha))
}

/// Range and bearing of the strongest return, as the law has it.
fn strongest(series: &Series, law: &Photometry, sensor_pose: &SensorPose) -> Option<(f64, f64)> {
    let returns = (-60_i16..=60).filter_map(|degrees| {
        let bearing = f64::from(degrees).to_radians();
        let direction = Turn::by_degrees(f64::from(degrees))
            .after(sensor_pose.axis)
            .direction();
        let (range, _) = first_surface(&series.shapes, sensor_pose.position, direction)?;
        Some((
            f64::from(law.counts(range as f32, bearing as f32)?),
            range,
            bearing,
        ))
    });
    returns
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, range, bearing)| (range, bearing))
}

/// Alpha for which a physics explains the same readings, by least squares: its
/// counts above beta are proportional to alpha.
pub(super) fn alpha_under(series: &Series, law: &Photometry, physics: Physics) -> Option<f64> {
    let trial = Photometry {
        alpha_counts_m2: TRIAL_GAIN,
        ..*law
    };
    let beta = f64::from(law.beta_counts);
    let (mut both, mut squares) = (0.0, 0.0);
    for (station, expected) in expected(series, &trial, physics) {
        for sensor_pose in abeam(series, station) {
            let counts = reading(&station.samples, &sensor_pose);
            let shaped = reading(&expected, &sensor_pose);
            if let (Some(counts), Some(shaped)) = (counts, shaped) {
                let share = (shaped - beta) / f64::from(TRIAL_GAIN);
                both += share * (counts - beta);
                squares += share * share;
            }
        }
    }
    (squares > 0.0).then(|| both / squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_of_simulated_stations_is_found_again() {
        let law = Photometry {
            alpha_counts_m2: 1.5,
            sigma_counts: 0.0,
            ..Photometry::VCNL4020
        };
        let matched = simulated(&Series::blank(), &law, Physics::Matched);
        // Some 2500 counts, each rounded to whole ones, and bearings in whole degrees.
        let found = matched_alpha(&matched, &Photometry::VCNL4020).unwrap();
        assert!((found / 1.5 - 1.0).abs() < 1e-3, "{found}");
        for physics in [Physics::Matched, Physics::Patch] {
            let series = simulated(&Series::blank(), &law, physics);
            let found = alpha_under(&series, &law, physics).unwrap();
            assert!((found / 1.5 - 1.0).abs() < 1e-3, "{physics}: {found}");
            let together = CountComparison::of(&[series], &law, physics).together();
            assert!(together.rms_counts < 1e-9, "{physics}: {together:?}");
        }
    }
}
