//! New segments where a sensor has more signal than the segments explain.
//!
//! A place is sought for the sensor with the most unexplained signal. A birth takes three
//! steps, which bounds what each of them costs; the candidates move with the segments in
//! between, and are part of the state.
//!
//! 1. **Rank.** Each of 84 candidates (normal, bearing, length) is put at the distance at
//!    which it returns the missing signal. What it would save at the readings of the
//!    window is computed without occlusion.
//! 2. **Fit.** The best three are fitted alone, the other segments held, with occlusion.
//! 3. **Join.** The best of these is fitted together with the others. It stays if that
//!    saves more than `birth_gain`; the frozen segment with the least evidence makes room
//!    if there is none.

use heapless::Vec;

use super::fit::{SegmentFit, TrackedSegments, seen, slope};
use super::linear::{COORDINATES, Slope, System};
use super::segment::TrackedSegment;
use super::tracker::SHORT_MOTION_M;
use super::window::{LogReading, Placed, StepReadings, huber};
use super::{MAX_SEGMENTS, MAX_WINDOW};
use crate::checksum::Digest;
use crate::geometry::Point;
use crate::model::{SENSORS, Wall};

/// Candidates that are fitted.
pub(super) const FINALISTS: usize = 3;
/// Share of the gain that a candidate must make alone; the other segments add little by
/// giving way to it.
const LEAST_SHARE: f32 = 0.3;
/// Iterations of the fit of each of the best candidates alone.
const ALONE_ITERATIONS: u8 = 3;
/// Of the window's steps every second one ranks the candidates, the newest first: parallax stays.
const RANK_STRIDE: usize = 2;

/// Steps without a birth after one that failed: the same readings fail again.
const PAUSE_STEPS: u8 = 4;

/// A birth over several steps.
#[derive(Clone, Debug)]
pub(super) struct Birth {
    stage: BirthStage,
    /// Places, in the coordinates of the segments.
    candidates: Vec<Wall, FINALISTS, u8>,
    next_id: u16,
    /// Steps until the next birth may begin.
    pause: u8,
}

/// What is to be done in the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BirthStage {
    Rank,
    Fit,
    Join,
}

impl Birth {
    /// No birth runs.
    pub(super) const fn none() -> Self {
        Self {
            stage: BirthStage::Rank,
            candidates: Vec::new(),
            next_id: 0,
            pause: 0,
        }
    }

    /// Whether a birth runs.
    pub(super) fn is_running(&self) -> bool {
        self.stage != BirthStage::Rank
    }

    /// Whether the next part is the joint fit.
    pub(super) fn is_joining(&self) -> bool {
        self.stage == BirthStage::Join
    }

    /// Moves the places. After a long motion the readings are others, and a pause ends.
    pub(super) fn translate(&mut self, by: Point) {
        if by.norm() > SHORT_MOTION_M {
            self.pause = 0;
        }
        for end in self.candidates.as_flattened_mut() {
            *end = *end + by;
        }
    }

    /// Ends a birth without a segment.
    fn abandon(&mut self) {
        self.pause = PAUSE_STEPS;
        self.stage = BirthStage::Rank;
        self.candidates.clear();
    }

    /// Adds what runs to a digest.
    pub(super) fn update(&self, digest: &mut Digest) {
        digest.update(self.stage as u32);
        for end in self.candidates.as_flattened() {
            digest.update(end.x.to_bits());
            digest.update(end.y.to_bits());
        }
    }
}

/// A reading of the window with what the segments return there.
pub(super) struct Explained<'f> {
    pub(super) placed: Placed,
    pub(super) measured: &'f LogReading,
    pub(super) signal: f32,
    pub(super) cost: f32,
}

pub(super) type ExplainedReadings<'f> = Vec<Explained<'f>, { MAX_WINDOW * SENSORS }>;

