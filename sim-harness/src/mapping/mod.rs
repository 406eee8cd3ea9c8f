//! Grids, and the mappers that fill them from decoded events.
//!
//! A mapper reads events only, never a filter's insides: a map from a board and a map
//! from a host are the same map.

mod all_free;
mod carving;
mod counting;
mod footprint;
mod grid;
mod inverse_sensor;
mod lattice;
mod lobes;
mod methods;
mod range_inverse_sensor;

pub use all_free::AllFreeMapper;
pub use counting::CountingMapper;
pub use footprint::{FootprintMapper, hull_radius_m};
pub use grid::{Cell, Grid, MAX_CELLS};
pub use inverse_sensor::{InverseSensorMapper, InverseSensorParameters, MaxRange};
pub use lattice::Lattice;
pub use methods::{RANGE_METHODS, RangeMethod};
pub use range_inverse_sensor::{RangeInverseSensorMapper, RangeInverseSensorParameters};

use amiro_ipf::node::Event;

/// Makes a map of a run's events.
pub trait Mapper {
    /// Takes the next event; what says nothing about the world is passed over.
    fn take(&mut self, event: &Event);

    /// The map so far.
    fn map(&self) -> Map;
}

impl<M: Mapper + ?Sized> Mapper for Box<M> {
    fn take(&mut self, event: &Event) {
        (**self).take(event);
    }

    fn map(&self) -> Map {
        (**self).map()
    }
}

/// A finished map: the probability that a cell is occupied; 0.5 is unknown.
pub type Map = Grid<f32>;

/// What a map says about a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupancy {
    /// p_occ below 0.5.
    Free,
    /// p_occ above 0.5.
    Occupied,
    /// p_occ of exactly 0.5: never touched, or as much for as against.
    Unknown,
}

impl Occupancy {
    /// The class of a probability; NaN is unknown.
    #[must_use]
    pub fn of(p_occ: f32) -> Self {
        if p_occ > 0.5 {
            Self::Occupied
        } else if p_occ < 0.5 {
            Self::Free
        } else {
            Self::Unknown
        }
    }
}
