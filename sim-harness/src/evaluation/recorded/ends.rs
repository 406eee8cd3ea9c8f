//! Ends of mapped walls against those of the walls that stood there.
//!
//! A mapped wall stands for a face if its projection covers more than half of the face and
//! lies within 50 mm of it; of several the nearest. A true end counts if some sensor in use
//! had it in its lobe, within 0.2 m, at some station.

use amiro_ipf::model::Ring;
use serde::Serialize;

use super::face::Face;
use super::series::Series;
use crate::geometry::Vector;
use crate::mapping::MappedWall;
use crate::world::SensorPose;

/// Farthest that a true end may be from a sensor, metres: the range up to which the sensors
/// are used.
const REACH_M: f64 = 0.2;
/// Cosine of the half width of the lobe in which an end counts: 60 degrees.
const LOBE_COSINE: f64 = 0.5;
/// Share of a face that a mapped wall must cover to stand for it.
const COVERED: f64 = 0.5;
/// Farthest that a mapped wall may be from the face that it stands for, metres.
const FARTHEST_M: f64 = 0.05;

/// An end of a known wall, and where a method has put it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WallEnd {
    /// Index of the wall in the description of its series.
    pub wall: usize,
    /// Whether this is the end that the description calls `to`.
    pub is_to: bool,
    /// The mapped end, `None` if no mapped wall stands for this one.
    pub mapped: Option<MappedEnd>,
}

/// A mapped end of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MappedEnd {
    /// How far it lies beyond the true end, along the wall, metres; below 0 the mapped wall
    /// is too short.
    pub beyond_m: f64,
    /// Standard deviation of that by the method's own account, metres.
    pub sigma_m: f64,
}

impl WallEnd {
    /// The ends of a series' walls that count.
    pub(super) fn of(series: &Series, walls: &[MappedWall]) -> Vec<Self> {
        let faces = series.faces.iter().enumerate();
        let ends = faces.flat_map(|(wall, face)| {
            let mapped = mapped_ends(face, walls);
            [face.from, face.to]
                .into_iter()
                .enumerate()
                .filter(|(_, end)| is_in_reach(series, *end))
                .map(move |(place, _)| Self {
                    wall,
                    is_to: place == 1,
                    mapped: mapped.map(|ends| ends[place]),
                })
        });
        ends.collect()
    }

    /// RMS of the distances of mapped ends from the true ones, metres; `None` without any.
    pub fn rms_m<'e>(ends: impl IntoIterator<Item = &'e Self>) -> Option<f64> {
        let mapped = ends.into_iter().filter_map(|end| end.mapped);
        let (mut sum, mut count) = (0.0, 0_u32);
        for end in mapped {
            sum += end.beyond_m * end.beyond_m;
            count += 1;
        }
        (count > 0).then(|| (sum / f64::from(count)).sqrt())
    }
}

/// Whether a sensor in use has had a place in its lobe, and near enough.
fn is_in_reach(series: &Series, place: Vector) -> bool {
    let mut poses = series
        .stations
        .iter()
        .flat_map(|station| SensorPose::of(&Ring::AMIRO, series.used, &station.pose));
    poses.any(|sensor| {
        let ray = place - sensor.position;
        let range_m = ray.norm();
        range_m <= REACH_M && ray.dot(sensor.axis.direction()) >= LOBE_COSINE * range_m
    })
}

