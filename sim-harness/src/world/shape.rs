//! What stands in the world: boxes and upright cylinders, seen from above.

use serde::Deserialize;

use super::bounded::{Coordinate, Degrees, Radius, Reflectivity};
use crate::geometry::{Turn, Vector};

/// A solid shape with a reflecting outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    form: Form,
    centre: Vector,
    reflectivity: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// Half the sides, and how the box is turned.
    Box { half: Vector, turn: Turn },
    /// The radius.
    Cylinder { radius_m: f64 },
}

impl Shape {
    /// The box behind a face with the given ends, as deep as `depth` is long, which is
    /// perpendicular to the face.
    #[must_use]
    pub(crate) fn behind(from: Vector, to: Vector, depth: Vector, reflectivity: f64) -> Self {
        let way = to - from;
        Self {
            form: Form::Box {
                half: Vector::new(0.5 * way.norm(), 0.5 * depth.norm()),
                turn: Turn::by_radians_f64(libm::atan2(way.y, way.x)),
            },
            centre: (from + to + depth).scaled(0.5),
            reflectivity,
        }
    }

    /// Signal relative to that of the calibrated surface at the same place.
    #[must_use]
    pub fn reflectivity(&self) -> f64 {
        self.reflectivity
    }

    /// What the shape is called in a scenario file.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self.form {
            Form::Box { .. } => "box",
            Form::Cylinder { .. } => "cylinder",
        }
    }

    /// Length of the outline, metres.
    #[must_use]
    pub fn outline_m(&self) -> f64 {
        match self.form {
            Form::Box { half, .. } => 4.0 * (half.x + half.y),
            Form::Cylinder { radius_m } => core::f64::consts::TAU * radius_m,
        }
    }

    /// Radius about [`centre`](Self::centre) outside of which nothing of the shape is.
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        match self.form {
            // 1 ppm more than the half diagonal, for the turn's rounding.
            Form::Box { half, .. } => half.norm() * (1.0 + 1e-6),
            Form::Cylinder { radius_m } => radius_m,
        }
    }

    /// The shape's centre.
    #[must_use]
    pub fn centre(&self) -> Vector {
        self.centre
    }

    /// Distance of a place from the shape, metres; 0 inside.
    #[must_use]
    pub fn distance_m(&self, place: Vector) -> f64 {
        let from_centre = place - self.centre;
        match self.form {
            Form::Box { half, turn } => {
                let local = from_centre.turned(turn.inverse());
                let beyond = Vector::new(
                    (local.x.abs() - half.x).max(0.0),
                    (local.y.abs() - half.y).max(0.0),
                );
                beyond.norm()
            }
            Form::Cylinder { radius_m } => (from_centre.norm() - radius_m).max(0.0),
        }
    }

    /// Distance along a ray to the shape, metres; 0 from inside, `None` for a miss.
    ///
    /// The direction is a unit vector.
    #[must_use]
    pub fn hit_m(&self, origin: Vector, direction: Vector) -> Option<f64> {
        let origin = origin - self.centre;
        match self.form {
            Form::Box { half, turn } => {
                let inverse = turn.inverse();
                let (origin, direction) = (origin.turned(inverse), direction.turned(inverse));
                let (enter_x, leave_x) = slab(origin.x, direction.x, half.x)?;
                let (enter_y, leave_y) = slab(origin.y, direction.y, half.y)?;
                let (enter, leave) = (enter_x.max(enter_y), leave_x.min(leave_y));
                (enter <= leave && leave >= 0.0).then(|| enter.max(0.0))
            }
            Form::Cylinder { radius_m } => {
                // |origin + t direction|^2 = radius^2, solved for the smaller t.
                let along = -origin.dot(direction);
                let outside = origin.dot(origin) - radius_m * radius_m;
                let discriminant = along * along - outside;
                if outside <= 0.0 {
                    return Some(0.0);
                }
                (along > 0.0 && discriminant >= 0.0).then(|| along - discriminant.sqrt())
            }
        }
    }

    /// The outward unit normal at a place on the outline.
    ///
    /// At a box's corner that of one of its two faces; at a cylinder's axis, which is
    /// no such place, (0, 0).
    #[must_use]
    pub fn normal_at(&self, place: Vector) -> Vector {
        let from_centre = place - self.centre;
        match self.form {
            Form::Box { half, turn } => {
                let local = from_centre.turned(turn.inverse());
                let is_end = local.x.abs() - half.x > local.y.abs() - half.y;
                let normal = if is_end {
                    Vector::new(1.0_f64.copysign(local.x), 0.0)
                } else {
                    Vector::new(0.0, 1.0_f64.copysign(local.y))
                };
                normal.turned(turn)
            }
            Form::Cylinder { .. } => {
                let length = from_centre.norm();
                if length > 0.0 {
                    from_centre.scaled(1.0 / length)
                } else {
                    Vector::default()
                }
            }
        }
    }

    /// Middles of equal pieces of the outline, each at most `spacing_m` long.
    ///
    /// Middles, because a corner belongs to two faces, of which often one is hidden.
    #[must_use]
    pub fn outline(&self, spacing_m: f64) -> Vec<Vector> {
        let pieces = |length_m: f64| (length_m / spacing_m - 1e-9).ceil().max(1.0) as usize;
        match self.form {
            Form::Box { half, turn } => {
                let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(x, y)| Vector::new(x * half.x, y * half.y));
                let sides = corners.into_iter().zip(corners.into_iter().cycle().skip(1));
                sides
                    .flat_map(|(from, to)| {
                        let count = pieces((to - from).norm());
                        (0..count).map(move |index| {
                            from + (to - from).scaled((index as f64 + 0.5) / count as f64)
                        })
                    })
                    .map(|local| self.centre + local.turned(turn))
                    .collect()
            }
            Form::Cylinder { radius_m } => {
                let count = pieces(self.outline_m()).max(3);
                (0..count)
                    .map(|index| Turn::by_degrees(360.0 * index as f64 / count as f64))
                    .map(|turn| self.centre + turn.direction().scaled(radius_m))
                    .collect()
            }
        }
    }
}

