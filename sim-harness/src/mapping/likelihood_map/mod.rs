//! The map under which the readings are most likely (Carvalho and Ventura 2013, section III).
//!
//! The other methods judge a reading cell by cell. This one asks of a whole map of occupied
//! and free cells how likely each reading is in it, and looks for the map of greatest
//! likelihood. With the occupied cells of a reading's cone, from near to far:
//!
//! ```text
//! cluster k   cells whose distances from the mean are below the gap; d_k is their mean
//! h_k         h_min + (h_max - h_min) times the share of the cone's bearings that they cover
//! l(M)        sum over the readings of ln(L_* + sum over k of L_k)      see ForwardModel
//! ```
//!
//! The paper raises l(M) by "expectation maximisation" over the cause of each reading. Taken
//! literally that cannot leave the empty map: no obstacle is responsible for any reading
//! there. The search here flips one cell after the other and keeps what raises l(M), so that
//! l(M) never decreases. It starts in the empty map: from a map that is occupied everywhere
//! it does not come back.

mod forward_model;
mod parameters;
mod search;

pub use parameters::{LikelihoodParameters, MaximumReading, Objective, Reach};

use super::approximate_likelihood::EchoFilter;
use super::cone_readings::{ConeReadings, ReadingSelection};
use super::consistent_echoes::EchoJudgement;
use super::{FinishProgress, Map, Mapper};
use crate::drive::Record;
use crate::lattice::Lattice;
use crate::rig::Rig;
use search::Search;

/// One sweep of the search over all cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Cells that were flipped.
    pub flips: usize,
    /// Logarithm of the likelihood of all readings afterwards, l(M).
    pub log_likelihood: f64,
}

/// Searches the map of greatest likelihood at the end of a drive (forward sensor model, FSM).
///
/// A cell in the cone of a used reading is occupied or free, p_occ 1 or 0; others are
/// unknown. There is no map before [`finish`](Mapper::finish). Cost: each sweep evaluates
/// every (cell, reading) pair at most twice, with the occupied cells of the reading's cone.
#[derive(Clone, Debug)]
pub struct LikelihoodMapper {
    readings: ConeReadings,
    parameters: LikelihoodParameters,
    filter: EchoFilter,
    judgement: EchoJudgement,
    start: f64,
    sweeps: Vec<Sweep>,
    map: Option<Map>,
}

impl LikelihoodMapper {
    /// A mapper for the sensors of a rig.
    ///
    /// # Panics
    /// If `p_random` is not above 0: the logarithm of a reading's likelihood could be
    /// infinite.
    #[must_use]
    pub fn new(
        lattice: impl Into<Lattice>,
        rig: &Rig,
        filter: EchoFilter,
        parameters: LikelihoodParameters,
    ) -> Self {
        assert!(parameters.p_random > 0.0, "p_random must be above 0");
        let lattice = lattice.into();
        let reach_cells = match parameters.reach {
            Reach::Cell => 0.0,
            Reach::Sigmas(sigmas) => sigmas * parameters.sigma_cells,
        };
        let selection = ReadingSelection {
            tolerance_m: lattice.cell_m(),
            reach_m: reach_cells * lattice.cell_m(),
            takes_no_echo: parameters.maximum == MaximumReading::Evidence,
        };
        Self {
            readings: ConeReadings::new(lattice, rig, selection),
            parameters,
            filter,
            judgement: EchoJudgement::default(),
            start: 0.0,
            sweeps: Vec::new(),
            map: None,
        }
    }

    /// Logarithm of the likelihood of all readings in the empty map; 0 before the end.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// The sweeps of the search; none before the end of the drive.
    #[must_use]
    pub fn sweeps(&self) -> &[Sweep] {
        &self.sweeps
    }
}

impl Mapper for LikelihoodMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            self.readings.add(scan);
        }
    }

    fn finish(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        self.judgement = self.filter.judge(&self.readings);
        let by_time = self.readings.by_time();
        let mut search = Search::new(&self.readings, &self.judgement.is_kept, &self.parameters);
        self.start = search.log_likelihood();
        self.sweeps.clear();
        let of = self.parameters.sweeps as usize * by_time.len();
        for number in 0..self.parameters.sweeps as usize {
            let before = number * by_time.len();
            let sweep = search.sweep(&by_time, &mut |done| {
                progress(FinishProgress {
                    stage: "readings searched",
                    done: before + done,
                    of,
                });
            });
            self.sweeps.push(sweep);
            if sweep.flips == 0 {
                break;
            }
        }
        let cells = search.cells().into_iter();
        let p_occ = cells.map(|is_occupied| is_occupied.map(|it| f32::from(u8::from(it))));
        self.map = Some(self.readings.map(&p_occ.collect::<Vec<_>>()));
    }

    fn map(&self) -> Map {
        let blank = || self.readings.blank_map();
        self.map.clone().unwrap_or_else(blank)
    }

    fn is_online(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests;
