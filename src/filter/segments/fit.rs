//! The joint fit of all segments to the readings of the window.

use heapless::Vec;
use nalgebra::Matrix4;

use super::linear::{COORDINATES, MAX_UNKNOWNS, Slope, System};
use super::segment::{Prior, TrackedSegment};
use super::window::{LogReading, Placed, StepReadings, huber};
use super::{MAX_SEGMENTS, SegmentModel};
use crate::geometry::Point;
use crate::model::{Wall, WallReturn};

/// With a length of one byte: the state has the same size on every machine.
pub(super) type TrackedSegments = Vec<TrackedSegment, MAX_SEGMENTS, u8>;

/// Damping of the first iteration (Marquardt's lambda), and its factors after an
/// iteration that lowered the cost and one that did not.
const FIRST_DAMPING: f32 = 1e-3;
const EASED: f32 = 0.3;
const RAISED: f32 = 10.0;
/// Damping of the iteration that is not checked: it shortens a step along what the readings
/// leave open.
const FOLLOW_DAMPING: f32 = 1e-2;
/// Change of the cost (chi^2) below which the iterations end: what moves an end by a tenth
/// of its standard deviation.
const SETTLED: f32 = 1e-2;

/// The readings that segments are fitted to.
#[derive(Clone, Copy)]
pub(super) struct SegmentFit<'f> {
    pub(super) model: &'f SegmentModel,
    pub(super) rows: &'f [StepReadings],
}

/// The walls that a sensor may see: those that are not frozen, but for one.
#[inline(never)]
pub(super) fn seen(
    placed: &Placed,
    segments: &[TrackedSegment],
    without: Option<usize>,
) -> Vec<Wall, MAX_SEGMENTS> {
    let mut walls = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        if !segment.is_frozen && Some(index) != without {
            let _ = walls.push(placed.see(&segment.ends));
        }
    }
    walls
}

/// Derivatives of a residual for the segments that are not frozen, in the coordinates of
/// their priors.
#[inline(never)]
pub(super) fn slopes(
    placed: &Placed,
    segments: &[TrackedSegment],
    seen: &WallReturn,
    factor: f32,
) -> Vec<Slope, MAX_SEGMENTS> {
    let mut slopes = Vec::new();
    let active = segments.iter().filter(|segment| !segment.is_frozen);
    for (index, (segment, ends)) in active.zip(&seen.gradient).enumerate() {
        if ends.iter().all(|end| end.norm_squared() == 0.0) {
            continue;
        }
        let values = slope(placed, segment, ends, factor);
        let _ = slopes.push(Slope {
            first: COORDINATES * index,
            values,
        });
    }
    slopes
}

/// The derivatives for one segment.
pub(super) fn slope(
    placed: &Placed,
    segment: &TrackedSegment,
    gradient: &[Point; 2],
    factor: f32,
) -> [f32; COORDINATES] {
    let [a, b] = gradient.map(|end| {
        let local = segment.prior.local(end.rotated(placed.axis));
        Point::new(factor * local.x, factor * local.y)
    });
    [a.x, a.y, b.x, b.y]
}

