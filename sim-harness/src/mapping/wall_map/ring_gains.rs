//! Gains of a robot's sensors from its drives: walls and gains are fitted in turn.
//!
//! All drives share the unknowns g_i = ln(gain of sensor i relative to the rig's law); each
//! drive has walls of its own. With the walls w of a drive and its normal equations
//!
//! ```text
//! | H_ww  H_wg | | dw |     | b_w |
//! | H_gw  H_gg | | dg | = - | b_g |
//! ```
//!
//! the walls are marginalised: S = H_gg - H_gw H_ww^-1 H_wg is what the drive says about
//! the gains alone. The sum of S over the drives, with the prior, gives the step of the
//! gains and in the end their covariance. The prior has a standard deviation s_g of each
//! gain about the mean of all, and s_a of the mean over the sensors that stand out of the
//! noise: almost free, or none if the common gain is known.
//!
//! The common gain and the distances of walls are hard to tell apart. The fit therefore
//! begins with several common gains, at each of which all drives are mapped, and goes on
//! from the one with the least cost. Then maps and gains are fitted in turn: first with a
//! large error of the law, so that unequal gains make no walls of their own, then with
//! that of the parameters.

use amiro_ipf::model::Gain;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::gain_statistics::{determined, mean_weights, prior, relative, variance};
use super::readings::Readings;
use super::refine::{NormalEquations, Unknowns};
use super::scene::WallScene;
use super::{SensorGain, WallMapParameters};
use crate::drive::Record;
use crate::rig::Rig;

/// Common gains to begin with, relative to the rig's.
const STARTS: [f64; 4] = [1.0, 0.6, 1.6, 2.4];

/// Decrease of the cost for which a start is preferred to the rig's own gain, chi^2.
const DECISIVE_CHI2: f64 = 20.0;

/// Error of the law while the gains are unknown, relative to the return.
const FIRST_RELATIVE_SIGMA: f64 = 0.15;

/// Times that all drives are mapped anew with the gains so far.
const ROUNDS: u32 = 3;

/// Steps of the gains on the walls of one round.
const STEPS: u32 = 12;

/// Step of ln of a gain at which a round has converged.
const CONVERGED: f64 = 1e-3;

/// Largest step of ln of a gain.
const LARGEST_STEP: f64 = 0.3;

/// Steps of the fit of walls after a step of the gains.
const WALL_ITERATIONS: usize = 4;

/// Times that a step that does not lower the cost is halved.
const HALVINGS: u32 = 5;

/// Gains of all mounts of a rig, from drives of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RingGains {
    /// Gain of the sensors together, relative to the rig's law: the geometric mean over
    /// those that are determined. 1 with a standard deviation of 0 where it was known.
    pub common: SensorGain,
    /// Gain of each mount relative to the common one, with the standard deviation of that
    /// ratio's logarithm; infinite for a mount that is no infrared sensor.
    pub mounts: Vec<SensorGain>,
    /// Whether the drives determine each: its standard deviation is at most
    /// [`LARGEST_SIGMA`](Self::LARGEST_SIGMA), and the gain one that a configuration takes.
    /// None is where chi^2 per reading is above
    /// [`LARGEST_GAIN_CHI2`](Self::LARGEST_GAIN_CHI2).
    pub is_determined: Vec<bool>,
    /// Number of readings of each mount that stand out of the noise.
    pub lit: Vec<usize>,
    /// Number of walls of each drive.
    pub walls: Vec<usize>,
    /// Mean cost of a lit reading, chi^2. Standard deviations are scaled by its root where
    /// it is above 1.
    pub chi2_per_reading: f64,
}

/// Drives of one robot, from which the gains of its sensors are fitted.
#[derive(Clone, Debug)]
pub struct RingGainFit {
    parameters: WallMapParameters,
    rig: Rig,
    drives: Vec<Readings>,
    is_common_known: bool,
}

/// The drives with walls, under the same gains.
#[derive(Clone, Debug)]
struct MappedDrives<'r> {
    scenes: Vec<WallScene<'r>>,
    gains: DVector<f64>,
    prior: DMatrix<f64>,
}

impl RingGains {
    /// Largest standard deviation of the logarithm of a gain that counts as determined: a
    /// quarter to a half of the spread of the sensors of a robot.
    pub const LARGEST_SIGMA: f64 = 0.04;

    /// Largest standard deviation of the logarithm of the common gain that counts as
    /// determined.
    pub const LARGEST_COMMON_SIGMA: f64 = 0.1;

    /// Largest chi^2 per reading with which any gain counts as determined: above it
    /// something is in view that is no standing wall, such as another robot.
    pub const LARGEST_GAIN_CHI2: f64 = 4.0;