/// The ends of the mapped wall that stands for a face, in the order of the face's.
fn mapped_ends(face: &Face, walls: &[MappedWall]) -> Option<[MappedEnd; 2]> {
    let standing = walls.iter().filter_map(|wall| {
        let ends = [wall.segment.from, wall.segment.to].map(|end| face.along_m(end));
        let sigmas = wall.end_sigmas_m(face.direction());
        let is_turned = ends[0] > ends[1];
        let ([low, high], sigmas) = if is_turned {
            ([ends[1], ends[0]], [sigmas[1], sigmas[0]])
        } else {
            (ends, sigmas)
        };
        let length_m = face.length_m();
        let covered = [low.max(0.0), high.min(length_m)];
        if covered[1] - covered[0] <= COVERED * length_m {
            return None;
        }
        // Mean distance over the covered part.
        let middle = 0.5 * (covered[0] + covered[1]);
        let share = (middle - ends[0]) / (ends[1] - ends[0]);
        let distance_m = face.distance_m(wall.segment.at(share));
        let mapped = [-low, high - length_m]
            .into_iter()
            .zip(sigmas)
            .map(|(beyond_m, sigma_m)| MappedEnd { beyond_m, sigma_m });
        let mapped: Vec<MappedEnd> = mapped.collect();
        (distance_m <= FARTHEST_M).then_some((distance_m, <[MappedEnd; 2]>::try_from(mapped).ok()?))
    });
    let nearest = standing.min_by(|(a, _), (b, _)| a.total_cmp(b));
    nearest.map(|(_, ends)| ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::WallSegment;

    fn wall(from: (f64, f64), to: (f64, f64)) -> MappedWall {
        MappedWall {
            segment: WallSegment::new(Vector::new(from.0, from.1), Vector::new(to.0, to.1)),
            covariance_m2: [[1e-6; 4]; 4],
            gain: 100.0,
        }
    }

    /// The example's first series: a wall from (0.40, 0.07) to (0.80, 0.07).
    fn beyond_mm(walls: &[MappedWall]) -> Vec<Option<i32>> {
        let ends = WallEnd::of(&Series::blank(), walls);
        assert_eq!(
            ends.iter().map(|end| end.is_to).collect::<Vec<_>>(),
            [false, true]
        );
        let millimetres = |end: &WallEnd| Some((1e3 * end.mapped?.beyond_m).round() as i32);
        ends.iter().map(millimetres).collect()
    }

    #[test]
    fn an_end_beyond_the_true_one_is_positive_at_either_end_whatever_the_order() {
        for mapped in [
            wall((0.395, 0.072), (0.797, 0.069)),
            wall((0.797, 0.069), (0.395, 0.072)),
        ] {
            assert_eq!(beyond_mm(&[mapped]), [Some(5), Some(-3)]);
            let ends = WallEnd::of(&Series::blank(), &[mapped]);
            // The wall is 5 and 3 mm off, and 1 mm by its own account.
            let rms_m = WallEnd::rms_m(&ends).unwrap();
            assert!((rms_m - 17.0_f64.sqrt() * 1e-3).abs() < 1e-12, "{rms_m}");
            assert!((ends[0].mapped.unwrap().sigma_m - 1e-3).abs() < 1e-12);
        }
    }

    #[test]
    fn a_wall_that_covers_half_or_lies_elsewhere_stands_for_none() {
        assert_eq!(beyond_mm(&[]), [None, None]);
        assert_eq!(
            beyond_mm(&[wall((0.40, 0.07), (0.599, 0.07))]),
            [None, None]
        );
        assert_eq!(beyond_mm(&[wall((0.40, 0.13), (0.80, 0.13))]), [None, None]);
        assert_eq!(WallEnd::rms_m(&WallEnd::of(&Series::blank(), &[])), None);
    }

    #[test]
    fn of_two_walls_that_cover_a_face_the_nearer_one_stands_for_it() {
        let far = wall((0.41, 0.10), (0.79, 0.10));
        let near = wall((0.398, 0.071), (0.801, 0.071));
        assert_eq!(beyond_mm(&[far, near]), [Some(2), Some(1)]);
    }

    #[test]
    fn an_end_that_no_sensor_reaches_does_not_count() {
        let mut series = Series::blank();
        // From the first eight stations the wall's far end, at 0.8 m, is not in reach.
        series.stations.truncate(8);
        let ends = WallEnd::of(&series, &[wall((0.40, 0.07), (0.80, 0.07))]);
        assert_eq!(ends.len(), 1, "{ends:?}");
        assert!(!ends[0].is_to);
    }
}
