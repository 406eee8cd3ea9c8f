//! What comes back to a sensor: its rays, and the returns along them.

use amiro_ipf::sensor::Photometry;

use super::vector::Turn;
use super::{Eye, Shape, first_surface};

/// Rays a sensor: one a degree over +-60 degrees.
const RAYS: u16 = 121;
/// The raw register's end: more than any signal that can be told.
pub(super) const FULL: f64 = 65_535.0;

/// The rays of a sensor and the law of what returns along them.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    alpha_counts_m2: f64,
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
    /// The rays of the given law.
    pub(super) fn new(photometry: &Photometry) -> Self {
        let half_way = f32::from(RAYS / 2);
        let rays = (0..RAYS).filter_map(|ray| {
            let share = (f32::from(ray) - half_way) / half_way;
            let bearing_rad = share * photometry.theta_max_rad;
            Some(Ray {
                bearing: Turn::by_radians(bearing_rad),
                directivity: f64::from(photometry.directivity(bearing_rad)?),
            })
        });
        Self {
            alpha_counts_m2: f64::from(photometry.alpha_counts_m2),
            delta_m2: f64::from(photometry.delta_m2),
            rays: rays.collect(),
        }
    }

    /// Counts above beta that the strongest return gives; 0 for none.
    pub(super) fn signal(&self, shapes: &[Shape], eye: &Eye) -> f64 {
        let returns = self.rays.iter().filter_map(|ray| {
            let direction = ray.bearing.after(eye.axis).direction();
            let (distance, shape) = first_surface(shapes, eye.position, direction)?;
            let denominator = distance * distance / ray.directivity - self.delta_m2;
            // At contact the law ends and the register is full.
            Some(if denominator > 0.0 {
                self.alpha_counts_m2 * shape.reflectivity() / denominator
            } else {
                FULL
            })
        });
        returns.fold(0.0, f64::max)
    }
}
