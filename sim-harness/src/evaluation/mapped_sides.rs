//! Whether a side of the path was mapped at all.

use crate::mapping::{Map, Occupancy};
use crate::world::Vector;

/// Distances from the path, in hundredths of a metre, at which a side is looked at: from
/// beside the hull to well within the range of any sensor.
const ASIDE_CM: core::ops::RangeInclusive<u8> = 6..=15;

/// Whether a map has a known cell straight beside an end of a path's segment, on one side.
pub(super) fn is_mapped(map: &Map, path: &[Vector], segment: usize, is_left: bool) -> bool {
    let (Some(&from), Some(&to)) = (path.get(segment), path.get(segment + 1)) else {
        return false;
    };
    let way = to - from;
    let length_m = way.norm();
    if length_m <= 0.0 {
        return false;
    }
    let sign = if is_left { 1.0 } else { -1.0 };
    let aside = Vector::new(-way.y, way.x).scaled(sign / length_m);
    // Every 10 mm, which is the length of a step.
    let stations = (length_m / 0.01).ceil().min(1e4) as u32;
    (0..=stations).any(|station| {
        let place = from + way.scaled(f64::from(station) / f64::from(stations.max(1)));
        ASIDE_CM.into_iter().any(|centimetres| {
            let place = place + aside.scaled(0.01 * f64::from(centimetres));
            map.occupancy_at(place.x, place.y) != Occupancy::Unknown
        })
    })
}