    /// Largest chi^2 per reading with which the common gain counts as determined.
    pub const LARGEST_CHI2: f64 = 1.0;

    /// Whether the common gain is known, or determined by the drives: its standard
    /// deviation is small, and the law explains the readings within the error that the
    /// parameters grant it. A law that does not moves walls and common gain together.
    #[must_use]
    pub fn is_common_determined(&self) -> bool {
        let is_explained = self.chi2_per_reading <= Self::LARGEST_CHI2;
        self.is_common_known() || (self.common.sigma <= Self::LARGEST_COMMON_SIGMA && is_explained)
    }

    /// Whether the common gain was known beforehand.
    #[must_use]
    pub fn is_common_known(&self) -> bool {
        self.common.sigma <= 0.0
    }
}

impl RingGainFit {
    /// No drives of a robot yet. `gain_sigma` of the parameters is not used.
    #[must_use]
    pub fn new(rig: &Rig, parameters: WallMapParameters) -> Self {
        Self {
            parameters: WallMapParameters {
                gain_sigma: 0.0,
                ..parameters
            },
            rig: rig.clone(),
            drives: Vec::new(),
            is_common_known: false,
        }
    }

    /// The same with the gain of the rig's law as the common gain: that of each sensor
    /// relative to it is fitted.
    #[must_use]
    pub fn with_known_common(self) -> Self {
        Self {
            is_common_known: true,
            ..self
        }
    }

    /// Begins another drive; the odometry of drives is not compared.
    pub fn begin_drive(&mut self) {
        self.drives.push(Readings::new(&self.rig, self.parameters));
    }

    /// Takes a record of the drive that was begun last; scans with signals are used.
    pub fn take(&mut self, record: &Record) {
        if self.drives.is_empty() {
            self.begin_drive();
        }
        if let (Record::Scan(scan), Some(drive)) = (record, self.drives.last_mut()) {
            drive.take(scan);
        }
    }

    /// Fits walls and gains.
    ///
    /// Cost: seven maps of all drives, three with a known common gain.
    #[must_use]
    pub fn solve(mut self) -> RingGains {
        self.drives.iter_mut().for_each(Readings::mark_clipped);
        let coarse = WallMapParameters {
            relative_sigma: self.parameters.relative_sigma.max(FIRST_RELATIVE_SIGMA),
            ..self.parameters
        };
        let first = self.reweighted(&coarse);
        let prior = self.prior();
        let mut gains = if self.is_common_known {
            DVector::zeros(self.rig.mounts.len())
        } else {
            best_start(&first, &coarse, &prior)
        };
        let fine = self.reweighted(&self.parameters);
        let mut solved = None;
        for round in 0..ROUNDS {
            let (drives, parameters) = match round {
                0 => (&first, &coarse),
                _ => (&fine, &self.parameters),
            };
            let mut mapped = MappedDrives::new(drives, parameters, &gains, &prior);
            mapped.fit_gains();
            gains = mapped.gains.clone();
            solved = Some(mapped.answer());
        }
        // There is at least one round.
        let mut solved = solved
            .unwrap_or_else(|| MappedDrives::new(&fine, &self.parameters, &gains, &prior).answer());
        if self.is_common_known {
            solved.common = SensorGain {
                ratio: 1.0,
                sigma: 0.0,
            };
        }
        solved
    }

    /// Information of the prior of the gains.
    fn prior(&self) -> DMatrix<f64> {
        let mounts = self.rig.mounts.len();
        let mut is_lit = vec![false; mounts];
        let rows = self.drives.iter().flat_map(|drive| &drive.rows);
        for row in rows.filter(|row| row.is_lit()) {
            if let Some(is_lit) = is_lit.get_mut(row.mount) {
                *is_lit = true;
            }
        }
        prior(&is_lit, self.is_common_known)
    }

    fn reweighted(&self, parameters: &WallMapParameters) -> Vec<Readings> {
        let drives = self.drives.iter();
        drives.map(|drive| drive.reweighted(parameters)).collect()
    }
}

/// The common gain, of those to begin with, at which maps cost least.
fn best_start(
    drives: &[Readings],
    parameters: &WallMapParameters,
    prior: &DMatrix<f64>,
) -> DVector<f64> {
    let start = |factor: f64| DVector::from_element(prior.nrows(), libm::log(factor));
    let cost = |factor| MappedDrives::new(drives, parameters, &start(factor), prior).cost();
    let [own, others @ ..] = STARTS;
    let (mut best, mut least) = (own, cost(own) - DECISIVE_CHI2);
    for other in others {
        let cost = cost(other);
        if cost < least {
            (best, least) = (other, cost);
        }
    }
    start(best)
}

