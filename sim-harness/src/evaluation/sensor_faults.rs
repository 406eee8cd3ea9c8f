//! The effect of a broken sensor on a map.

use core::fmt;
use core::ops::Range;

use amiro_ipf::filter::Profile;
use amiro_ipf::model::SENSORS;
use amiro_ipf::node::{Config, Input};
use rayon::prelude::*;

use super::{MeanStd, Number, Scores, Truth};
use crate::faults::{ActiveFaults, Component, Kind};
use crate::mapping::{Mapper, Method, Setup};
use crate::rig::Rig;
use crate::robot::{Robot, RobotDrive, drive};
use crate::world::{Drive, Options, Physics, Scenario};
use crate::{RunError, pipeline};

/// How one sensor is broken from some time of a drive on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorBreak {
    /// Unplugged.
    Dead,
    /// Its register is full.
    Saturated,
    /// It repeats the same value.
    Stuck,
}

impl SensorBreak {
    /// All breaks.
    pub const ALL: [Self; 3] = [Self::Dead, Self::Saturated, Self::Stuck];

    /// The most overall error that it may cost, as a share.
    #[must_use]
    pub const fn most_loss(self) -> f64 {
        match self {
            Self::Dead | Self::Stuck => 0.03,
            Self::Saturated => 0.02,
        }
    }

    /// The kind of fault.
    #[must_use]
    pub const fn kind(self) -> Kind {
        match self {
            Self::Dead => Kind::Off,
            Self::Saturated => Kind::Saturated,
            Self::Stuck => Kind::Stuck,
        }
    }
}

impl fmt::Display for SensorBreak {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Dead => "dead",
            Self::Saturated => "saturated",
            Self::Stuck => "stuck",
        })
    }
}

/// Drives of a robot, each without a fault and with every break of one sensor.
///
/// The sensor depends on the seed: eight seeds in a row break each sensor once.
#[derive(Clone, Debug)]
pub struct SensorFaultTrials {
    /// The worlds and drives.
    pub scenarios: Vec<Scenario>,
    /// Rule of the signal.
    pub physics: Physics,
    /// Seeds of noise, clocks and filters; the end is excluded.
    pub seeds: Range<u64>,
    /// When the sensor breaks, as a share of the drive's time.
    pub breaks_at: f64,
    /// The methods.
    pub methods: Vec<Method>,
    /// Particles for each sensor in use.
    pub particles_per_sensor: u16,
}

/// One scenario and method, with one break or none: statistics over the seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorFaultRow {
    /// The scenario's name.
    pub scenario: String,
    /// The method.
    pub method: Method,
    /// The break; `None` for no fault.
    pub sensor_break: Option<SensorBreak>,
    /// Overall error at the best wall expansion.
    pub oe: MeanStd,
    /// Overall error without wall expansion.
    pub oe_unexpanded: MeanStd,
    /// True positive rate.
    pub tpr: MeanStd,
    /// False positive rate.
    pub fpr: MeanStd,
    /// Share of the visible surface that is found.
    pub surface_recall: MeanStd,
    /// Share of the visible free space that is classified.
    pub coverage: MeanStd,
    /// Overall error less that of the same drive without a break.
    pub loss: MeanStd,
    /// The largest of these, and its seed.
    pub worst: Option<(f64, u64)>,
}

impl SensorFaultRow {
    /// Whether no drive loses more than the break's limit.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.sensor_break.is_none_or(|sensor_break| {
            let most = sensor_break.most_loss();
            self.worst.is_some_and(|(loss, _)| loss <= most)
        })
    }
}

/// Scores of one drive by break; the first is without.
type BreakScores = [Scores; 1 + SensorBreak::ALL.len()];

impl SensorFaultTrials {
    /// Drives and maps everything: by scenario, then method, then break.
    ///
    /// # Errors
    /// A filter did not run.
    pub fn run(&self) -> Result<Vec<SensorFaultRow>, RunError> {
        let mut rows = Vec::new();
        for scenario in &self.scenarios {
            let seeds: Vec<u64> = self.seeds.clone().collect();
            let drives: Result<Vec<_>, RunError> = seeds
                .par_iter()
                .map(|seed| self.scores(scenario, *seed))
                .collect();
            let drives = drives?;
            for (place, method) in self.methods.iter().enumerate() {
                let of_method = drives.iter().filter_map(|drive| drive.get(place).copied());
                let of_method: Vec<BreakScores> = of_method.collect();
                let troubles = [None].into_iter().chain(SensorBreak::ALL.map(Some));
                rows.extend(troubles.enumerate().map(|(column, sensor_break)| {
                    row(scenario, *method, sensor_break, &seeds, column, &of_method)
                }));
            }
        }
        Ok(rows)
    }

