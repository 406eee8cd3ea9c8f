//! A map's scores against the truth, always several together.

use core::fmt;

use serde::Serialize;

use super::{Number, Truth};
use crate::lattice::Cell;
use crate::mapping::{Map, Occupancy};
use crate::world::Vector;

/// Wall expansions that are tried: 0, 5, ... 25 mm.
const EXPANSIONS: u8 = 6;
/// Distance between two of them, metres.
const EXPANSION_STEP_M: f64 = 0.005;
/// How near an occupied cell's centre must be to a piece of surface, metres.
const RECALL_M: f64 = 0.015;
/// Rounding that is forgiven in distances.
const ROUNDING_M: f64 = 1e-9;

/// How good a map is.
///
/// A low overall error alone is no evidence: a map that is free everywhere has one. The
/// rates show whether walls were found, recall whether their surfaces were, coverage
/// how much was decided at all. A ratio is `None` where its denominator is zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// Overall error at the best expansion: wrong cells over classified cells. A cell
    /// is wall within the expansion of a shape.
    pub oe: Option<f64>,
    /// The expansion with the least overall error, the smallest of equals, metres.
    pub best_expansion_m: f64,
    /// Overall error without wall expansion.
    pub oe_unexpanded: Option<f64>,
    /// True positive rate at the best expansion: share of the classified wall cells
    /// that are occupied.
    pub tpr: Option<f64>,
    /// False positive rate at the best expansion: share of the classified free cells
    /// that are occupied.
    pub fpr: Option<f64>,
    /// Informedness J (Youden 1950): true positive rate less false positive rate.
    pub j: Option<f64>,
    /// Share of the visible surface with the centre of an occupied cell within 15 mm.
    pub surface_recall: Option<f64>,
    /// Share of the visible free space that is classified, rightly or not.
    pub coverage: Option<f64>,
    /// Classified cells within the judged rectangle.
    pub cells: u64,
    /// Cells within the judged rectangle that are not classified.
    pub unknown: u64,
    /// Updates of cells that were refused because the map would exceed the limit; above
    /// zero, the map is cut and all scores are those of the part in the map.
    pub cells_refused: u64,
}

/// Classified cells by truth and verdict.
#[derive(Clone, Copy, Debug, Default)]
struct Confusion {
    wall_occupied: u64,
    wall_free: u64,
    free_occupied: u64,
    free_free: u64,
}

impl Confusion {
    fn count(&mut self, is_wall: bool, is_occupied: bool) {
        let counter = match (is_wall, is_occupied) {
            (true, true) => &mut self.wall_occupied,
            (true, false) => &mut self.wall_free,
            (false, true) => &mut self.free_occupied,
            (false, false) => &mut self.free_free,
        };
        *counter += 1;
    }

    fn wrong(&self) -> u64 {
        self.wall_free + self.free_occupied
    }

    fn oe(&self) -> Option<f64> {
        let right = self.wall_occupied + self.free_free;
        ratio(self.wrong(), right + self.wrong())
    }

    fn tpr(&self) -> Option<f64> {
        ratio(self.wall_occupied, self.wall_occupied + self.wall_free)
    }

    fn fpr(&self) -> Option<f64> {
        ratio(self.free_occupied, self.free_occupied + self.free_free)
    }
}

