//! The optics of an infrared sensor: its rays, and the returns along them.
//!
//! There are 121 rays within 60 degrees of the axis, each with the first surface on it.
//! [`Physics`] is the rule that makes a signal of the returns. A result should be checked
//! under both rules.

use std::str::FromStr;

use amiro_ipf::model::Photometry;

use super::{OptionsError, SensorPose, Shape, first_surface};
use crate::geometry::Turn;

/// Rays per sensor: one per degree over +-60 degrees.
const RAYS: u16 = 121;
/// Largest value of the raw register.
pub(super) const FULL: f64 = 65_535.0;
/// Distance at which a wall has the law's return under both rules, metres.
const REFERENCE_M: f64 = 0.1;

/// The rule that makes a signal of the returns along a sensor's rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Physics {
    /// The strongest return is the signal, each by the filter's own law.
    ///
    /// Filter and world share equation 5: results measure the inference of the filter, not
    /// the agreement of the law with a real wall.
    #[default]
    Matched,
    /// The returns of all visible surfaces add up, as those of Lambert surfaces.
    ///
    /// A ray adds rho cos(i) / (d^2 / C - delta), with the reflectivity rho, the angle of
    /// incidence i on the surface, its distance d and C = cos(xi theta): the law's own
    /// return, times Lambert's cosine. For delta = 0 that is rho C cos(i) / d^2. The sum
    /// is scaled so that an endless wall across the axis at 100 mm has the law's return
    /// for 100 mm on the axis, and for delta = 0 the law's return at every distance. A
    /// face of width w at distance D fills the lobe only to atan(w / 2 D) and returns
    /// less, so that it appears farther by the law: a 50 mm face at 100 mm appears at 149
    /// mm.
    ///
    /// Only light in the plane counts, at any height of an object. With one ray per
    /// degree a face's return changes in steps of one ray as its edges pass: 3 % for 50 mm
    /// at 100 mm.
    Patch,
}

impl std::fmt::Display for Physics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Matched => "matched",
            Self::Patch => "patch",
        })
    }
}

impl FromStr for Physics {
    type Err = OptionsError;

    fn from_str(text: &str) -> Result<Self, OptionsError> {
        match text {
            "matched" => Ok(Self::Matched),
            "patch" => Ok(Self::Patch),
            _ => Err(OptionsError::value("physics", text, "matched or patch")),
        }
    }
}

/// The rays of a sensor and the law of the returns along them.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    physics: Physics,
    /// Counts m^2 of one ray's return.
    gain_counts_m2: f64,
    delta_m2: f64,
    rays: Vec<Ray>,
}

/// A ray of the lobe.
#[derive(Clone, Copy, Debug)]
struct Ray {
    /// Bearing off the axis.
    bearing: Turn,
    /// C(theta) there.
    directivity: f64,
}

impl Optics {
    /// The rays of the given law, under the given physics.
    pub(super) fn new(physics: Physics, photometry: &Photometry) -> Self {
        let half_way = f32::from(RAYS / 2);
        let rays = (0..RAYS).filter_map(|ray| {
            let share = (f32::from(ray) - half_way) / half_way;
            let bearing_rad = share * photometry.theta_max_rad;
            Some(Ray {
                bearing: Turn::by_radians(bearing_rad),
                directivity: f64::from(photometry.directivity(bearing_rad)?),
            })
        });
        let mut optics = Self {
            physics,
            gain_counts_m2: f64::from(photometry.alpha_counts_m2),
            delta_m2: f64::from(photometry.delta_m2),
            rays: rays.collect(),
        };
        if physics == Physics::Patch {
            let on_axis = 1.0 / (REFERENCE_M * REFERENCE_M - optics.delta_m2);
            optics.gain_counts_m2 *= on_axis / optics.reference_wall();
        }
        optics
    }

