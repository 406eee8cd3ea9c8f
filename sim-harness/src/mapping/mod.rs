//! Grids, and the mappers that fill them from the records of a drive.
//!
//! A mapper takes records only, never a filter's insides: a map from a board and a map
//! from a host are the same map. A mapper turns a record into [`Evidence`] about cells;
//! a [`Calculus`] holds the evidence of a cell and gives the [`Belief`] that follows.

mod all_free;
mod approximate_likelihood;
mod beam_particles;
mod bearing_bins;
mod belief;
mod calculus;
mod cone_readings;
mod consistent_echoes;
mod counting;
mod evidence;
mod finish_progress;
mod footprint;
mod grid;
mod inverse_sensor;
mod layers;
mod likelihood_map;
mod mapped_wall;
mod methods;
mod near_range;
#[cfg(test)]
mod random_scans;
mod range_sensor_layer;
mod scan_returns;
#[cfg(test)]
mod test_drives;
#[cfg(test)]
mod toy_scene;
mod wall_map;

pub use all_free::AllFreeMapper;
pub use approximate_likelihood::{ApproximateLikelihoodMapper, EchoFilter};
pub use beam_particles::{BeamForm, BeamMapper};
pub use bearing_bins::{BearingBinMapper, BearingBinParameters};
pub use belief::{Belief, Occupancy};
pub use calculus::{Calculus, Counts, Evidence, LogOdds};
pub use consistent_echoes::{ConsistentEchoMapper, EchoJudgement};
pub use counting::CountingMapper;
pub use evidence::{
    Bayes, BoxMapper, Complements, ConeEvidenceMapper, ConePlace, DempsterShafer, Fuzzy, Masses,
    Memberships, SonarModel, safe_membership,
};
pub use finish_progress::FinishProgress;
pub use footprint::FootprintMapper;
pub use grid::{Grid, MAX_CELLS};
pub use inverse_sensor::{InverseSensorMapper, InverseSensorParameters, NoEcho};
pub use layers::{Fused, Fusion, LayerMapper, LayerParameters, SensorLayer};
pub use likelihood_map::{
    LikelihoodMapper, LikelihoodParameters, MaximumReading, Objective, Reach, Sweep,
};
pub use mapped_wall::MappedWall;
pub use methods::{Method, MissingSensors, SensorChoice, Setup, UnknownMethod};
pub use near_range::{NearRangeMapper, NearRangeParameters};
pub use range_sensor_layer::{RangeLayerMapper, RangeLayerParameters};
pub(crate) use scan_returns::mount_returns;
pub use wall_map::{
    RingGainFit, RingGains, SegmentMapper, SensorGain, WallMapParameters, WallMapper,
};

use crate::drive::Record;
use crate::lattice::Lattice;

/// Makes a map of a drive's records.
pub trait Mapper {
    /// Takes the next record; one that is no evidence is passed over.
    fn take(&mut self, record: &Record);

    /// Ends the drive: the work of methods that need all records first. `progress` is
    /// called as it goes on.
    fn finish(&mut self, _progress: &mut dyn FnMut(FinishProgress)) {}

    /// The map so far.
    fn map(&self) -> Map;

    /// Whether the map grows during the drive; false for a method that makes it in
    /// [`finish`](Self::finish), so that a map before that is none.
    fn is_online(&self) -> bool {
        true
    }

    /// The straight walls that the method has fitted so far; none for a method of cells.
    fn walls(&self) -> &[MappedWall] {
        &[]
    }
}

impl<M: Mapper + ?Sized> Mapper for Box<M> {
    fn take(&mut self, record: &Record) {
        (**self).take(record);
    }

    fn finish(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        (**self).finish(progress);
    }

    fn map(&self) -> Map {
        (**self).map()
    }

    fn is_online(&self) -> bool {
        (**self).is_online()
    }

    fn walls(&self) -> &[MappedWall] {
        (**self).walls()
    }
}

/// A map: the belief in each cell.
pub type Map = Grid<Belief>;

impl Map {
    /// A map of unknown cells.
    #[must_use]
    pub fn unknown(lattice: impl Into<Lattice>) -> Self {
        Self::new(lattice, Belief::UNKNOWN)
    }

    /// Number of cells of a class.
    #[must_use]
    pub fn count(&self, wanted: Occupancy) -> usize {
        self.cells_of(wanted).count()
    }

    /// The cells of a class, row by row.
    pub fn cells_of(&self, wanted: Occupancy) -> impl Iterator<Item = crate::lattice::Cell> {
        let cells = self.iter();
        cells.filter_map(move |(cell, belief)| (belief.occupancy() == wanted).then_some(cell))
    }

    /// The class of the cell that holds a point of the world; as
    /// [`occupancy`](Self::occupancy), and unknown for NaN and points absurdly far away.
    #[must_use]
    pub fn occupancy_at(&self, x: f64, y: f64) -> Occupancy {
        let cell = self.cell_at(x, y);
        cell.map_or(Occupancy::Unknown, |cell| self.occupancy(cell))
    }

    /// The class of a cell; unknown for one that the grid does not store.
    #[must_use]
    pub fn occupancy(&self, cell: crate::lattice::Cell) -> Occupancy {
        self.get(cell)
            .map_or(Occupancy::Unknown, |belief| belief.occupancy())
    }
}