fn ratio(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// The meaning of a map's scores, one line each.
pub const SCORES_IN_WORDS: &str = "\
OE: overall error, the share of the classified cells that are wrong. Cells within 0 to 25 mm of
    a shape are wall; the expansion with the least error is taken, map by map, as in the paper.
Plain OE: the same with the walls as they are.
TPR, FPR: share of the classified wall cells, and of the classified free cells, that are
    occupied, at the expansion of OE. J: TPR less FPR.
Recall: share of the visible surface with an occupied cell within 15 mm.
Coverage: share of the visible free space that is classified.
all-free: the map that is free everywhere. Its error is low: no error says much alone.";

impl Scores {
    /// Judges a map.
    #[must_use]
    pub fn of(map: &Map, truth: &Truth) -> Self {
        let mut confusions = [Confusion::default(); EXPANSIONS as usize];
        let mut cells = 0;
        for (cell, belief) in map.iter() {
            let is_occupied = match belief.occupancy() {
                Occupancy::Unknown => continue,
                Occupancy::Occupied => true,
                Occupancy::Free => false,
            };
            let (x, y) = map.centre(cell);
            let centre = Vector::new(x, y);
            if !truth.is_judged(centre) {
                continue;
            }
            cells += 1;
            let distance_m = truth.distance_m(centre);
            for (step, confusion) in (0_u8..).zip(&mut confusions) {
                let is_wall = distance_m <= expansion_m(step) + ROUNDING_M;
                confusion.count(is_wall, is_occupied);
            }
        }
        let ranked = (0_u8..).zip(&confusions);
        let (best_step, best) = ranked
            .min_by_key(|(step, confusion)| (confusion.wrong(), *step))
            .map_or((0, Confusion::default()), |(step, best)| (step, *best));
        Self {
            oe: best.oe(),
            best_expansion_m: expansion_m(best_step),
            oe_unexpanded: confusions.first().and_then(Confusion::oe),
            tpr: best.tpr(),
            fpr: best.fpr(),
            j: best.tpr().zip(best.fpr()).map(|(tpr, fpr)| tpr - fpr),
            surface_recall: surface_recall(map, truth),
            coverage: coverage(map, truth),
            cells,
            unknown: judged_cells(map, truth).saturating_sub(cells),
            cells_refused: map.refused(),
        }
    }
}

fn expansion_m(step: u8) -> f64 {
    EXPANSION_STEP_M * f64::from(step)
}

/// Cells of the map's size whose centres lie in the judged rectangle.
fn judged_cells(map: &Map, truth: &Truth) -> u64 {
    let (corner_x, corner_y) = map.lattice().corner(Cell { row: 0, column: 0 });
    let count = |min: f64, max: f64| {
        // Centres are at (index + 0.5) cells.
        let first = (min / map.cell_m() - 0.5 - ROUNDING_M).ceil();
        let last = (max / map.cell_m() - 0.5 + ROUNDING_M).floor();
        (last - first + 1.0).max(0.0) as u64
    };
    let extent = truth.extent();
    count(extent.min.x - corner_x, extent.max.x - corner_x)
        * count(extent.min.y - corner_y, extent.max.y - corner_y)
}

fn surface_recall(map: &Map, truth: &Truth) -> Option<f64> {
    let found = truth
        .surface()
        .iter()
        .filter(|place| is_found(map, **place));
    ratio(found.count() as u64, truth.surface().len() as u64)
}

/// Whether the centre of an occupied cell lies near a place.
fn is_found(map: &Map, place: Vector) -> bool {
    let corner = |sign: f64| {
        let reach = sign * (RECALL_M + ROUNDING_M);
        map.cell_at(place.x + reach, place.y + reach)
    };
    let (Some(low), Some(high)) = (corner(-1.0), corner(1.0)) else {
        return false;
    };
    (low.row..=high.row)
        .flat_map(|row| (low.column..=high.column).map(move |column| Cell { row, column }))
        .filter(|cell| map.occupancy(*cell) == Occupancy::Occupied)
        .any(|cell| {
            let (x, y) = map.centre(cell);
            (Vector::new(x, y) - place).norm() <= RECALL_M + ROUNDING_M
        })
}

fn coverage(map: &Map, truth: &Truth) -> Option<f64> {
    let is_classified = |place: &&Vector| map.occupancy_at(place.x, place.y) != Occupancy::Unknown;
    let classified = truth.visible_free().iter().filter(is_classified);
    ratio(classified.count() as u64, truth.visible_free().len() as u64)
}

/// One line of fixed columns, which align over several maps.
impl fmt::Display for Scores {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let figure = |value, decimals| Number { value, decimals };
        let percent = |share: Option<f64>| figure(share.map(|share| 100.0 * share), 1);
        let share = |share| figure(share, 2);
        write!(
            f,
            "OE {:5} % (walls +{:2.0} mm)  plain OE {:5} %  TPR {:5}  FPR {:5}  J {:5}  \
             recall {:5}  coverage {:5}  classified {:6}  unknown {:6}",
            percent(self.oe),
            1000.0 * self.best_expansion_m,
            percent(self.oe_unexpanded),
            share(self.tpr),
            share(self.fpr),
            share(self.j),
            share(self.surface_recall),
            share(self.coverage),
            self.cells,
            self.unknown,
        )?;
        match self.cells_refused {
            0 => Ok(()),
            refused => write!(f, "  MAP CUT: {refused} updates of cells refused"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use crate::mapping::Belief;
    use crate::world::Scenario;

    /// A block before one sensor: 50 x 30 mm, 100 mm from the sensor.
    fn truth() -> Truth {
        let text = "name = \"d\"\ncell_m = 0.01\nextent_m = [-0.1, -0.1, 0.3, 0.1]\n\
            speed_m_per_s = 0.08\nsensors_deg = [0]\nstart = [0, 0, 0]\n\
            [[box]]\nmin = [0.15, -0.03]\nmax = [0.2, 0.03]\n";
        Truth::of(
            &Scenario::parse(text).unwrap(),
            &[Pose2::new(0.0, 0.0, 0.0)],
        )
    }

    /// A map of all judged cells and some beyond, filled by the place of a cell.
    fn map(p_occ: impl Fn(Vector) -> f32) -> Map {
        let mut map = Map::unknown(0.01);
        for row in -20..20 {
            for column in -20..40 {
                let cell = Cell { row, column };
                let (x, y) = map.centre(cell);
                *map.reach(cell).unwrap() = Belief::of_probability(p_occ(Vector::new(x, y)));
            }
        }
        map
    }

    fn close(value: Option<f64>, expected: f64) {
        assert!(
            (value.unwrap() - expected).abs() < 1e-12,
            "{value:?} is not {expected}"
        );
    }

    #[test]
    fn a_perfect_map_has_no_error() {
        let truth = truth();
        let scores = Scores::of(
            &map(|place| if truth.is_wall(place, 0.0) { 0.9 } else { 0.1 }),
            &truth,
        );
        close(scores.oe, 0.0);
        close(scores.oe_unexpanded, 0.0);
        assert!(scores.best_expansion_m < 1e-12);
        close(scores.tpr, 1.0);
        close(scores.fpr, 0.0);
        close(scores.j, 1.0);
        close(scores.surface_recall, 1.0);
        close(scores.coverage, 1.0);
        assert_eq!((scores.cells, scores.unknown), (800, 0));
    }

    #[test]
    fn an_all_free_map_has_a_small_error_and_finds_nothing() {
        let scores = Scores::of(&map(|_| 0.0), &truth());
        // 5 x 6 of 40 x 20 cells are wall.
        close(scores.oe, 30.0 / 800.0);
        close(scores.tpr, 0.0);
        close(scores.surface_recall, 0.0);
        close(scores.coverage, 1.0);
    }

    #[test]
    fn the_best_expansion_is_found_and_rates_are_taken_there() {
        let truth = truth();
        let mut thick = map(|place| {
            if truth.is_wall(place, 0.005) {
                1.0
            } else {
                0.0
            }
        });
        let scores = Scores::of(&thick, &truth);
        close(scores.oe, 0.0);
        assert!((scores.best_expansion_m - 0.005).abs() < 1e-12);
        // A ring of one cell without corners: 2 x 5 + 2 x 6 false cells.
        close(scores.oe_unexpanded, 22.0 / 800.0);
        // One ghost among 800 - 30 - 22 free cells.
        let ghost = thick.cell_at(0.005, 0.005).unwrap();
        *thick.reach(ghost).unwrap() = Belief::of_probability(0.8);
        let scores = Scores::of(&thick, &truth);
        close(scores.oe, 1.0 / 800.0);
        close(scores.fpr, 1.0 / 748.0);
        close(scores.j, 1.0 - 1.0 / 748.0);
    }

    #[test]
    fn an_empty_map_has_no_ratios() {
        let scores = Scores::of(&Map::unknown(0.01), &truth());
        assert_eq!((scores.oe, scores.tpr, scores.j), (None, None, None));
        close(scores.coverage, 0.0);
        assert_eq!((scores.cells, scores.unknown), (0, 800));
        let line = scores.to_string();
        assert!(
            line.contains("OE   n/a %") && !line.contains("NaN"),
            "{line}"
        );
    }

    #[test]
    fn the_line_shows_the_error_in_company() {
        let line = Scores::of(&map(|_| 0.0), &truth()).to_string();
        assert_eq!(
            line,
            "OE   3.8 % (walls + 0 mm)  plain OE   3.8 %  TPR  0.00  FPR  0.00  J  0.00  \
             recall  0.00  coverage  1.00  classified    800  unknown      0"
        );
    }
}
