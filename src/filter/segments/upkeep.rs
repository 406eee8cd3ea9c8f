//! What keeps the segments few and true: folding, reach, hull, drops and merges.

use super::birth::take;
use super::fit::{SegmentFit, TrackedSegments, seen, slopes};
use super::linear::System;
use super::segment::{Prior, TrackedSegment, distance_m, length_m, outside};
use super::window::{StepReadings, huber};
use super::{MAX_SEGMENTS, SegmentModel, SegmentParameters};
use crate::geometry::Point;
use crate::model::Wall;

/// Iterations of the fit of a merged segment.
const MERGE_ITERATIONS: u8 = 3;

/// Turns the readings of a row into the priors and the evidence of the segments.
#[inline(never)]
pub(super) fn fold(model: &SegmentModel, row: &StepReadings, segments: &mut TrackedSegments) {
    let parameters = &model.parameters;
    for segment in segments.iter_mut().filter(|segment| !segment.is_frozen) {
        let ends = segment.ends;
        segment.prior.rebase(&ends, parameters.fade);
    }
    for (mount, measured) in model.mounts.iter().zip(&row.measured) {
        if measured.inverse_sigma <= 0.0 {
            continue;
        }
        let placed = row.place(mount);
        let together = model
            .law
            .signal_and_gradient(&seen(&placed, segments, None));
        let residual = measured.residual(together.signal, parameters);
        let (cost, weight) = huber(residual, parameters.huber);
        let factor = -measured.inverse_sigma / (together.signal + parameters.soft_counts);
        for slope in &slopes(&placed, segments, &together, factor) {
            let index = active_index(segments, slope.first / 4);
            let without = model.law.signal(&seen(&placed, segments, Some(index)));
            let without = measured.residual(without, parameters);
            if let Some(segment) = segments.get_mut(index) {
                segment.prior.add(&slope.values, residual, weight);
                segment.evidence += huber(without, parameters.huber).0 - cost;
            }
        }
    }
}

/// Index of a segment by its place among those that are not frozen.
fn active_index(segments: &[TrackedSegment], place: usize) -> usize {
    let active = segments.iter().enumerate().filter(|(_, s)| !s.is_frozen);
    active
        .map(|(index, _)| index)
        .nth(place)
        .unwrap_or(usize::MAX)
}

/// Freezes, revives and forgets by distance; reports what is forgotten.
#[inline(never)]
pub(super) fn keep_in_reach(
    parameters: &SegmentParameters,
    segments: &mut TrackedSegments,
    retired: &mut impl FnMut(&TrackedSegment),
) {
    segments.retain_mut(|segment| {
        segment.is_frozen = distance_m(&segment.ends, Point::default()) > parameters.reach_m;
        let is_kept = !segment.is_frozen || segment.evidence > parameters.freeze_evidence;
        if !is_kept {
            retired(segment);
        }
        is_kept
    });
}

/// Cuts segments off at the hull, and drops those of which too little is left.
#[inline(never)]
pub(super) fn cut_at_hull(parameters: &SegmentParameters, segments: &mut TrackedSegments) {
    segments.retain_mut(|segment| {
        let Some(ends) = outside(&segment.ends, parameters.hull_m) else {
            return false;
        };
        if ends != segment.ends {
            segment.ends = ends;
            segment.prior.rebase(&ends, 1.0);
            segment.prior.pull.fill(0.0);
        }
        let is_finite = ends
            .iter()
            .all(|end| end.x.is_finite() && end.y.is_finite());
        is_finite && segment.length_m() >= parameters.least_length_m
    });
}

