//! Draws walls as a map: occupied where the readings need a wall, free where they would
//! show one.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use super::readings::SignalRow;
use super::scene::WallScene;
use crate::geometry::Vector;
use crate::lattice::{Cell, Lattice};
use crate::mapping::{Belief, FinishProgress, Map};
use crate::sensors::WallSegment;

/// Farthest from a sensor that a cell is tested for being free, metres.
const FREE_REACH_M: f64 = 0.3;

/// Part of the way to a place that must be free of walls for the place to be visible: the
/// wall on which the place lies does not hide it.
const VISIBLE_SHARE: f64 = 0.999;

/// Rounding that is forgiven where places are sorted out by the cosine of their bearing.
const EDGE_ROUNDING: f64 = 1e-9;

impl WallScene<'_> {
    /// The map, with cells of the given size, metres.
    pub(super) fn draw(&self, lattice: Lattice, progress: &mut dyn FnMut(FinishProgress)) -> Map {
        let mut map = Map::unknown(lattice);
        let lattice = map.lattice();
        let rows = self.rows_in_reach(lattice);
        for (done, (row, spans)) in rows.iter().enumerate() {
            progress(FinishProgress {
                stage: "rows drawn",
                done,
                of: rows.len(),
            });
            for column in spans.iter().cloned().flatten() {
                let cell = Cell { row: *row, column };
                let (x, y) = lattice.centre(cell);
                if self.is_free(Vector::new(x, y))
                    && let Some(belief) = map.reach(cell)
                {
                    *belief = Belief::of_probability(0.0);
                }
            }
        }
        for index in self.indices() {
            for place in self.needed_pieces(index) {
                if let Some(belief) = map.reach_at(place.x, place.y) {
                    *belief = Belief::of_probability(1.0);
                }
            }
        }
        map
    }

    /// The middles of the pieces of a wall that the readings need.
    fn needed_pieces(&self, index: usize) -> Vec<Vector> {
        let Some(wall) = self.wall(index) else {
            return Vec::new();
        };
        let pieces = (wall.length_m() / self.parameters.piece_m).ceil().max(1.0) as u32;
        let length_m = wall.length_m() / f64::from(pieces);
        let stations = self.readings.near(&wall, self.parameters.reach_m);
        let middle = |piece: u32| wall.at((f64::from(piece) + 0.5) / f64::from(pieces));
        (0..pieces)
            .map(middle)
            .filter(|place| {
                let chi2 = self.chi2_of_piece(&wall, *place, length_m, &stations);
                chi2 > self.parameters.occupied_chi2
            })
            .collect()
    }

    /// What the readings change by without a piece of a wall, as if the tested length were
    /// removed, chi^2.
    fn chi2_of_piece(
        &self,
        wall: &WallSegment,
        place: Vector,
        length_m: f64,
        stations: &[usize],
    ) -> f64 {
        let way = wall.to - wall.from;
        let normal = Vector::new(-way.y, way.x).scaled(1.0 / way.norm());
        let many = self.parameters.tested_m / length_m;
        let mut chi2 = 0.0;
        for station in stations {
            for (row, expected) in self.rows_of(*station) {
                let Some(facing) = self.facing(row, place) else {
                    continue;
                };
                let ray = place - row.world_from_sensor.position;
                let range_m = ray.norm();
                let incidence = (normal.dot(ray) / range_m).abs();
                // The piece's width as seen from the sensor is length cos(i) / d.
                let piece = facing * incidence * incidence * length_m / range_m;
                if piece * many < 1e-3 || !self.is_visible(*station, row, place) {
                    continue;
                }
                let without = (expected - many * piece).max(0.0);
                let change = self.change_of_residual(row, expected, without);
                chi2 += change * change;
            }
        }
        chi2
    }

    /// The rows of cells in reach of a station, each with its columns: spans in order that
    /// do not touch.
    fn rows_in_reach(&self, lattice: Lattice) -> BTreeMap<i32, Vec<RangeInclusive<i32>>> {
        let mut rows: BTreeMap<i32, Vec<RangeInclusive<i32>>> = BTreeMap::new();
        for station in &self.readings.stations {
            let Vector { x, y } = station.world_from_body.position;
            let low = lattice.cell_at(x - FREE_REACH_M, y - FREE_REACH_M);
            let high = lattice.cell_at(x + FREE_REACH_M, y + FREE_REACH_M);
            if let (Some(low), Some(high)) = (low, high) {
                for row in low.row..=high.row {
                    let spans = rows.entry(row).or_default();
                    spans.push(low.column..=high.column);
                }
            }
        }
        rows.into_iter()
            .map(|(row, spans)| (row, joined(spans)))
            .collect()
    }

    /// Whether a surface at a place would show and is not there.
    fn is_free(&self, place: Vector) -> bool {
        let point = WallSegment::new(place, place);
        let stations = self.readings.near(&point, FREE_REACH_M);
        let (mut chi2, mut rise) = (0.0, 0.0);
        for station in &stations {
            let is_in_band = |(_, wall): (usize, WallSegment)| {
                place.distance_from_segment(wall.from, wall.to) < self.parameters.band_m
            };
            if self.walls_at(*station).any(is_in_band) {
                return false;
            }
            for (row, expected) in self.rows_of(*station) {
                let Some(with) = self.with_patch(*station, row, place, expected) else {
                    continue;
                };
                let change = self.change_of_residual(row, expected, with);
                chi2 += change * change;
                rise += self.cost_at(row, with) - self.cost_at(row, expected);
            }
        }
        chi2 > self.parameters.free_chi2 && rise > 0.0
    }

    /// The signal of a reading with a surface of the tested width at a place, square to the
    /// sensor; it hides what lies behind it. `None` where it does not show.
    fn with_patch(
        &self,
        station: usize,
        row: &SignalRow,
        place: Vector,
        expected: f64,
    ) -> Option<f64> {
        let facing = self.facing(row, place)?;
        if !self.is_visible(station, row, place) {
            return None;
        }
        let sensor = row.world_from_sensor.position;
        let range_m = (place - sensor).norm();
        let width_rad = self.parameters.tested_m / range_m;
        let mut behind = 0.0_f64;
        for (_, wall) in self.walls_at(station) {
            let ray = place - sensor;
            if let Some(times) = times_to(sensor, ray, &wall) {
                let way = wall.to - wall.from;
                let incidence = (way.cross(ray) / (way.norm() * range_m)).abs();
                behind = behind.max(facing * incidence / (times * times));
            }
        }
        Some((expected + (facing - behind) * width_rad).max(0.0))
    }

    /// Return per radian of a surface at a place square to the sensor, counts; `None`
    /// outside the lobe.
    fn facing(&self, row: &SignalRow, place: Vector) -> Option<f64> {
        let law = self.readings.law(row.mount)?;
        let seen = row.world_from_sensor.view(place);
        // Far fewer arc tangents: most places lie outside of most lobes.
        let least_cosine = self.readings.edge_cosine(row.mount) - EDGE_ROUNDING;
        if seen.x <= 0.0 || seen.x < least_cosine * seen.norm() {
            return None;
        }
        let bearing_rad = libm::atan2(seen.y, seen.x);
        (bearing_rad.abs() < law.edge_rad())
            .then(|| self.gain(row.mount) * law.facing_counts_per_rad(bearing_rad, seen.norm()))
    }

    /// Whether no wall lies between a sensor and a place.
    fn is_visible(&self, station: usize, row: &SignalRow, place: Vector) -> bool {
        let sensor = row.world_from_sensor.position;
        self.walls_at(station).all(|(_, wall)| {
            times_to(sensor, place - sensor, &wall).is_none_or(|times| times >= VISIBLE_SHARE)
        })
    }

    fn change_of_residual(&self, row: &SignalRow, expected: f64, other: f64) -> f64 {
        let floor = self.parameters.floor_counts;
        row.residual(other, floor) - row.residual(expected, floor)
    }
}

/// The spans of columns that cover the same columns in order, without touching.
fn joined(mut spans: Vec<RangeInclusive<i32>>) -> Vec<RangeInclusive<i32>> {
    spans.sort_unstable_by_key(|span| *span.start());
    let mut joined: Vec<RangeInclusive<i32>> = Vec::new();
    for span in spans {
        match joined.last_mut() {
            Some(last) if *span.start() <= last.end().saturating_add(1) => {
                *last = *last.start()..=*last.end().max(span.end());
            }
            _ => joined.push(span),
        }
    }
    joined
}

/// Where a ray meets a wall, as a multiple of the ray.
fn times_to(from: Vector, ray: Vector, wall: &WallSegment) -> Option<f64> {
    let way = wall.to - wall.from;
    let across = ray.cross(way);
    let to_wall = wall.from - from;
    let times = to_wall.cross(way) / across;
    let share = to_wall.cross(ray) / across;
    (times > 0.0 && (0.0..=1.0).contains(&share)).then_some(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_that_touch_are_one() {
        let spans = vec![7..=9, 1..=3, 4..=5, 2..=3, 8..=8];
        assert_eq!(joined(spans), [1..=5, 7..=9]);
        assert_eq!(joined(Vec::new()), []);
    }
}