impl<'f> SegmentFit<'f> {
    /// Does the next part of a birth; the segment that made room for a new one, if there
    /// is a new one and it needed room.
    #[inline(never)]
    pub(super) fn advance_birth(
        &self,
        birth: &mut Birth,
        segments: &mut TrackedSegments,
        system: &mut System,
    ) -> Option<TrackedSegment> {
        match birth.stage {
            BirthStage::Rank if birth.pause > 0 => {
                birth.pause -= 1;
                None
            }
            BirthStage::Rank => {
                if has_room(segments) {
                    self.rank_candidates(birth, segments);
                }
                None
            }
            BirthStage::Fit => {
                self.fit_candidates(birth, segments, system);
                None
            }
            BirthStage::Join => {
                let evicted = birth
                    .candidates
                    .first()
                    .and_then(|wall| self.join(birth.next_id, wall, segments, system));
                birth.abandon();
                let evicted = evicted?;
                birth.pause = 0;
                birth.next_id = birth.next_id.wrapping_add(1);
                evicted
            }
        }
    }

    /// The first part of a birth. Apart from the others, which need the stack.
    #[inline(never)]
    fn rank_candidates(&self, birth: &mut Birth, segments: &[TrackedSegment]) {
        if let Some((placed, missing)) = self.unexplained(segments) {
            let readings = self.explained(segments, RANK_STRIDE);
            let ranked = self.rank(&readings, &placed, missing);
            birth.candidates = ranked.into_iter().flatten().map(|it| it.1).collect();
            birth.stage = BirthStage::Fit;
        }
    }

    /// The second part of a birth.
    #[inline(never)]
    fn fit_candidates(&self, birth: &mut Birth, segments: &[TrackedSegment], system: &mut System) {
        let readings = self.explained(segments, 1);
        let mut best: Option<(f32, Wall)> = None;
        for wall in &birth.candidates {
            let mut new = [TrackedSegment::new(birth.next_id, *wall)];
            let change = self.fit_alone(&readings, segments, &mut new, system);
            if best.is_none_or(|(least, _)| change < least) {
                let [new] = new;
                best = Some((change, new.ends));
            }
        }
        let least = -LEAST_SHARE * self.model.parameters.birth_gain;
        birth.abandon();
        if let Some((change, wall)) = best
            && change < least
        {
            let _ = birth.candidates.push(wall);
            birth.stage = BirthStage::Join;
        }
    }