impl<'f> SegmentFit<'f> {
    /// Every reading of the window with its sensor's place.
    pub(super) fn readings(&self) -> impl Iterator<Item = (Placed, &'f LogReading)> + use<'f> {
        let Self { model, rows } = *self;
        rows.iter().flat_map(|row| {
            let sensors = model.mounts.iter().zip(&row.measured);
            sensors
                .filter(|(_, measured)| measured.inverse_sigma > 0.0)
                .map(|(mount, measured)| (row.place(mount), measured))
        })
    }

    /// Cost of the readings, with all segments or without one.
    #[inline(never)]
    pub(super) fn readings_cost(&self, segments: &[TrackedSegment], without: Option<usize>) -> f32 {
        let parameters = &self.model.parameters;
        self.readings().fold(0.0, |sum, (placed, measured)| {
            let signal = self.model.law.signal(&seen(&placed, segments, without));
            sum + huber(measured.residual(signal, parameters), parameters.huber).0
        })
    }

    /// Cost of the readings and the priors.
    pub(super) fn cost(&self, segments: &[TrackedSegment]) -> f32 {
        let priors = segments.iter().filter(|segment| !segment.is_frozen);
        let priors = priors.map(|segment| segment.prior_cost(&self.model.parameters));
        self.readings_cost(segments, None) + priors.fold(0.0, |sum, cost| sum + cost)
    }

    /// The normal equations at the segments, and their cost with the priors.
    #[inline(never)]
    pub(super) fn assemble(&self, segments: &[TrackedSegment], system: &mut System) -> f32 {
        let parameters = &self.model.parameters;
        let active = segments.iter().filter(|segment| !segment.is_frozen);
        system.clear(COORDINATES * active.clone().count());
        let mut cost = 0.0;
        for (placed, measured) in self.readings() {
            let walls = seen(&placed, segments, None);
            let seen = self.model.law.signal_and_gradient(&walls);
            let residual = measured.residual(seen.signal, parameters);
            let (own, weight) = huber(residual, parameters.huber);
            cost += own;
            if seen.signal > 0.0 {
                let factor = -measured.inverse_sigma / (seen.signal + parameters.soft_counts);
                let slopes = slopes(&placed, segments, &seen, factor);
                system.add(&slopes, residual, weight);
            }
        }
        for (index, segment) in active.enumerate() {
            cost += segment.prior_cost(parameters);
            self.add_prior(segment, COORDINATES * index, system);
        }
        cost
    }

    /// Adds what earlier readings and the expected length say about a segment.
    #[inline(never)]
    pub(super) fn add_prior(&self, segment: &TrackedSegment, first: usize, system: &mut System) {
        let Prior {
            information, pull, ..
        } = &segment.prior;
        let pull = pull - information * segment.prior.deviation(&segment.ends);
        system.add_block(
            first,
            |row, column| information.get((row, column)).copied().unwrap_or(0.0),
            |row| pull.get(row).copied().unwrap_or(0.0),
        );
        let (residual, values) = segment.length_residual(&self.model.parameters);
        system.add(&[Slope { first, values }], residual, 1.0);
    }

    /// Levenberg-Marquardt iterations; the cost that is reached, which is never above the
    /// first one. The equations are left as they are there.
    pub(super) fn refine(
        &self,
        segments: &mut [TrackedSegment],
        iterations: u8,
        system: &mut System,
    ) -> f32 {
        self.descend(segments, iterations, system, &mut |segments, system| {
            self.assemble(segments, system)
        })
    }

    /// Iterations on the equations and the cost of `assemble`: at most two of them per
    /// iteration.
    #[inline(never)]
    pub(super) fn descend(
        &self,
        segments: &mut [TrackedSegment],
        iterations: u8,
        system: &mut System,
        assemble: &mut dyn FnMut(&[TrackedSegment], &mut System) -> f32,
    ) -> f32 {
        let mut cost = assemble(segments, system);
        if segments.iter().all(|segment| segment.is_frozen) {
            return cost;
        }
        let mut damping = FIRST_DAMPING;
        for _ in 0..iterations {
            let Some(step) = system.solve(damping) else {
                damping *= RAISED;
                continue;
            };
            let before = ends(segments);
            self.apply(segments, &step);
            let reached = assemble(segments, system);
            let gained = cost - reached;
            if gained > 0.0 {
                cost = reached;
                damping *= EASED;
            } else {
                for (segment, ends) in segments.iter_mut().zip(before) {
                    segment.ends = ends;
                }
                damping *= RAISED;
            }
            if gained.abs() < SETTLED {
                break;
            }
            if gained <= 0.0 {
                let _ = assemble(segments, system);
            }
        }
        cost
    }

    /// One Gauss-Newton iteration, which takes its step without a look at the cost there:
    /// one evaluation of the readings. The equations are left as they were before it.
    ///
    /// For segments that were fitted a step ago and have barely moved since.
    pub(super) fn follow(&self, segments: &mut [TrackedSegment], system: &mut System) {
        let _ = self.assemble(segments, system);
        if let Some(step) = system.solve(FOLLOW_DAMPING) {
            self.apply(segments, &step);
        }
    }

    fn apply(&self, segments: &mut [TrackedSegment], step: &[f32; MAX_UNKNOWNS]) {
        let active = segments.iter_mut().filter(|segment| !segment.is_frozen);
        for (segment, step) in active.zip(step.chunks_exact(COORDINATES)) {
            segment.step(step, self.model.parameters.most_move_m);
        }
    }
}

/// Sets the covariance of the ends of each segment, the others held, from the equations
/// that a fit has left.
#[inline(never)]
pub(super) fn set_covariances(segments: &mut [TrackedSegment], system: &System) {
    let mut block = System::new();
    let active = segments.iter_mut().filter(|segment| !segment.is_frozen);
    for (index, segment) in active.enumerate() {
        block.take_block(system, COORDINATES * index);
        let mut local = Matrix4::zeros();
        for column in 0..COORDINATES {
            block.set_unit(column);
            let solution = block.solve(1e-4).unwrap_or_default();
            for (row, value) in solution.iter().take(COORDINATES).enumerate() {
                if let Some(entry) = local.get_mut((row, column)) {
                    *entry = *value;
                }
            }
        }
        let Point { x: c, y: s } = segment.prior.along;
        let turn = Matrix4::new(
            c, -s, 0.0, 0.0, //
            s, c, 0.0, 0.0, //
            0.0, 0.0, c, -s, //
            0.0, 0.0, s, c,
        );
        segment.covariance = turn * local * turn.transpose();
    }
}

fn ends(segments: &[TrackedSegment]) -> [Wall; MAX_SEGMENTS] {
    let mut ends = [[Point::default(); 2]; MAX_SEGMENTS];
    for (ends, segment) in ends.iter_mut().zip(segments) {
        *ends = segment.ends;
    }
    ends
}
