//! A map from layers of evidence.

use std::collections::BTreeSet;

use super::{Fused, Fusion, LayerParameters, SensorLayer};
use crate::drive::Record;
use crate::lattice::{Cell, Lattice};
use crate::mapping::{Belief, Map, Mapper};
use crate::rig::Rig;
use crate::sensors::SensorKind;

/// Fills a layer per kind of sensor and fuses them when the map is asked for.
///
/// Scans of other kinds are passed over. Memory: the grids of the layers.
#[derive(Clone, Debug)]
pub struct LayerMapper {
    rig: Rig,
    lattice: Lattice,
    layers: Vec<SensorLayer>,
    fusion: Fusion,
}

impl LayerMapper {
    /// A mapper with a layer per kind, in the given order; with one kind the rule makes no
    /// difference.
    #[must_use]
    pub fn new(
        lattice: impl Into<Lattice>,
        rig: &Rig,
        kinds: &[SensorKind],
        fusion: Fusion,
        parameters: LayerParameters,
    ) -> Self {
        let lattice = lattice.into();
        let layer = |kind: &SensorKind| SensorLayer::new(lattice, *kind, parameters);
        Self {
            rig: rig.clone(),
            lattice,
            layers: kinds.iter().map(layer).collect(),
            fusion,
        }
    }

    /// The layers.
    #[must_use]
    pub fn layers(&self) -> &[SensorLayer] {
        &self.layers
    }

    /// The kind of sensor whose layer supplied the value of a cell; `None` if none did.
    #[must_use]
    pub fn source(&self, cell: Cell) -> Option<SensorKind> {
        let index = self.fused(cell).source?;
        self.layers.get(index).map(SensorLayer::kind)
    }

    fn fused(&self, cell: Cell) -> Fused {
        let free: Vec<f64> = self.layers.iter().map(|layer| layer.free(cell)).collect();
        self.fusion.fuse(&free)
    }
}

impl Mapper for LayerMapper {
    fn take(&mut self, record: &Record) {
        if let Record::Scan(scan) = record {
            for layer in &mut self.layers {
                layer.add(&self.rig, scan);
            }
        }
    }

    fn map(&self) -> Map {
        let mut map = Map::unknown(self.lattice);
        let reached = self.layers.iter().flat_map(|layer| {
            let cells = layer.log_odds().iter();
            cells.filter_map(|(cell, log_odds)| (*log_odds != 0.0).then_some(cell))
        });
        for cell in reached.collect::<BTreeSet<_>>() {
            if let Some(belief) = map.reach(cell) {
                *belief = Belief::of_sum(1.0 - self.fused(cell).free);
            }
        }
        let refused: u64 = self.layers.iter().map(|it| it.log_odds().refused()).sum();
        (0..refused).for_each(|_| map.refuse());
        map
    }
}