    /// Counts above beta of all visible surfaces; 0 for none.
    pub(super) fn signal(&self, shapes: &[Shape], sensor_pose: &SensorPose) -> f64 {
        let returns = self
            .rays
            .iter()
            .filter_map(|ray| self.along(ray, shapes, sensor_pose));
        match self.physics {
            Physics::Matched => returns.fold(0.0, f64::max),
            Physics::Patch => returns.fold(0.0, |sum, counts| sum + counts),
        }
    }

    /// Counts of the return along a ray; `None` without a surface on it.
    fn along(&self, ray: &Ray, shapes: &[Shape], sensor_pose: &SensorPose) -> Option<f64> {
        let direction = ray.bearing.after(sensor_pose.axis).direction();
        let (distance, shape) = first_surface(shapes, sensor_pose.position, direction)?;
        let denominator = distance * distance / ray.directivity - self.delta_m2;
        // At contact the law ends and the register is full.
        if denominator <= 0.0 {
            return Some(FULL);
        }
        let counts = self.gain_counts_m2 * shape.reflectivity() / denominator;
        Some(match self.physics {
            Physics::Matched => counts,
            Physics::Patch => {
                let normal = shape.normal_at(sensor_pose.position + direction.scaled(distance));
                counts * (-normal.dot(direction)).max(0.0)
            }
        })
    }

    /// What an endless wall across the axis returns at the reference distance for a
    /// gain of 1, 1/m^2: over the same rays, so that their spacing cancels.
    fn reference_wall(&self) -> f64 {
        self.rays.iter().fold(0.0, |sum, ray| {
            let cosine = ray.bearing.cosine;
            let distance = REFERENCE_M / cosine;
            sum + cosine / (distance * distance / ray.directivity - self.delta_m2)
        })
    }
}

