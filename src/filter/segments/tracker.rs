//! The tracker: its state and its step.

use heapless::Vec;

use super::birth::Birth;
use super::fit::{SegmentFit, TrackedSegments, set_covariances};
use super::linear::System;
use super::segment::TrackedSegment;
use super::upkeep::{cut_at_hull, fold, keep_in_reach};
use super::window::StepReadings;
use super::{MAX_WINDOW, SegmentParameters};
use crate::checksum::Digest;
use crate::geometry::{Angle, Motion, Point, Rotation};
use crate::model::{Mount, Photometry, Ring, SENSORS, Sample, TabulatedWallLaw};

/// Motion of a step beyond which the segments' places are unknown, metres.
const LARGEST_MOTION_M: f32 = 0.5;
/// Motion below which a step replaces the newest one of the window, metres and radians:
/// a robot that stands still repeats its readings, which are no new evidence.
const LEAST_MOTION_M: f32 = 0.002;
const LEAST_TURN_RAD: f32 = 0.02;
/// Motion after which one iteration of the fit is enough, metres: twice a step of 10 mm,
/// and less than half of the way between two stations.
pub(super) const SHORT_MOTION_M: f32 = 0.02;
/// Steps after which a segment is no longer new.
const SETTLED_STEPS: u16 = 3;

/// Everything that stays the same during a run.
#[derive(Clone, Debug)]
pub struct SegmentModel {
    pub(super) parameters: SegmentParameters,
    pub(super) law: TabulatedWallLaw,
    pub(super) mounts: [Mount; SENSORS],
}

impl SegmentModel {
    /// Prepares the law of walls for a ring of sensors.
    #[must_use]
    pub fn new(parameters: SegmentParameters, photometry: &Photometry, ring: &Ring) -> Self {
        let mounts = core::array::from_fn(|index| ring.mount(index));
        Self::of_mounts(parameters, photometry, &mounts)
    }

    /// The same for mounts that are prepared.
    pub(crate) fn of_mounts(
        parameters: SegmentParameters,
        photometry: &Photometry,
        mounts: &[Mount; SENSORS],
    ) -> Self {
        Self {
            parameters,
            law: TabulatedWallLaw::of(photometry),
            mounts: *mounts,
        }
    }

