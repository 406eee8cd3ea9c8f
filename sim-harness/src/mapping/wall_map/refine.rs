//! Fits the ends of walls to the readings: damped Gauss-Newton steps.

use nalgebra::{DMatrix, DVector};

use super::scene::{WallChange, WallScene};
use crate::geometry::Vector;
use crate::sensors::WallSegment;

/// First damping, as a share of the diagonal, and how it changes.
const DAMPING: f64 = 1e-2;
const DAMPING_LESS: f64 = 0.3;
const DAMPING_MORE: f64 = 6.0;
const DAMPING_MOST: f64 = 1e6;

/// Farthest that an end moves along x or y in one step, metres; as much changes the
/// logarithm of a gain.
const STEP_M: f64 = 0.03;

/// Length of a wall below which its direction is not divided by its length, metres.
const LEAST_LENGTH_M: f64 = 1e-9;

/// Decrease of the cost below which a fit has converged.
const CONVERGED: f64 = 0.01;

/// Added to the diagonal: an end that no reading determines has a standard deviation of
/// 1 m, 1/m^2.
const STIFFNESS: f64 = 1.0;

/// What a fit changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unknowns {
    /// The ends of walls.
    Ends,
    /// The ends of walls and the gain of each mount.
    EndsAndGains,
}

/// The linear problem of a fit: H = J^T W J and g = J^T W r. Four unknowns per wall, then
/// one per mount if gains are fitted.
#[derive(Clone, Debug)]
pub(super) struct NormalEquations {
    pub(super) information: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl NormalEquations {
    /// The problem of a group of walls, the others held fixed.
    ///
    /// Weights are those of Huber's cost: w = min(1, huber / |r|).
    pub(super) fn of(scene: &WallScene<'_>, group: &[usize], fitted: Unknowns) -> Self {
        let gains = match fitted {
            Unknowns::Ends => 0,
            Unknowns::EndsAndGains => scene.gains().len(),
        };
        let unknowns = 4 * group.len() + gains;
        let mut normal = Self {
            information: DMatrix::from_diagonal_element(unknowns, unknowns, STIFFNESS),
            gradient: DVector::zeros(unknowns),
        };
        let walls = group.iter().filter_map(|index| scene.wall(*index));
        for station in scene.stations_near(walls) {
            normal.add_station(scene, group, station, gains > 0);
        }
        normal.add_lengths(scene, group);
        // Without a standard deviation the caller has a prior of its own.
        if gains > 0 && scene.parameters.gain_sigma > 0.0 {
            let slope = 1.0 / scene.parameters.gain_sigma;
            for (place, gain) in (4 * group.len()..).zip(scene.gains()) {
                normal.add(&[(place, slope)], slope * gain, 1.0);
            }
        }
        normal
    }

    /// Information about the unknowns behind the walls, and their gradient, with the walls
    /// marginalised.
    pub(super) fn without_walls(&self, walls: usize) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let first = 4 * walls;
        let rest = self.information.nrows() - first;
        let of_walls = self.information.view((0, 0), (first, first)).into_owned();
        let mixed = self.information.view((0, first), (first, rest));
        let of_rest = self.information.view((first, first), (rest, rest));
        let factor = of_walls.cholesky()?;
        let information = of_rest - mixed.transpose() * factor.solve(&mixed.into_owned());
        let moved = factor.solve(&self.gradient.rows(0, first).into_owned());
        let gradient = self.gradient.rows(first, rest) - mixed.transpose() * moved;
        Some((information, gradient))
    }

    /// Adds a residual with its derivatives, each with the place of its unknown.
    fn add(&mut self, slopes: &[(usize, f64)], residual: f64, weight: f64) {
        for (a, slope_a) in slopes {
            self.gradient[*a] += weight * slope_a * residual;
            for (b, slope_b) in slopes {
                self.information[(*a, *b)] += weight * slope_a * slope_b;
            }
        }
    }

