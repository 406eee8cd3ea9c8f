//! The filter of echoes that contradict each other, after Carvalho and Ventura 2013.
//!
//! An echo places an obstacle somewhere on its arc O. Where other echoes found all of the
//! arc free (their wedges E cover it), one side is wrong: a specular reflection is too long,
//! and its wedge passes through the wall. The filter decides by the sound pressure (see
//! [`SoundPressure`]) which side goes:
//!
//! ```text
//! repeat
//!   for each echo t, by time, whose arc is not empty and covered by wedges of kept echoes:
//!     for each cell of its arc: N = the kept echoes with the cell in their wedge
//!       if SP_t >= SP_j in the cell for all j in N: the obstacle is here, all N are bad
//!     remove the bad echoes; if there is none, remove t
//! until nothing was removed
//! ```
//!
//! Each round removes an echo or is the last. Afterwards no arc is covered.

mod mapper;
mod sound_pressure;

pub use mapper::ConsistentEchoMapper;

use super::cone_readings::{CellIndex, ConeReading, ConeReadings};
use sound_pressure::SoundPressure;

/// Which echoes are kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EchoJudgement {
    /// Of each reading, whether it is kept.
    pub(super) is_kept: Vec<bool>,
    /// Number of echoes that are kept.
    pub kept: usize,
    /// Number of echoes removed because all their arc is free.
    pub removed_arcs: usize,
    /// Number of echoes removed because an obstacle lies in their wedge.
    pub removed_wedges: usize,
    /// Number of rounds, with the last one, that removes nothing.
    pub rounds: usize,
}

/// Judges the echoes of a store; readings without an echo are kept and judge nothing.
///
/// Cost: for each covered arc the readings of its cells. The order of the readings matters
/// only within one stamp.
pub(super) fn judge(readings: &ConeReadings) -> EchoJudgement {
    let mut trial = Trial::new(readings);
    let by_time = readings.by_time();
    let mut judgement = EchoJudgement::default();
    loop {
        judgement.rounds += 1;
        let is_covered = |number: &usize| trial.is_covered(*number);
        let covered: Vec<usize> = by_time.iter().copied().filter(is_covered).collect();
        let before = judgement.removed_arcs + judgement.removed_wedges;
        for number in covered {
            // An earlier removal may have settled it.
            if !trial.is_covered(number) {
                continue;
            }
            let bad = trial.wedges_over_obstacles(number);
            if bad.is_empty() {
                trial.remove(number);
                judgement.removed_arcs += 1;
            }
            judgement.removed_wedges += bad.len();
            bad.into_iter().for_each(|wedge| trial.remove(wedge));
        }
        if judgement.removed_arcs + judgement.removed_wedges == before {
            break;
        }
    }
    judgement.is_kept = trial.is_kept;
    let kept = readings.readings().iter().zip(&judgement.is_kept);
    judgement.kept = kept.filter(|(it, is_kept)| it.is_echo && **is_kept).count();
    judgement
}

/// The echoes that are left, and how many of their wedges hold each cell.
struct Trial<'a> {
    readings: &'a ConeReadings,
    index: CellIndex,
    pressures: Vec<SoundPressure>,
    is_kept: Vec<bool>,
    wedges: Vec<u32>,
}

impl<'a> Trial<'a> {
    fn new(readings: &'a ConeReadings) -> Self {
        let all = readings.readings();
        let mut wedges = vec![0; readings.cells().len()];
        for reading in all.iter().filter(|reading| reading.is_echo) {
            for pair in reading.before() {
                wedges[readings.cell(pair)] += 1;
            }
        }
        let pressure = |reading: &ConeReading| SoundPressure::of(&reading.cone);
        Self {
            readings,
            index: readings.index(|number| all[number].is_echo),
            pressures: all.iter().map(pressure).collect(),
            is_kept: vec![true; all.len()],
            wedges,
        }
    }

    /// Whether an echo is kept and other wedges cover all of its arc.
    fn is_covered(&self, number: usize) -> bool {
        let mut arc = self.readings.readings()[number].at_echo();
        self.is_kept[number]
            && !arc.is_empty()
            && arc.all(|pair| self.wedges[self.readings.cell(pair)] > 0)
    }

    /// The wedges over the cells of an arc in which an obstacle lies by the sound pressure.
    fn wedges_over_obstacles(&self, number: usize) -> Vec<usize> {
        let mut bad = Vec::new();
        for pair in self.readings.readings()[number].at_echo() {
            let pressure = self.pressure(number, pair);
            let cell = self.readings.cell(pair);
            let wedges = || {
                let of_cell = self.index.of_cell(cell);
                of_cell.filter(|(wedge, pair)| {
                    self.is_kept[*wedge] && self.readings.readings()[*wedge].before().contains(pair)
                })
            };
            if wedges().all(|(wedge, pair)| pressure >= self.pressure(wedge, pair)) {
                bad.extend(wedges().map(|(wedge, _)| wedge));
            }
        }
        bad.sort_unstable();
        bad.dedup();
        bad
    }

    /// The sound pressure of a reading in the cell of a pair.
    fn pressure(&self, number: usize, pair: usize) -> f64 {
        let reading = &self.readings.readings()[number];
        let bearing_rad = self.readings.bearing_rad(reading, pair);
        self.pressures[number].at(self.readings.range_m(pair), bearing_rad)
    }

    fn remove(&mut self, number: usize) {
        self.is_kept[number] = false;
        for pair in self.readings.readings()[number].before() {
            self.wedges[self.readings.cell(pair)] -= 1;
        }
    }
}

#[cfg(test)]
mod tests;