/// Signal above beta of a sensor at the origin that looks along x.
#[cfg(test)]
pub(crate) fn signal_of(photometry: &Photometry, physics: Physics, shapes: &[Shape]) -> f64 {
    let sensor_pose = SensorPose {
        sensor: 0,
        position: crate::geometry::Vector::default(),
        axis: Turn::by_degrees(0.0),
    };
    Optics::new(physics, photometry).signal(shapes, &sensor_pose)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Scenario, Vector};
    use amiro_ipf::geometry::Point;
    use amiro_ipf::model::{TabulatedWallLaw, Wall};

    const LAW: Photometry = Photometry::VCNL4020;

    fn shapes(tables: &str) -> Vec<Shape> {
        let text = format!(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\nspeed_m_per_s = 0.08\n\
             start = [0, 0, 0]\n{tables}"
        );
        Scenario::parse(&text).unwrap().shapes
    }

    fn signal_of(photometry: &Photometry, physics: Physics, tables: &str) -> f64 {
        super::signal_of(photometry, physics, &shapes(tables))
    }

    fn patch(tables: &str) -> f64 {
        signal_of(&LAW, Physics::Patch, tables)
    }

    /// A plate of the given width whose middle lies at a distance straight ahead,
    /// turned about that middle.
    fn plate(distance_m: f64, width_m: f64, angle_deg: f64) -> String {
        // The front face's middle, not the box's centre, is to stay where it is.
        let depth = 0.5e-3;
        let back = Turn::by_degrees(angle_deg).direction().scaled(depth);
        let centre = Vector::new(distance_m, 0.0) + back;
        format!(
            "[[box]]\nmin = [{}, {}]\nmax = [{}, {}]\nangle_deg = {angle_deg}\n",
            centre.x - depth,
            centre.y - 0.5 * width_m,
            centre.x + depth,
            centre.y + 0.5 * width_m,
        )
    }

    /// The share of the lobe's return that comes from within `edge_rad` of the axis, for
    /// a wall across it: the integral of cos(xi t) cos^3 t, with
    /// cos^3 t = (3 cos t + cos 3 t) / 4.
    fn share_within(edge_rad: f64) -> f64 {
        let xi = f64::from(LAW.xi);
        let product = |b: f64, t: f64| {
            ((xi - b) * t).sin() / (2.0 * (xi - b)) + ((xi + b) * t).sin() / (2.0 * (xi + b))
        };
        let integral = |t: f64| 0.75 * product(1.0, t) + 0.25 * product(3.0, t);
        integral(edge_rad) / integral(60.0_f64.to_radians())
    }

    #[test]
    fn an_endless_wall_across_the_axis_has_the_return_of_the_law() {
        // The sines are within 3e-7, so the returns within some 1e-6 of themselves.
        for range in [0.05, 0.1, 0.15] {
            let law = f64::from(LAW.alpha_counts_m2) / (range * range);
            let wall = patch(&plate(range, 4.0, 0.0));
            assert!((wall / law - 1.0).abs() < 1e-5, "{range} m: {wall}, {law}");
        }
        // With a delta only at the reference distance.
        let bent = Photometry {
            delta_m2: -250e-6,
            ..LAW
        };
        let wall = signal_of(&bent, Physics::Patch, &plate(0.1, 4.0, 0.0));
        let law = f64::from(LAW.alpha_counts_m2) / (0.01 + 250e-6);
        assert!((wall / law - 1.0).abs() < 1e-5, "{wall}, {law}");
    }

    #[test]
    fn a_small_face_returns_its_share_of_the_lobe() {
        let law = f64::from(LAW.alpha_counts_m2);
        for (range, width) in [(0.1, 0.05), (0.06, 0.05), (0.1, 0.1), (0.15, 0.2)] {
            let share = patch(&plate(range, width, 0.0)) / (law / (range * range));
            let edge = (0.5 * width / range).atan();
            let expected = share_within(edge);
            assert!(share < 0.95, "{width} m at {range} m: {share}");
            // The rays end half a degree within or beyond either edge: at most one
            // ray's share, weighed as on the axis, more or less.
            let ray = share_within(1.0_f64.to_radians()) / 2.0;
            assert!(
                (share - expected).abs() < 1.01 * ray,
                "{width} m at {range} m: {share}, {expected}"
            );
        }
    }

    #[test]
    fn a_face_that_underfills_the_lobe_is_taken_for_tens_of_millimetres_farther() {
        let taken_for_m = |width| {
            let counts = LAW.beta_counts + patch(&plate(0.1, width, 0.0)) as f32;
            LAW.range_m(counts, 0.0).unwrap()
        };
        assert!((taken_for_m(4.0) - 0.1).abs() < 1e-5);
        let face = taken_for_m(0.05);
        // A share of 0.45 of the lobe: 0.1 / sqrt(0.45) = 0.149; one ray is 1.7 %.
        assert!((face - 0.149).abs() < 0.003, "{face} m");
    }

    #[test]
    fn a_tilted_wall_returns_less_than_one_across_at_the_same_distance() {
        // The wall's nearest point is 100 mm away, at the bearing of the tilt: the
        // integral of cos(xi t) cos^3(t - tilt) over the lobe, by 12 000 pieces.
        let integral = |tilt: f64| -> f64 {
            let piece = |index: i32| (f64::from(index) + 0.5) * 1e-2 - 60.0;
            (0..12_000)
                .map(|index| piece(index).to_radians())
                .map(|t| (f64::from(LAW.xi) * t).cos() * (t - tilt).cos().powi(3))
                .sum()
        };
        let mut before = patch(&plate(0.1, 8.0, 0.0));
        let across = before;
        for degrees in [10.0_f64, 20.0, 30.0] {
            let tilt = degrees.to_radians();
            let tilted = patch(&plate(0.1 / tilt.cos(), 8.0, degrees));
            assert!(tilted < before, "{degrees} degrees: {tilted}, {before}");
            // Whole degrees against the integral: within 0.2 %.
            let expected = integral(tilt) / integral(0.0);
            assert!(
                (tilted / across - expected).abs() < 2e-3,
                "{degrees} degrees: {}, {expected}",
                tilted / across
            );
            before = tilted;
        }
    }

    #[test]
    fn a_face_turned_away_returns_less_in_its_place() {
        // 20 mm seen from 100 mm: narrower by cos 45 and darker by cos 45; the nearer
        // half returns more than the farther one loses, and a ray of eleven counts 9 %.
        let (across, turned) = (
            patch(&plate(0.1, 0.02, 0.0)),
            patch(&plate(0.1, 0.02, 45.0)),
        );
        assert!((turned / across - 0.5).abs() < 0.1, "{}", turned / across);
        let matched = |angle| signal_of(&LAW, Physics::Matched, &plate(0.1, 0.02, angle));
        assert!(matched(45.0) >= matched(0.0), "the point law knows no tilt");
    }

    #[test]
    fn returns_add_up_and_what_is_hidden_adds_nothing() {
        let post = |y: f64| format!("[[cylinder]]\ncenter = [0.1, {y}]\nradius_m = 0.01\n");
        let (left, right) = (patch(&post(0.04)), patch(&post(-0.04)));
        let both = patch(&(post(0.04) + &post(-0.04)));
        assert!(left > 0.0 && (both - left - right).abs() < 1e-9, "{both}");
        let dark = format!("{}reflectivity = 0.001\n", plate(0.05, 4.0, 0.0));
        let hidden = patch(&(post(0.04) + &dark));
        assert!((hidden - patch(&dark)).abs() < 1e-9, "{hidden}");
    }

    #[test]
    fn patch_is_the_law_of_walls_with_ends() {
        let law = TabulatedWallLaw::of(&LAW);
        // Faces that look at the sensor, from right to left; the last hides the others.
        let mut faces: Vec<[f64; 4]> = Vec::new();
        for face in [
            [0.10, -0.30, 0.10, 0.30],
            [0.12, -0.02, 0.10, 0.08],
            [0.05, -0.09, 0.12, -0.05],
            [0.15, -0.20, 0.09, -0.03],
            [0.06, -0.005, 0.06, 0.025],
        ] {
            faces.push(face);
            let mut tables = String::new();
            for [x0, y0, x1, y1] in &faces {
                let way = Vector::new(x1 - x0, y1 - y0);
                let back = Vector::new(way.y, -way.x).scaled(0.5e-3 / way.norm());
                let (x, y) = (0.5 * (x0 + x1) + back.x, 0.5 * (y0 + y1) + back.y);
                let half = 0.5 * way.norm();
                tables += &format!(
                    "[[box]]\nmin = [{}, {}]\nmax = [{}, {}]\nangle_deg = {}\n",
                    x - 0.5e-3,
                    y - half,
                    x + 0.5e-3,
                    y + half,
                    (-way.x).atan2(way.y).to_degrees()
                );
            }
            let point = |x: f64, y: f64| Point::new(x as f32, y as f32);
            let walls: Vec<Wall> = faces
                .iter()
                .map(|[x0, y0, x1, y1]| [point(*x0, *y0), point(*x1, *y1)])
                .collect();
            let (simulated, law) = (patch(&tables), f64::from(law.signal(&walls)));
            // One ray of 121 at each end: 1.7 % of a full lobe at 60 mm, at most four ends
            // with an edge before a farther face.
            let ray = f64::from(LAW.alpha_counts_m2) / (0.06 * 0.06) * 0.017;
            assert!(
                (simulated - law).abs() < 2.0 * ray,
                "{faces:?}: {simulated}, {law}"
            );
            if faces.len() == 1 {
                assert!((simulated / law - 1.0).abs() < 0.01, "{simulated}, {law}");
            }
        }
    }

    #[test]
    fn contact_is_more_than_the_register_holds() {
        for physics in [Physics::Matched, Physics::Patch] {
            assert!(signal_of(&LAW, physics, &plate(0.003, 4.0, 0.0)) > FULL);
            assert!(signal_of(&LAW, physics, &plate(0.0, 4.0, 0.0)) >= FULL);
        }
    }
}