impl SegmentFit<'_> {
    /// Drops the segment with the least evidence if that is too little.
    #[inline(never)]
    pub(super) fn drop_weakest(&self, segments: &mut TrackedSegments) {
        let gains = self.gains(segments);
        let mut least: Option<(usize, f32)> = None;
        for (index, (segment, gain)) in segments.iter().zip(gains).enumerate() {
            let evidence = segment.evidence + gain;
            let is_weak = !segment.is_frozen && !self.is_sure(segment);
            if is_weak && least.is_none_or(|(_, other)| evidence < other) {
                least = Some((index, evidence));
            }
        }
        if let Some((index, evidence)) = least
            && evidence < self.model.parameters.drop_evidence
        {
            let _ = take(segments, index);
        }
    }

    /// Whether what a segment has saved before is so much that it is not dropped.
    fn is_sure(&self, segment: &TrackedSegment) -> bool {
        segment.evidence > self.model.parameters.freeze_evidence
    }

    /// What each segment that is not sure saves at the readings of the window.
    fn gains(&self, segments: &[TrackedSegment]) -> [f32; MAX_SEGMENTS] {
        let parameters = &self.model.parameters;
        let law = &self.model.law;
        let mut gains = [0.0; MAX_SEGMENTS];
        for (placed, measured) in self.readings() {
            let cost = |signal| huber(measured.residual(signal, parameters), parameters.huber).0;
            let mut with: Option<f32> = None;
            for (index, (segment, gain)) in segments.iter().zip(&mut gains).enumerate() {
                if segment.is_frozen
                    || self.is_sure(segment)
                    || !law.may_see(&placed.see(&segment.ends))
                {
                    continue;
                }
                let with =
                    *with.get_or_insert_with(|| cost(law.signal(&seen(&placed, segments, None))));
                *gain += cost(law.signal(&seen(&placed, segments, Some(index)))) - with;
            }
        }
        gains
    }

    /// Tries to merge one pair of collinear segments, which is done if it costs little;
    /// whether there was a pair.
    ///
    /// The search for the pair begins at another segment each time.
    #[inline(never)]
    pub(super) fn merge_collinear(
        &self,
        segments: &mut TrackedSegments,
        turn: usize,
        system: &mut System,
    ) -> bool {
        let count = segments.len();
        for nth in 0..count {
            let mut first = nth + turn % count.max(1);
            if first >= count {
                first -= count;
            }
            for second in first + 1..count {
                if let Some(merged) = merged(segments, first, second, &self.model.parameters) {
                    self.merge(segments, [first, second], &merged, system);
                    return true;
                }
            }
        }
        false
    }

    #[inline(never)]
    fn merge(
        &self,
        segments: &mut TrackedSegments,
        [first, second]: [usize; 2],
        merged: &TrackedSegment,
        system: &mut System,
    ) {
        let before = self.cost_without_priors(segments);
        let mut with = segments.clone();
        if let Some(place) = with.get_mut(first) {
            *place = *merged;
        }
        let _ = take(&mut with, second);
        let _ = self.refine(&mut with, MERGE_ITERATIONS, system);
        if self.cost_without_priors(&with) - before < self.model.parameters.merge_cost {
            *segments = with;
        }
    }

    /// Cost of the readings and the lengths: priors that were begun anew do not compare.
    fn cost_without_priors(&self, segments: &[TrackedSegment]) -> f32 {
        let active = segments.iter().filter(|segment| !segment.is_frozen);
        let lengths = active.map(|segment| segment.length_residual(&self.model.parameters).0);
        let lengths = lengths.fold(0.0, |sum, length| sum + length * length);
        self.readings_cost(segments, None) + lengths
    }
}

/// The segment between the outer ends of two that are nearly collinear.
#[inline(never)]
fn merged(
    segments: &[TrackedSegment],
    first: usize,
    second: usize,
    parameters: &SegmentParameters,
) -> Option<TrackedSegment> {
    let (a, b) = (segments.get(first)?, segments.get(second)?);
    if a.is_frozen || b.is_frozen {
        return None;
    }
    // The inner ends are those nearest to each other.
    let mut nearest: Option<(f32, usize, usize)> = None;
    for (of_a, end_a) in a.ends.iter().enumerate() {
        for (of_b, end_b) in b.ends.iter().enumerate() {
            let gap = (*end_a - *end_b).norm();
            if nearest.is_none_or(|(least, ..)| gap < least) {
                nearest = Some((gap, of_a, of_b));
            }
        }
    }
    let (gap, inner_a, inner_b) = nearest?;
    let (outer_a, outer_b) = (1 - inner_a, 1 - inner_b);
    let ends: Wall = [*a.ends.get(outer_a)?, *b.ends.get(outer_b)?];
    let is_straight = [*a.ends.get(inner_a)?, *b.ends.get(inner_b)?]
        .iter()
        .all(|inner| distance_m(&ends, *inner) < parameters.merge_bend_m);
    // One inside of the other has its inner ends far from the joint of the two.
    let is_longer = length_m(&ends) > a.length_m().max(b.length_m());
    if gap >= parameters.merge_gap_m || !is_straight || !is_longer {
        return None;
    }
    Some(TrackedSegment {
        id: if a.evidence >= b.evidence { a.id } else { b.id },
        ends,
        evidence: a.evidence + b.evidence,
        age_steps: a.age_steps.max(b.age_steps),
        prior: Prior::joined(&ends, [(&a.prior, outer_a), (&b.prior, outer_b)]),
        ..*a
    })
}
