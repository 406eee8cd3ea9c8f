//! A step of the filter in the node, and its events.

use super::batch::Batch;
use super::{Event, Node, Obstacle, StepBegun, StepDone, StepInput};
use crate::filter::Tally;
use crate::math;

impl<const N: usize> Node<'_, N> {
    /// Steps the filter and emits the events of the step.
    ///
    /// Not inlined into the image's task, which would cost 0.3 million instructions per step.
    #[inline(never)]
    pub(super) fn step(&mut self, step: &StepInput, emit: &mut impl FnMut(&Event)) {
        let index = self.status.steps;
        let readings = self.config.readings(&step.samples);
        emit(&Event::StepBegun(StepBegun {
            index,
            stamp_us: step.stamp_us,
            pose: step.pose,
            samples: step.samples,
        }));
        let mut batch = Batch::new(index, emit);
        let report = |position, outcome| batch.push(position, outcome);
        let tally = self
            .filter
            .step(&self.model, &step.motion, &readings, report);
        batch.flush();
        let digest = self.filter.digest();
        emit(&Event::StepDone(step_done(index, digest, &tally)));
        self.status.steps = index.wrapping_add(1);
        self.status.obstacle = tally.nearest.map(|position| Obstacle {
            range_m: position.norm(),
            bearing_rad: math::coarse_atan2(position.y, position.x),
        });
    }
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