/// Where a ray enters and leaves the strip |coordinate| <= half; `None` beside it.
fn slab(origin: f64, direction: f64, half: f64) -> Option<(f64, f64)> {
    if direction.abs() < 1e-12 {
        return (origin.abs() <= half).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (low, high) = ((-half - origin) / direction, (half - origin) / direction);
    Some((low.min(high), low.max(high)))
}

/// The keys of a `[[box]]` table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxKeys {
    min: [Coordinate; 2],
    max: [Coordinate; 2],
    angle_deg: Option<Degrees>,
    reflectivity: Option<Reflectivity>,
}

/// A box as a file describes it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "BoxKeys")]
pub(crate) struct BoxTable(pub(crate) Shape);

impl TryFrom<BoxKeys> for BoxTable {
    type Error = String;

    fn try_from(keys: BoxKeys) -> Result<Self, Self::Error> {
        let (min, max) = corners(keys.min, keys.max)?;
        Ok(Self(Shape {
            form: Form::Box {
                half: (max - min).scaled(0.5),
                turn: Turn::by_degrees(keys.angle_deg.map_or(0.0, |angle| angle.value())),
            },
            centre: (min + max).scaled(0.5),
            reflectivity: keys.reflectivity.map_or(1.0, |share| share.value()),
        }))
    }
}

/// Both corners of a rectangle, the lower left one first.
pub(super) fn corners(
    min: [Coordinate; 2],
    max: [Coordinate; 2],
) -> Result<(Vector, Vector), String> {
    let [min, max] = [min, max].map(|[x, y]| Vector::new(x.value(), y.value()));
    if min.x < max.x && min.y < max.y {
        Ok((min, max))
    } else {
        Err(format!(
            "min [{}, {}] must lie below and left of max [{}, {}]",
            min.x, min.y, max.x, max.y
        ))
    }
}

/// A cylinder as a file describes it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CylinderTable {
    center: [Coordinate; 2],
    radius_m: Radius,
    reflectivity: Option<Reflectivity>,
}

