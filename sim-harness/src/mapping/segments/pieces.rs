//! Pieces of segments, and what hides them.

use amiro_ipf::model::Photometry;

use crate::geometry::{Pose2, Vector};

/// Length of the pieces that segments are drawn in, metres.
pub(super) const PIECE_M: f64 = 0.0025;
/// Deviation beyond which a reading counts no harder, standard deviations.
const HUBER: f64 = 3.0;
/// Distance from a sensor within which walls and cells are considered, metres.
pub(super) const REACH_M: f64 = 0.30;

/// A piece of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallPiece {
    pub(super) wall: usize,
    pub(super) place: Vector,
    pub(super) along: Vector,
    pub(super) length_m: f64,
}

/// S0: the integral of cos(xi t) cos^3(t) over the lobe.
pub(super) fn full_lobe(photometry: &Photometry) -> f64 {
    const STEPS: u32 = 1200;
    let edge = f64::from(photometry.theta_max_rad);
    let step = 2.0 * edge / f64::from(STEPS);
    let at = |index: u32| (f64::from(index) + 0.5) * step - edge;
    let lobe = |t: f64| (f64::from(photometry.xi) * t).cos() * t.cos().powi(3);
    (0..STEPS).map(|index| lobe(at(index))).sum::<f64>() * step
}

pub(super) fn huber(residual: f64) -> f64 {
    let size = residual.abs();
    if size <= HUBER {
        size * size
    } else {
        HUBER * (2.0 * size - HUBER)
    }
}

pub(super) fn pieces(walls: &[[Vector; 2]]) -> Vec<WallPiece> {
    let mut pieces = Vec::new();
    for (wall, [from, to]) in walls.iter().enumerate() {
        let way = *to - *from;
        let length = way.norm();
        if !(length > 0.0 && length < 10.0) {
            continue;
        }
        let count = (length / PIECE_M).ceil().max(1.0) as u32;
        for index in 0..count {
            let share = (f64::from(index) + 0.5) / f64::from(count);
            pieces.push(WallPiece {
                wall,
                place: *from + way.scaled(share),
                along: way.scaled(1.0 / length),
                length_m: length / f64::from(count),
            });
        }
    }
    pieces
}

/// The walls near a sensor.
pub(super) fn near(walls: &[[Vector; 2]], place: Vector) -> Vec<usize> {
    let all = walls.iter().enumerate();
    all.filter(|(_, [from, to])| place.distance_from_segment(*from, *to) < REACH_M)
        .map(|(index, _)| index)
        .collect()
}

/// Whether a wall other than the given one crosses the way from a sensor to a place.
pub(super) fn is_hidden(
    walls: &[[Vector; 2]],
    near: &[usize],
    own: Option<usize>,
    sensor: &Pose2,
    place: Vector,
) -> bool {
    let from = sensor.position;
    let way = place - from;
    near.iter()
        .filter(|index| Some(**index) != own)
        .filter_map(|index| walls.get(*index))
        .any(|[a, b]| {
            let wall = *b - *a;
            let determinant = way.cross(wall);
            if determinant == 0.0 {
                return false;
            }
            let off = *a - from;
            let along_way = off.cross(wall) / determinant;
            let along_wall = off.cross(way) / determinant;
            (0.0..1.0).contains(&along_way) && (0.0..=1.0).contains(&along_wall)
        })
}