impl<'r> MappedDrives<'r> {
    /// Maps all drives under given gains.
    fn new(
        drives: &'r [Readings],
        parameters: &'r WallMapParameters,
        gains: &DVector<f64>,
        prior: &DMatrix<f64>,
    ) -> Self {
        let mapped = |readings: &'r Readings| {
            let mut scene = WallScene::new(readings, parameters);
            scene.change_gains(gains.as_slice());
            scene.give_births(&mut |_| {});
            scene.settle(Unknowns::Ends);
            scene
        };
        Self {
            scenes: drives.par_iter().map(mapped).collect(),
            gains: gains.clone(),
            prior: prior.clone(),
        }
    }

    /// Cost of all readings, all walls, and the gains.
    fn cost(&self) -> f64 {
        let scenes = self.scenes.iter().map(WallScene::total_cost);
        scenes.sum::<f64>() + (self.gains.transpose() * &self.prior * &self.gains)[(0, 0)]
    }

    /// What the drives say about the gains, walls marginalised: information and gradient,
    /// without the prior.
    fn marginal(&self) -> (DMatrix<f64>, DVector<f64>) {
        let mounts = self.gains.len();
        let each = self.scenes.par_iter().filter_map(|scene| {
            let walls = scene.indices();
            NormalEquations::of(scene, &walls, Unknowns::EndsAndGains).without_walls(walls.len())
        });
        let zero = (DMatrix::zeros(mounts, mounts), DVector::zeros(mounts));
        let each: Vec<_> = each.collect();
        each.into_iter()
            .fold(zero, |sum, one| (sum.0 + one.0, sum.1 + one.1))
    }

    /// Steps of gains and walls until the gains stay.
    fn fit_gains(&mut self) {
        for _ in 0..STEPS {
            let (information, gradient) = self.marginal();
            let information = information + &self.prior;
            let gradient = gradient + &self.prior * &self.gains;
            let Some(factor) = information.cholesky() else {
                return;
            };
            let mut step = -factor.solve(&gradient);
            let largest = step.amax();
            if largest > LARGEST_STEP {
                step *= LARGEST_STEP / largest;
            }
            if !self.moves(&step) || largest < CONVERGED {
                return;
            }
        }
    }

    /// Moves the gains by a step or a part of it, and the walls after them, if that lowers
    /// the cost.
    fn moves(&mut self, step: &DVector<f64>) -> bool {
        let before = self.cost();
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let mut moved = self.clone();
            moved.gains += step * share;
            let gains = moved.gains.clone();
            moved.scenes.par_iter_mut().for_each(|scene| {
                scene.change_gains(gains.as_slice());
                for index in scene.indices() {
                    let group = scene.neighbours(index);
                    scene.refine(&group, WALL_ITERATIONS, Unknowns::Ends);
                }
            });
            if moved.cost() < before {
                *self = moved;
                return true;
            }
            share *= 0.5;
        }
        false
    }

    /// The gains with their standard deviations.
    fn answer(&self) -> RingGains {
        let mounts = self.gains.len();
        let mut lit = vec![0; mounts];
        let (mut cost, mut count) = (0.0, 0_u32);
        for scene in &self.scenes {
            for (row, chi2) in scene.lit_costs() {
                if let Some(lit) = lit.get_mut(row.mount) {
                    *lit += 1;
                }
                cost += chi2;
                count += 1;
            }
        }
        let chi2_per_reading = cost / f64::from(count.max(1));
        let information = self.marginal().0 / chi2_per_reading.max(1.0) + &self.prior;
        let unknown = DMatrix::from_diagonal_element(mounts, mounts, f64::INFINITY);
        let covariance = information.cholesky().map_or(unknown, |it| it.inverse());
        let mut determined = determined(&covariance, &lit);
        let weights = mean_weights(&determined);
        let mean = weights.dot(&self.gains);
        let is_explained = chi2_per_reading <= RingGains::LARGEST_GAIN_CHI2;
        for (is_determined, gain) in determined.iter_mut().zip(&self.gains) {
            let is_legal = Gain::of(libm::exp(gain - mean) as f32).is_some();
            *is_determined &= is_explained && is_legal;
        }
        RingGains {
            common: SensorGain {
                ratio: libm::exp(mean),
                sigma: variance(&covariance, &weights).sqrt(),
            },
            mounts: (0..mounts)
                .map(|mount| SensorGain {
                    ratio: libm::exp(self.gains[mount] - mean),
                    sigma: variance(&covariance, &relative(mount, &weights)).sqrt(),
                })
                .collect(),
            is_determined: if determined.iter().filter(|it| **it).count() > 1 {
                determined
            } else {
                vec![false; mounts]
            },
            lit,
            walls: self.scenes.iter().map(|it| it.indices().len()).collect(),
            chi2_per_reading,
        }
    }
}
