//! The ground truth of a world and the part of it that is visible to the robot.

use std::collections::BTreeSet;

use amiro_ipf::filter::Profile;
use amiro_ipf::model::BeamPattern;

use crate::geometry::Pose2;
use crate::lattice::{Cell, Lattice};
use crate::world::{Rectangle, Scenario, SensorPose, Shape, Vector, first_surface};

/// Distance between places on outlines, metres.
const OUTLINE_SPACING_M: f64 = 0.005;
/// Share of the range limit within which a place counts as seen.
const SEEN_SHARE: f64 = 0.9;
/// Rounding that is forgiven in distances: block edges and cell centres lie on round
/// millimetres, so that "within 5 mm" is met exactly or not at all.
const ROUNDING_M: f64 = 1e-9;
/// A place on a surface is hidden if an object lies more than this before it, metres.
const HIDDEN_M: f64 = 1e-6;

/// The truth about a world, as far as it was visible from the places of the steps.
///
/// Visible: at one step at least, some sensor in use had the place within theta_max
/// of its axis, within 0.9 x_max S(theta) and with nothing in between. The lobe S
/// belongs to the limit: at 60 degrees a sensor reaches half as far as on its axis.
/// Without it, space counts as visible without any reading of it, and a map of the
/// block in `msod.toml` by the profile `plus` covers 94 instead of 98 %.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    shapes: Vec<Shape>,
    extent: Rectangle,
    surface: Vec<Vector>,
    /// The directions in which the surface places were first seen, unit vectors.
    seen_along: Vec<Vector>,
    free: Vec<Vector>,
}

impl Truth {
    /// The truth of a scenario, seen from the poses of the filter's steps.
    ///
    /// Cost: for each step and sensor all places within its view times all shapes
    /// near it; for the paper's scenarios some ten milliseconds.
    #[must_use]
    pub fn of(scenario: &Scenario, steps: &[Pose2]) -> Self {
        let mut witness = Witness::of(scenario);
        let mut truth = Self {
            shapes: scenario.shapes.clone(),
            extent: scenario.extent,
            surface: Vec::new(),
            seen_along: Vec::new(),
            free: Vec::new(),
        };
        let cells = Lattice::new(scenario.cell_m);
        let mut seen_cells = BTreeSet::new();
        for pose in steps {
            witness.stand_at(pose);
            witness.see_outlines(&mut truth);
            for cell in witness.cells_around(&cells) {
                if seen_cells.contains(&cell) {
                    continue;
                }
                let (x, y) = cells.centre(cell);
                let centre = Vector::new(x, y);
                if truth.is_judged(centre) && witness.sees(centre) {
                    seen_cells.insert(cell);
                    if !truth.is_wall(centre, 0.0) {
                        truth.free.push(centre);
                    }
                }
            }
        }
        truth
    }

    /// Whether a place lies in the rectangle that is judged.
    #[must_use]
    pub fn is_judged(&self, place: Vector) -> bool {
        self.extent.contains(place)
    }

    /// Whether a place lies within `expansion_m` of a shape; inside counts.
    #[must_use]
    pub fn is_wall(&self, place: Vector, expansion_m: f64) -> bool {
        let limit_m = expansion_m + ROUNDING_M;
        self.shapes
            .iter()
            .any(|shape| shape.distance_m(place) <= limit_m)
    }

    /// Distance of a place from the nearest shape, metres; infinite in an empty world.
    #[must_use]
    pub fn distance_m(&self, place: Vector) -> f64 {
        let distances = self.shapes.iter().map(|shape| shape.distance_m(place));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// The rectangle that is judged.
    #[must_use]
    pub fn extent(&self) -> Rectangle {
        self.extent
    }

    /// Middles of the pieces of 5 mm, along all outlines, that were visible.
    #[must_use]
    pub fn surface(&self) -> &[Vector] {
        &self.surface
    }

    /// For each of [`surface`](Self::surface) the direction in which it was first seen, a
    /// unit vector.
    #[must_use]
    pub fn seen_along(&self) -> &[Vector] {
        &self.seen_along
    }

    /// Centres of the free cells that were visible, of the scenario's cell size.
    #[must_use]
    pub fn visible_free(&self) -> &[Vector] {
        &self.free
    }
}

/// Looks from one pose after the other.
struct Witness<'s> {
    scenario: &'s Scenario,
    config: amiro_ipf::node::Config,
    seen_m: f64,
    lobe: BeamPattern,
    /// The outline places of each shape that were not seen so far.
    hidden: Vec<Vec<Vector>>,
    centre: Vector,
    sensor_poses: Vec<SensorPose>,
    near: Vec<Shape>,
}

impl<'s> Witness<'s> {
    fn of(scenario: &'s Scenario) -> Self {
        // The profile does not matter here: the sensors are the same.
        let config = scenario.config(Profile::Paper);
        let lobe = BeamPattern::of(&config.photometry);
        let outline = |shape: &Shape| shape.outline(OUTLINE_SPACING_M);
        Self {
            scenario,
            seen_m: SEEN_SHARE * f64::from(config.photometry.x_max_m),
            lobe,
            hidden: scenario.shapes.iter().map(outline).collect(),
            config,
            centre: Vector::default(),
            sensor_poses: Vec::new(),
            near: Vec::new(),
        }
    }

    /// Farthest that any sensor sees from the robot's centre.
    fn reach_m(&self) -> f64 {
        self.seen_m + f64::from(self.config.ring.radius_m) + HIDDEN_M
    }

    fn is_near(&self, shape: &Shape) -> bool {
        (shape.centre() - self.centre).norm() <= self.reach_m() + shape.reach_m()
    }