impl From<CylinderTable> for Shape {
    fn from(table: CylinderTable) -> Self {
        let [x, y] = table.center.map(|coordinate| coordinate.value());
        Self {
            form: Form::Cylinder {
                radius_m: table.radius_m.value(),
            },
            centre: Vector::new(x, y),
            reflectivity: table.reflectivity.map_or(1.0, |share| share.value()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(table: &str) -> Shape {
        #[derive(Deserialize)]
        #[serde(rename_all = "lowercase")]
        enum Table {
            Box(BoxTable),
            Cylinder(CylinderTable),
        }
        match toml::from_str(table).unwrap() {
            Table::Box(table) => table.0,
            Table::Cylinder(table) => table.into(),
        }
    }

    #[test]
    fn a_box_behind_a_face_is_the_box_with_those_corners() {
        let (from, to) = (Vector::new(1.0, 0.5), Vector::new(2.0, 0.5));
        let boxed = shape("box = { min = [1.0, 0.5], max = [2.0, 0.75] }");
        let depth = Vector::new(0.0, 0.25);
        assert_eq!(Shape::behind(from, to, depth, 1.0), boxed);
        // With the ends swapped it is turned about.
        let turned = Shape::behind(to, from, depth, 1.0);
        for place in [(0.0, 0.0), (1.5, 0.6), (3.0, 1.0), (1.5, 0.8)] {
            let place = Vector::new(place.0, place.1);
            let difference = turned.distance_m(place) - boxed.distance_m(place);
            assert!(difference.abs() < 1e-6, "{place:?}: {difference}");
        }
    }

    #[test]
    fn rays_end_at_the_face_they_meet_first() {
        let shape = shape("box = { min = [1.0, -0.5], max = [2.0, 0.5] }");
        let east = Vector::new(1.0, 0.0);
        assert_eq!(shape.hit_m(Vector::new(0.0, 0.0), east), Some(1.0));
        assert_eq!(shape.hit_m(Vector::new(1.5, 0.0), east), Some(0.0));
        assert_eq!(shape.hit_m(Vector::new(3.0, 0.0), east), None);
        assert_eq!(shape.hit_m(Vector::new(0.0, 0.6), east), None);
        let north = Vector::new(0.0, 1.0);
        assert_eq!(shape.hit_m(Vector::new(1.5, -2.0), north), Some(1.5));
    }

    #[test]
    fn a_box_turned_by_45_degrees_shows_its_corner() {
        let shape = shape("box = { min = [-1.0, -1.0], max = [1.0, 1.0], angle_deg = 45.0 }");
        let hit = shape.hit_m(Vector::new(-3.0, 0.0), Vector::new(1.0, 0.0));
        assert!((hit.unwrap() - (3.0 - 2.0_f64.sqrt())).abs() < 1e-6);
        assert!((shape.distance_m(Vector::new(2.0, 2.0)) - (8.0_f64.sqrt() - 1.0)).abs() < 1e-6);
        assert!(shape.distance_m(Vector::new(0.0, 1.4)) < 1e-9);
    }

    #[test]
    fn a_cylinder_is_met_on_its_near_side() {
        let shape = shape("cylinder = { center = [1.0, 0.0], radius_m = 0.1 }");
        let east = Vector::new(1.0, 0.0);
        assert!((shape.hit_m(Vector::new(0.0, 0.0), east).unwrap() - 0.9).abs() < 1e-12);
        let off = shape.hit_m(Vector::new(0.0, 0.06), east).unwrap();
        assert!((off - 0.92).abs() < 1e-12, "3-4-5: {off}");
        assert_eq!(shape.hit_m(Vector::new(2.0, 0.0), east), None);
        assert_eq!(shape.hit_m(Vector::new(1.0, 0.05), east), Some(0.0));
        assert!((shape.distance_m(Vector::new(1.0, 0.3)) - 0.2).abs() < 1e-12);
    }

    #[test]
    fn normals_point_out_of_the_face_that_was_hit() {
        let flat = shape("box = { min = [1.0, -0.5], max = [2.0, 0.5] }");
        for (place, normal) in [
            ((1.0, 0.4), (-1.0, 0.0)),
            ((2.0, -0.4), (1.0, 0.0)),
            ((1.1, 0.5), (0.0, 1.0)),
            ((1.9, -0.5), (0.0, -1.0)),
        ] {
            let found = flat.normal_at(Vector::new(place.0, place.1));
            assert_eq!(found, Vector::new(normal.0, normal.1), "{place:?}");
        }
        let turned = shape("box = { min = [-1.0, -0.1], max = [1.0, 0.1], angle_deg = 30.0 }");
        let left = Turn::by_degrees(120.0).direction();
        let place = Turn::by_degrees(30.0).direction().scaled(0.7) + left.scaled(0.1);
        assert!((turned.normal_at(place) - left).norm() < 1e-6);
        let round = shape("cylinder = { center = [1.0, 0.0], radius_m = 0.1 }");
        let normal = round.normal_at(Vector::new(1.06, 0.08));
        assert!((normal - Vector::new(0.6, 0.8)).norm() < 1e-12, "3-4-5");
        assert_eq!(round.normal_at(Vector::new(1.0, 0.0)), Vector::default());
    }

    #[test]
    fn outlines_are_evenly_sampled_on_the_surface() {
        for (table, count) in [
            ("box = { min = [0.0, 0.0], max = [0.2, 0.05] }", 100),
            (
                "box = { min = [0.0, 0.0], max = [0.2, 0.05], angle_deg = 30.0 }",
                100,
            ),
            ("cylinder = { center = [3.0, 4.0], radius_m = 0.0335 }", 43),
        ] {
            let shape = shape(table);
            let outline = shape.outline(0.005);
            assert_eq!(outline.len(), count, "{table}");
            for place in outline {
                assert!(shape.distance_m(place) < 1e-6, "{table}: {place:?}");
                let from_centre = (place - shape.centre()).norm();
                assert!(from_centre <= shape.reach_m() * (1.0 + 1e-6), "{table}");
            }
        }
    }
}
