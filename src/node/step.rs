//! A step of the filter in the node, and its events.

use super::batch::Batch;
use super::{Event, Node, Obstacle, StepBegun, StepDone, StepInput, Walls};
use crate::filter::{Tally, TrackedSegment};
use crate::math;

impl<const N: usize> Node<'_, N> {
    /// Steps the filter and emits the events of the step.
    #[inline]
    pub(super) fn step(&mut self, step: &StepInput, emit: &mut impl FnMut(&Event)) {
        if self.model.has_upper_bounds() {
            self.step_on_walls(step, emit);
        } else {
            self.step_on_points(step, emit);
        }
    }

    /// The step of the profiles `paper` and `plus`.
    ///
    /// Not inlined into the image's task, which would cost 0.3 million instructions per step.
    #[inline(never)]
    fn step_on_points(&mut self, step: &StepInput, emit: &mut impl FnMut(&Event)) {
        let index = self.status.steps;
        let readings = self.config.readings(&step.samples);
        emit(&step_begun(index, step));
        let mut batch = Batch::new(index, emit);
        let report = |position, outcome| batch.push(position, outcome);
        let tally = self
            .filter
            .step(&self.model, &step.motion, &readings, report);
        batch.flush();
        let digest = self.filter.digest();
        emit(&Event::StepDone(step_done(index, digest, &tally)));
        self.end_step(index, &tally);
    }

    /// The same with the profiles `wall` and `arcs`.
    #[inline(never)]
    fn step_on_walls(&mut self, step: &StepInput, emit: &mut impl FnMut(&Event)) {
        let index = self.status.steps;
        let readings = self.config.readings(&step.samples);
        emit(&step_begun(index, step));
        if self.model.has_segments() {
            self.track_walls(index, step, emit);
        }
        let mut batch = Batch::new(index, emit);
        let mut report = |position, outcome| batch.push(position, outcome);
        let tally = self
            .filter
            .step_on_walls(&self.model, &step.motion, &readings, &mut report);
        batch.flush();
        let digest = self.filter.digest();
        emit(&Event::StepDone(step_done(index, digest, &tally)));
        self.end_step(index, &tally);
    }

    /// Fits the wall segments and emits them, ahead of the particles: a motion planner has
    /// them 0.1 s earlier.
    #[inline(never)]
    fn track_walls(&mut self, index: u32, step: &StepInput, emit: &mut impl FnMut(&Event)) {
        let mut walls = Walls::new(index);
        let samples = self.config.samples_at_gain_one(&step.samples);
        let mut left = |segment: &TrackedSegment| walls.leave(segment);
        self.filter
            .track(&self.model, &step.motion, &samples, &mut left);
        walls.track(self.filter.tracker(), &step.pose);
        emit(&Event::Walls(walls));
    }

    fn end_step(&mut self, index: u32, tally: &Tally) {
        self.status.steps = index.wrapping_add(1);
        self.status.obstacle = tally.nearest.map(|position| Obstacle {
            range_m: position.norm(),
            bearing_rad: math::coarse_atan2(position.y, position.x),
        });
    }
}

fn step_begun(index: u32, step: &StepInput) -> Event {
    Event::StepBegun(StepBegun {
        index,
        stamp_us: step.stamp_us,
        pose: step.pose,
        samples: step.samples,
    })
}

fn step_done(index: u32, digest: u32, tally: &Tally) -> StepDone {
    let count = |count: u32| u16::try_from(count).unwrap_or(u16::MAX);
    StepDone {
        index,
        digest,
        past_gate: count(tally.past_gate),
        below_gate: count(tally.below_gate),
        free: count(tally.free),
        unobserved: count(tally.unobserved),
        departed: count(tally.departed),
        degenerate: tally.live > 0 && tally.weight_sum == 0,
    }
}