    /// The law of walls.
    #[must_use]
    pub fn law(&self) -> &TabulatedWallLaw {
        &self.law
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &SegmentParameters {
        &self.parameters
    }
}

/// Tracks wall segments from step to step (`src/filter/segments/mod.rs` has the equations).
///
/// 2 kB. The same steps give the same segments, bit for bit, on all machines.
#[derive(Clone, Debug)]
pub struct SegmentTracker {
    segments: TrackedSegments,
    window: Vec<StepReadings, MAX_WINDOW, u8>,
    heading: Angle,
    /// Whether the next step's motion adds to that of the newest row.
    pending: Pending,
    birth: Birth,
    steps: u16,
}

/// Motion since the last step that was kept.
#[derive(Clone, Copy, Debug, Default)]
struct Pending {
    way_m: f32,
    turn_rad: f32,
}

const _: () = assert!(core::mem::size_of::<SegmentTracker>() <= 6 * 1024);

impl Default for SegmentTracker {
    fn default() -> Self {
        Self::new()
    }
}

impl SegmentTracker {
    /// A tracker without segments.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            segments: Vec::new(),
            window: Vec::new(),
            heading: Motion::NONE.turn,
            pending: Pending {
                way_m: 0.0,
                turn_rad: 0.0,
            },
            birth: Birth::none(),
            steps: 0,
        }
    }

    /// The segments, oldest first.
    #[must_use]
    pub fn segments(&self) -> &[TrackedSegment] {
        &self.segments
    }

    /// The readings of the window, the newest last.
    pub(super) fn rows(&self) -> &[StepReadings] {
        &self.window
    }

    /// Whether there is nothing that a digest would hold: no segment, and no birth runs.
    pub(crate) fn is_idle(&self) -> bool {
        self.segments.is_empty() && !self.birth.is_running()
    }

    /// Adds the segments, and the birth that runs, to a digest of the filter.
    pub(crate) fn update(&self, digest: &mut Digest) {
        for segment in &self.segments {
            digest.update(u32::from(segment.id) | u32::from(segment.age_steps) << 16);
            for end in segment.ends {
                digest.update(end.x.to_bits());
                digest.update(end.y.to_bits());
            }
            digest.update(segment.evidence.to_bits());
        }
        if self.birth.is_running() {
            self.birth.update(digest);
        }
    }

    /// A point of the tracker's axes in the body frame.
    #[must_use]
    pub fn body_from_track(&self, place: Point) -> Point {
        place.rotated(Rotation::by(self.heading.radians()).inverse())
    }

    /// Forgets everything: the motion since the last step is unknown.
    pub fn reset(&mut self) {
        self.segments.clear();
        self.window.clear();
        self.heading = Angle::default();
        self.pending = Pending::default();
        self.birth = Birth::none();
        self.steps = 0;
    }

    /// Takes a step: the motion since the last one, and what the sensors read after it.
    ///
    /// Sensors without counts are left out. A motion that is no number, or of more than
    /// half a metre, resets the tracker. `retired` receives the segments that are
    /// forgotten because they are out of reach or make room for a new one, with their
    /// last place; those that are dropped because the readings do not need them are not
    /// reported.
    #[inline(never)]
    pub fn step(
        &mut self,
        model: &SegmentModel,
        motion: &Motion,
        samples: &[Sample; SENSORS],
        retired: &mut impl FnMut(&TrackedSegment),
    ) {
        let way_m = motion.displacement.norm();
        if !self.advance(motion) {
            self.segments.iter().for_each(&mut *retired);
            self.reset();
        }
        self.take_row(model, samples);
        keep_in_reach(&model.parameters, &mut self.segments, retired);
        self.steps = self.steps.wrapping_add(1);
        let fit = SegmentFit {
            model,
            rows: &self.window,
        };
        let mut system = System::new();
        // A birth that joins brings a fit of all segments with it.
        let is_short = way_m <= SHORT_MOTION_M;
        let is_joining = self.birth.is_joining();
        if is_short && (is_joining || self.is_settled()) {
            fit.follow(&mut self.segments, &mut system);
        } else {
            let most = if is_joining { 1 } else { u8::MAX };
            let iterations = model.parameters.iterations.min(most);
            let _ = fit.refine(&mut self.segments, iterations, &mut system);
        }
        set_covariances(&mut self.segments, &system);
        cut_at_hull(&model.parameters, &mut self.segments);
        let upkeep_steps = u16::from(model.parameters.upkeep_steps.max(1));
        let mut has_tried_merge = false;
        if self.steps.is_multiple_of(upkeep_steps) && !(is_short && is_joining) {
            let turn = usize::from(self.steps / upkeep_steps);
            fit.drop_weakest(&mut self.segments);
            has_tried_merge = fit.merge_collinear(&mut self.segments, turn, &mut system);
        }
        if !has_tried_merge {
            let evicted = fit.advance_birth(&mut self.birth, &mut self.segments, &mut system);
            evicted.iter().for_each(&mut *retired);
            cut_at_hull(&model.parameters, &mut self.segments);
        }
        for segment in &mut self.segments {
            segment.age_steps = segment.age_steps.saturating_add(1);
        }
    }

    /// Whether no segment is new: one iteration of the fit is enough after a short motion.
    fn is_settled(&self) -> bool {
        let is_old = |segment: &TrackedSegment| segment.age_steps >= SETTLED_STEPS;
        self.segments.iter().all(is_old)
    }

    /// Moves everything against the robot's motion; `false` if that is unknown.
    fn advance(&mut self, motion: &Motion) -> bool {
        let by = motion
            .displacement
            .rotated(Rotation::by(self.heading.radians()));
        let way_m = by.norm();
        let turn_rad = motion.turn.radians();
        let is_known = way_m <= LARGEST_MOTION_M && turn_rad.is_finite();
        if !is_known {
            return false;
        }
        let against = Point::new(-by.x, -by.y);
        for segment in &mut self.segments {
            segment.translate(against);
        }
        self.birth.translate(against);
        for row in &mut self.window {
            row.position = row.position + against;
        }
        self.heading = Angle::from_radians(self.heading.radians() + turn_rad);
        self.pending.way_m += way_m;
        self.pending.turn_rad += turn_rad.abs();
        true
    }

    /// Takes the readings into the window, and folds those that leave it.
    #[inline(never)]
    fn take_row(&mut self, model: &SegmentModel, samples: &[Sample; SENSORS]) {
        let heading = Rotation::by(self.heading.radians());
        let row = StepReadings::new(heading, samples, &model.law, &model.parameters);
        let is_still =
            self.pending.way_m < LEAST_MOTION_M && self.pending.turn_rad < LEAST_TURN_RAD;
        if is_still && let Some(newest) = self.window.last_mut() {
            *newest = row;
            return;
        }
        self.pending = Pending::default();
        let most = usize::from(model.parameters.window_steps).clamp(1, MAX_WINDOW);
        while let Some(oldest) = self.window.first() {
            let is_within = oldest.position.norm() <= model.parameters.window_m;
            if is_within && self.window.len() < most {
                break;
            }
            fold(model, oldest, &mut self.segments);
            let mut kept = 0;
            self.window.retain(|_| {
                kept += 1;
                kept > 1
            });
        }
        let _ = self.window.push(row);
    }
}
