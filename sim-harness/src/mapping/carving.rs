//! Carving: the cells that a reading shows to be free by itself.

use std::collections::BTreeSet;

use amiro_ipf::node::{Config, StepBegun};

use super::Cell;
use super::lobes::{CellView, Lobes};

/// Finds the cells that some sensor sees past, by the filter's own side test.
#[derive(Clone, Debug)]
pub(super) struct Carver {
    lobes: Lobes,
    model_error_m: f64,
}

impl Carver {
    /// For the sensors and the model error of a configuration.
    pub(super) fn new(cell_m: f64, config: &Config) -> Self {
        Self {
            lobes: Lobes::of(config, cell_m),
            model_error_m: f64::from(config.parameters.model_error_m),
        }
    }

    /// The cells with r < x - 1 sigma for at least one sensor, sigma being that of
    /// reading and model together; each once. `None` if a lobe lies where no grid has
    /// cells.
    pub(super) fn seen_past(&self, step: &StepBegun) -> Option<BTreeSet<Cell>> {
        let mut cells = BTreeSet::new();
        let are_all_shown = self.lobes.show(step, |cell, view| {
            if self.is_seen_past(&view) {
                cells.insert(cell);
            }
        });
        are_all_shown.then_some(cells)
    }

    fn is_seen_past(&self, view: &CellView) -> bool {
        let variance = view.sigma_m * view.sigma_m + self.model_error_m * self.model_error_m;
        view.range_m < view.arc_m - variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::filter::Profile;
    use amiro_ipf::geometry::Pose;
    use amiro_ipf::model::{SENSORS, Sample};

    #[test]
    fn cells_before_the_arcs_are_carved_once_and_no_others() {
        let config = Config::amiro(Profile::Plus);
        let carver = Carver::new(0.01, &config);
        let step = |counts| StepBegun {
            index: 0,
            stamp_us: 0,
            pose: Pose::default(),
            samples: [Sample::Counts(counts); SENSORS],
        };
        let grid = crate::mapping::Grid::new(0.01, ());
        for cell in carver.seen_past(&step(78)).unwrap() {
            let (x, y) = grid.centre(cell);
            // 100 mm from hulls at 50 mm, less 8.4 mm of error.
            let from_centre_m = (x * x + y * y).sqrt();
            assert!(from_centre_m < 0.1417, "{from_centre_m} m");
        }
        // Circle between 50 and 141.6 mm: 551 cells, less what lies between the lobes.
        let count = carver.seen_past(&step(78)).unwrap().len();
        assert!((400..551).contains(&count), "{count}");
        assert!(carver.seen_past(&step(70_000)).unwrap().is_empty());
    }
}