    fn stand_at(&mut self, pose: &Pose2) {
        self.centre = pose.position;
        self.sensor_poses = SensorPose::at(&self.config.ring, self.config.sensors, *pose).collect();
        let shapes = self.scenario.shapes.iter().copied();
        self.near = shapes.filter(|shape| self.is_near(shape)).collect();
    }

    fn sees(&self, place: Vector) -> bool {
        self.seen_along(place).is_some()
    }

    /// The direction in which a sensor sees a place, if one does.
    fn seen_along(&self, place: Vector) -> Option<Vector> {
        self.sensor_poses.iter().find_map(|sensor_pose| {
            let way = place - sensor_pose.position;
            let distance_m = way.norm();
            if distance_m > self.seen_m || distance_m < HIDDEN_M {
                return None;
            }
            let sensor = way.turned(sensor_pose.axis.inverse());
            if sensor.y.abs() > f64::from(self.lobe.tangent_max()) * sensor.x {
                return None;
            }
            let lobe = self.lobe.at((sensor.x / distance_m) as f32);
            if distance_m > self.seen_m * f64::from(lobe) {
                return None;
            }
            let direction = way.scaled(1.0 / distance_m);
            first_surface(&self.near, sensor_pose.position, direction)
                .is_none_or(|(first_m, _)| first_m >= distance_m - HIDDEN_M)
                .then_some(direction)
        })
    }

    /// Moves the outline places that are seen from here to the truth.
    fn see_outlines(&mut self, truth: &mut Truth) {
        let mut hidden = std::mem::take(&mut self.hidden);
        for (shape, places) in self.scenario.shapes.iter().zip(&mut hidden) {
            if self.is_near(shape) {
                let seen_along = &mut truth.seen_along;
                truth.surface.extend(places.extract_if(.., |place| {
                    let along = self.seen_along(*place);
                    seen_along.extend(along);
                    along.is_some()
                }));
            }
        }
        self.hidden = hidden;
    }

    /// The cells whose centres may be in view from here.
    fn cells_around(&self, cells: &Lattice) -> Vec<Cell> {
        let reach = Vector::new(self.reach_m(), self.reach_m());
        let (low, high) = (self.centre - reach, self.centre + reach);
        let corners = (cells.cell_at(low.x, low.y), cells.cell_at(high.x, high.y));
        let (Some(low), Some(high)) = corners else {
            // Farther away than any judged rectangle: nothing of it is in view.
            return Vec::new();
        };
        (low.row..=high.row)
            .flat_map(|row| (low.column..=high.column).map(move |column| Cell { row, column }))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(tables: &str) -> Scenario {
        let text = format!(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [-0.3, -0.3, 0.3, 0.3]\n\
             speed_m_per_s = 0.08\nsensors_deg = [0]\nstart = [0, 0, 0]\n{tables}"
        );
        Scenario::parse(&text).unwrap()
    }

    const BLOCK: &str = "[[box]]\nmin = [0.15, -0.025]\nmax = [0.25, 0.025]\n";

    #[test]
    fn walls_grow_by_the_expansion_and_ties_belong_to_them() {
        let truth = Truth::of(&scenario(BLOCK), &[]);
        let wall = |x, y, e| truth.is_wall(Vector::new(x, y), e);
        assert!(wall(0.2, 0.0, 0.0), "inside counts");
        assert!(!wall(0.145, 0.0, 0.0) && wall(0.145, 0.0, 0.005));
        assert!(!wall(0.135, 0.015, 0.010) && wall(0.135, 0.015, 0.015));
        // Round corners: 5 mm beyond in x and y are 7.07 mm.
        assert!(!wall(0.145, 0.030, 0.005) && wall(0.145, 0.030, 0.010));
    }

    #[test]
    fn only_the_face_that_is_looked_at_is_visible() {
        let truth = Truth::of(&scenario(BLOCK), &[Pose2::new(0.0, 0.0, 0.0)]);
        // 50 mm of face are 10 pieces; everything else is behind.
        assert_eq!(truth.surface().len(), 10);
        assert!(truth.surface().iter().all(|place| place.x < 0.1501));
        // From 180 mm on a surface is out of sight.
        let far = Truth::of(&scenario(BLOCK), &[Pose2::new(-0.081, 0.0, 0.0)]);
        assert_eq!(far.surface().len(), 0);
        let averted = Truth::of(&scenario(BLOCK), &[Pose2::new(0.0, 0.0, 3.0)]);
        assert_eq!(averted.surface().len(), 0);
    }

    #[test]
    fn free_cells_lie_in_view_and_not_in_the_shadow() {
        let truth = Truth::of(&scenario(BLOCK), &[Pose2::new(0.0, 0.0, 0.0)]);
        // The lobe up to 60 degrees, 0.18^2 sin(xi 60 deg) / xi, has 252 cells of 10 mm;
        // the block and its shadow behind 100 mm take 28 degrees of it, some 50.
        let count = truth.visible_free().len();
        assert!((190..215).contains(&count), "{count}");
        for place in truth.visible_free() {
            assert!(place.x > 0.05, "behind the sensor: {place:?}");
            assert!(!truth.is_wall(*place, 0.0), "{place:?}");
            let shadow = place.x > 0.15 && place.y.abs() < 0.024;
            assert!(!shadow, "{place:?}");
        }
        let empty = Truth::of(&scenario(""), &[Pose2::new(0.0, 0.0, 0.0); 3]);
        assert!((245..260).contains(&empty.visible_free().len()));
    }

    #[test]
    fn distance_in_an_empty_world_is_infinite() {
        let truth = Truth::of(&scenario(""), &[]);
        assert!(truth.distance_m(Vector::default()).is_infinite());
        assert!(!truth.is_wall(Vector::default(), 1.0));
    }
}