    /// Adds the readings of a station.
    fn add_station(
        &mut self,
        scene: &WallScene<'_>,
        group: &[usize],
        station: usize,
        are_gains_fitted: bool,
    ) {
        let (indices, walls): (Vec<usize>, Vec<WallSegment>) = scene.walls_at(station).unzip();
        let place_of = |index| Some(4 * group.iter().position(|member| member == index)?);
        let places: Vec<Option<usize>> = indices.iter().map(place_of).collect();
        let huber = scene.parameters.huber;
        let floor = scene.parameters.floor_counts;
        let (mut gradients, mut slopes) = (Vec::new(), Vec::new());
        for row in scene.readings.rows_of(station) {
            let Some(law) = scene.readings.law(row.mount) else {
                continue;
            };
            let signal = scene.linearised(law, row, &walls, &mut gradients);
            let residual = row.residual(signal, floor);
            let by_signal = row.residual_by_signal(signal, floor);
            slopes.clear();
            for (place, by_ends) in places.iter().zip(&gradients) {
                let Some(first) = place else { continue };
                let each = (*first..).zip(by_ends);
                let moved = each.filter(|(_, slope)| slope.abs() > 0.0);
                slopes.extend(moved.map(|(place, slope)| (place, by_signal * slope)));
            }
            if are_gains_fitted && signal > 0.0 {
                slopes.push((4 * group.len() + row.mount, by_signal * signal));
            }
            let weight = huber / residual.abs().max(huber);
            self.add(&slopes, residual, weight);
        }
    }

    /// Adds the prior of each wall's length.
    fn add_lengths(&mut self, scene: &WallScene<'_>, group: &[usize]) {
        for (slot, index) in group.iter().enumerate() {
            let Some(wall) = scene.wall(*index) else {
                continue;
            };
            let way = wall.to - wall.from;
            let sigma = scene.parameters.length_sigma_m * way.norm().max(LEAST_LENGTH_M);
            let unit = way.scaled(1.0 / sigma);
            let slopes = [-unit.x, -unit.y, unit.x, unit.y];
            let slopes: Vec<_> = (4 * slot..).zip(slopes).collect();
            self.add(&slopes, scene.prior(&wall), 1.0);
        }
    }

    /// The step that solves the damped problem.
    fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let mut damped = self.information.clone();
        for place in 0..damped.nrows() {
            damped[(place, place)] *= 1.0 + damping;
        }
        let mut step = -damped.cholesky()?.solve(&self.gradient);
        let largest = step.amax();
        if !largest.is_finite() {
            return None;
        }
        if largest > STEP_M {
            step *= STEP_M / largest;
        }
        Some(step)
    }
}

impl WallScene<'_> {
    /// Fits the ends of a group of walls; by how much the cost changes, never upwards.
    ///
    /// At most `iterations` linear problems, each tried with growing damping.
    pub(super) fn refine(&mut self, group: &[usize], iterations: usize, fitted: Unknowns) -> f64 {
        let mut change = 0.0;
        let mut damping = DAMPING;
        for _ in 0..iterations {
            let normal = NormalEquations::of(self, group, fitted);
            let gains = self.gains().to_vec();
            let mut gained = 0.0;
            while damping < DAMPING_MOST {
                let Some(step) = normal.step(damping) else {
                    damping *= DAMPING_MORE;
                    continue;
                };
                let (old, new) = self.moves(group, &step);
                gained = -self.change(&new);
                let moved: Vec<f64> = gains
                    .iter()
                    .zip(step.iter().skip(4 * group.len()))
                    .map(|(gain, step)| gain + step)
                    .collect();
                if !moved.is_empty() {
                    gained -= self.change_gains(&moved);
                }
                if gained > 0.0 {
                    damping *= DAMPING_LESS;
                    break;
                }
                self.change(&old);
                if !moved.is_empty() {
                    self.change_gains(&gains);
                }
                gained = 0.0;
                if step.amax() < 1e-6 {
                    break;
                }
                damping *= DAMPING_MORE;
            }
            change -= gained;
            if gained < CONVERGED {
                break;
            }
        }
        change
    }

    /// The walls of a group as they are, and after a step.
    fn moves(&self, group: &[usize], step: &DVector<f64>) -> (Vec<WallChange>, Vec<WallChange>) {
        let mut old = Vec::new();
        let mut new = Vec::new();
        for (slot, index) in group.iter().enumerate() {
            let Some(wall) = self.wall(*index) else {
                continue;
            };
            let by = |place: usize| Vector::new(step[4 * slot + place], step[4 * slot + place + 1]);
            let moved = WallSegment::new(wall.from + by(0), wall.to + by(2));
            let is_too_long = moved.length_m() > self.parameters.longest_m;
            let moved = if is_too_long && moved.length_m() > wall.length_m() {
                wall
            } else {
                moved
            };
            old.push((*index, Some(wall)));
            new.push((*index, Some(moved)));
        }
        (old, new)
    }
}