    fn scores(&self, scenario: &Scenario, seed: u64) -> Result<Vec<BreakScores>, RunError> {
        let from_us = (self.breaks_at * Drive::of(scenario).end_us() as f64) as u64;
        let component = Component::Sensor((seed % SENSORS as u64) as usize);
        let options = Options {
            physics: self.physics,
            ..Options::default()
        };
        let driven = |faults| drive(Robot::new(scenario, seed, &options, faults));
        let sound = driven(ActiveFaults::none());
        let broken = SensorBreak::ALL
            .map(|broken| driven(ActiveFaults::none().from(from_us, component, broken.kind())));
        let of_method = |method: &Method| -> Result<BreakScores, RunError> {
            let config = Config {
                seed,
                particles_per_sensor: self.particles_per_sensor,
                ..scenario.config(method.profile.unwrap_or(Profile::Paper))
            };
            let judged = |whole: &RobotDrive| judged(scenario, method, &config, &whole.inputs());
            let [dead, saturated, stuck] = &broken;
            Ok([
                judged(&sound)?,
                judged(dead)?,
                judged(saturated)?,
                judged(stuck)?,
            ])
        };
        self.methods.iter().map(of_method).collect()
    }
}

/// The scores of a method's map of a drive; visibility is from the poses of the steps.
fn judged(
    scenario: &Scenario,
    method: &Method,
    config: &Config,
    inputs: &[Input],
) -> Result<Scores, RunError> {
    let mut mapper = method.mapper(&Setup {
        extent: Some(scenario.extent),
        ..Setup::new(&Rig::from(config), scenario.cell_m)
    });
    let mut poses = Vec::new();
    pipeline::run(
        |take| pipeline::records(method, config, inputs, take),
        &mut mapper,
        &mut |record, _| poses.extend(record.pose()),
    )?;
    Ok(Scores::of(&mapper.map(), &Truth::of(scenario, &poses)))
}

fn row(
    scenario: &Scenario,
    method: Method,
    sensor_break: Option<SensorBreak>,
    seeds: &[u64],
    column: usize,
    drives: &[BreakScores],
) -> SensorFaultRow {
    let spread = |figure: fn(&Scores) -> Option<f64>| {
        let figures = drives.iter().map(|drive| figure(&drive[column]));
        MeanStd::of(&figures.collect::<Vec<_>>())
    };
    let losses: Vec<Option<f64>> = drives
        .iter()
        .map(|drive| Some(drive[column].oe? - drive[0].oe?))
        .collect();
    let worst = losses.iter().zip(seeds);
    let worst = worst.filter_map(|(loss, seed)| Some(((*loss)?, *seed)));
    SensorFaultRow {
        scenario: scenario.name.clone(),
        method,
        sensor_break,
        oe: spread(|scores| scores.oe),
        oe_unexpanded: spread(|scores| scores.oe_unexpanded),
        tpr: spread(|scores| scores.tpr),
        fpr: spread(|scores| scores.fpr),
        surface_recall: spread(|scores| scores.surface_recall),
        coverage: spread(|scores| scores.coverage),
        loss: MeanStd::of(&losses),
        worst: worst.max_by(|(a, _), (b, _)| a.total_cmp(b)),
    }
}

/// One line of fixed columns.
impl fmt::Display for SensorFaultRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let figure = |value, decimals| Number { value, decimals };
        let percent = |share: Option<f64>| figure(share.map(|share| 100.0 * share), 2);
        let verdict = match self.sensor_break {
            None => "    ",
            Some(_) if self.holds() => "PASS",
            Some(_) => "FAIL",
        };
        let sensor_break = self
            .sensor_break
            .map_or("none".to_owned(), |sensor_break| sensor_break.to_string());
        write!(
            f,
            "{verdict}  {:6} {:8} {sensor_break:9}  OE {:5} %  plain OE {:5} %  TPR {:4}  FPR {:5}  recall {:4}  \
             coverage {:4}",
            self.scenario,
            self.method,
            percent(self.oe.mean),
            percent(self.oe_unexpanded.mean),
            figure(self.tpr.mean, 2),
            figure(self.fpr.mean, 3),
            figure(self.surface_recall.mean, 2),
            figure(self.coverage.mean, 2),
        )?;
        let (Some(sensor_break), Some((worst, seed))) = (self.sensor_break, self.worst) else {
            return Ok(());
        };
        write!(
            f,
            "  loss {:5}, worst {:5} ({seed}) <= {:.0} points",
            percent(self.loss.mean),
            percent(Some(worst)),
            100.0 * sensor_break.most_loss()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::standard;

    #[test]
    fn any_method_is_judged_with_each_break() {
        let trials = SensorFaultTrials {
            scenarios: vec![standard("msod").unwrap().unwrap()],
            physics: Physics::Matched,
            seeds: 100..101,
            breaks_at: 0.5,
            methods: vec![Method::PLUS, Method::ISM_TUNED, Method::ALL_FREE],
            particles_per_sensor: 50,
        };
        let rows = trials.run().unwrap();
        assert_eq!(rows.len(), 3 * (1 + SensorBreak::ALL.len()));
        for (rows, method) in rows.chunks(4).zip(&trials.methods) {
            assert!(rows.iter().all(|row| row.method == *method), "{rows:?}");
            assert!(rows.iter().all(|row| row.oe.mean.is_some()), "{rows:?}");
            assert_eq!(rows[0].worst, Some((0.0, 100)), "{rows:?}");
        }
        assert!(
            rows[11].to_string().contains("all-free stuck"),
            "{}",
            rows[11]
        );
    }
}