    /// The readings of every so many steps of the window, with what the segments return
    /// there.
    #[inline(never)]
    fn explained(&self, segments: &[TrackedSegment], stride: usize) -> ExplainedReadings<'f> {
        let parameters = &self.model.parameters;
        let mut readings = Vec::new();
        let rows: &'f [StepReadings] = self.rows;
        for row in rows.iter().rev().step_by(stride) {
            for (mount, measured) in self.model.mounts.iter().zip(&row.measured) {
                if measured.inverse_sigma <= 0.0 {
                    continue;
                }
                let placed = row.place(mount);
                let signal = self.model.law.signal(&seen(&placed, segments, None));
                let residual = measured.residual(signal, parameters);
                let _ = readings.push(Explained {
                    placed,
                    measured,
                    signal,
                    cost: huber(residual, parameters.huber).0,
                });
            }
        }
        readings
    }

    /// The sensor with the most unexplained chi^2 over the last steps, where it is now,
    /// and its missing signal.
    #[inline(never)]
    fn unexplained(&self, segments: &[TrackedSegment]) -> Option<(Placed, f32)> {
        let parameters = &self.model.parameters;
        let newest = self.rows.last()?;
        let steps = usize::from(parameters.unexplained_steps);
        let mut most: Option<(f32, Placed, f32)> = None;
        for (sensor, mount) in self.model.mounts.iter().enumerate() {
            let mut sum = 0.0;
            let mut missing = 0.0;
            for row in self.rows.iter().rev().take(steps) {
                let Some(measured) = row.measured.get(sensor) else {
                    continue;
                };
                if measured.inverse_sigma <= 0.0 {
                    continue;
                }
                let placed = row.place(mount);
                let signal = self.model.law.signal(&seen(&placed, segments, None));
                let residual = measured.residual(signal, parameters).max(0.0);
                sum += residual * residual;
                if core::ptr::eq(row, newest) {
                    missing = measured.signal - signal;
                }
            }
            let is_most = most.is_none_or(|(other, ..)| sum > other);
            if sum > parameters.unexplained && missing > 0.0 && is_most {
                most = Some((sum, newest.place(mount), missing));
            }
        }
        most.map(|(_, placed, missing)| (placed, missing))
    }

    /// Fits a new segment with the others held; the change of the cost that it makes.
    #[inline(never)]
    fn fit_alone(
        &self,
        readings: &ExplainedReadings<'_>,
        others: &[TrackedSegment],
        new: &mut [TrackedSegment; 1],
        system: &mut System,
    ) -> f32 {
        self.descend(new, ALONE_ITERATIONS, system, &mut |new, system| {
            new.first().map_or(0.0, |new| {
                self.assemble_alone(readings, others, new, system)
            })
        })
    }

    /// The normal equations of one segment with the others held, and the change of the
    /// cost by it.
    #[inline(never)]
    fn assemble_alone(
        &self,
        readings: &ExplainedReadings<'_>,
        others: &[TrackedSegment],
        new: &TrackedSegment,
        system: &mut System,
    ) -> f32 {
        let parameters = &self.model.parameters;
        let law = &self.model.law;
        system.clear(COORDINATES);
        let mut change = 0.0;
        for reading in readings {
            let own = reading.placed.see(&new.ends);
            if !law.may_see(&own) {
                continue;
            }
            let mut walls = seen(&reading.placed, others, None);
            let place = walls.len();
            let _ = walls.push(own);
            let seen = law.signal_and_gradient(&walls);
            let residual = reading.measured.residual(seen.signal, parameters);
            let (cost, weight) = huber(residual, parameters.huber);
            change += cost - reading.cost;
            let factor = -reading.measured.inverse_sigma / (seen.signal + parameters.soft_counts);
            if let Some(gradient) = seen.gradient.get(place) {
                let values = slope(&reading.placed, new, gradient, factor);
                system.add(&[Slope { first: 0, values }], residual, weight);
            }
        }
        self.add_prior(new, 0, system);
        change + new.prior_cost(parameters)
    }

    /// Fits a new segment and the others together, and keeps it if that saves enough;
    /// what made room for it then.
    #[inline(never)]
    fn join(
        &self,
        id: u16,
        wall: &Wall,
        segments: &mut TrackedSegments,
        system: &mut System,
    ) -> Option<Option<TrackedSegment>> {
        let parameters = &self.model.parameters;
        let before = self.cost(segments);
        let mut with = segments.clone();
        let evicted = make_room(&mut with);
        with.push(TrackedSegment::new(id, *wall)).ok()?;
        let after = self.refine(&mut with, parameters.birth_iterations, system);
        (before - after > parameters.birth_gain).then(|| {
            *segments = with;
            evicted
        })
    }
}

/// Whether there is a place for a new segment, or one that is frozen and could make room.
fn has_room(segments: &TrackedSegments) -> bool {
    segments.len() < MAX_SEGMENTS || segments.iter().any(|segment| segment.is_frozen)
}

/// Takes out the frozen segment with the least evidence if there is no place for another.
fn make_room(segments: &mut TrackedSegments) -> Option<TrackedSegment> {
    if segments.len() < MAX_SEGMENTS {
        return None;
    }
    let frozen = segments.iter().enumerate().filter(|(_, s)| s.is_frozen);
    let least = frozen.min_by(|(_, a), (_, b)| a.evidence.total_cmp(&b.evidence));
    take(segments, least.map(|(index, _)| index)?)
}

/// Takes a segment out; the order of the others stays.
#[inline(never)]
pub(super) fn take(segments: &mut TrackedSegments, index: usize) -> Option<TrackedSegment> {
    let taken = segments.get(index).copied();
    let mut place = 0;
    segments.retain(|_| {
        place += 1;
        place != index + 1
    });
    taken
}
