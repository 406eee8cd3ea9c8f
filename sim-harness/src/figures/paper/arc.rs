//! The arc that a reading stands for, in the sensor's frame.

use amiro_ipf::geometry::{Point, Rotation};
use amiro_ipf::model::Photometry;

/// Bearings between two points of an arc: half a degree.
const STEPS_A_SIDE: i16 = 120;

/// The arc x(s, theta) plus so many standard deviations, in millimetres ahead and aside.
pub(super) fn arc_mm(law: &Photometry, counts: f32, deviations: f32) -> Vec<(f64, f64)> {
    let bearings = (-STEPS_A_SIDE..=STEPS_A_SIDE)
        .map(|step| law.theta_max_rad * f32::from(step) / f32::from(STEPS_A_SIDE));
    bearings
        .filter_map(|bearing| {
            let range_m = law.range_m(counts, bearing)?;
            let sigma_m = law.range_sigma_m(counts, bearing)?;
            let reach_m = range_m + deviations * sigma_m;
            let place = Point::new(reach_m, 0.0).rotated(Rotation::by(bearing));
            Some((1e3 * f64::from(place.x), 1e3 * f64::from(place.y)))
        })
        .collect()
}
