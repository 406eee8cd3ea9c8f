//! Maps of tracked wall segments.
//!
//! The core's [`SegmentTracker`] follows the walls beside the robot. This mapper keeps
//! the last state of each segment in the world, with all readings of the drive, and
//! draws what the readings need:
//!
//! - **Occupied** is a piece of a segment without which the readings would change by more
//!   than a threshold: chi^2 = sum of (ln((S + d0) / (S - q + d0)) / sd)^2 over the
//!   readings, with the signal S of all segments and the part q of 20 mm about the piece.
//!   What is merely believed, as the far end of a long wall, is not drawn.
//! - **Free** is a cell in which a patch of 20 mm that faces each sensor would change the
//!   readings by more than another threshold, and would explain them worse.
//!
//! The signal is the law of walls (see the core's `WallLaw`), summed over pieces of
//! 2.5 mm that no other segment hides; a piece at range r and bearing t adds
//! alpha / S0 cos(xi t) cos^2(i) length / r^3.

mod pieces;

use std::collections::BTreeMap;

use amiro_ipf::filter::{SegmentModel, SegmentParameters, SegmentTracker};
use amiro_ipf::geometry::{Motion, Pose};
use amiro_ipf::model::{Photometry, Ring, SENSORS, Sample};

use self::pieces::{PIECE_M, REACH_M, WallPiece, full_lobe, huber, is_hidden, near, pieces};
use super::{Belief, Grid, Map, Mapper, Setup};
use crate::drive::{RangeScan, Record};
use crate::geometry::{Pose2, Vector};
use crate::sensors::Sensor;

/// Length of wall that is judged, metres: that of the patch, and about each piece.
const JUDGED_M: f64 = 0.02;
/// Least range of the law, metres.
const LEAST_RANGE_M: f64 = 0.01;

/// When segments and free cells are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentDrawing {
    /// Least chi^2 of 20 mm of wall. More: fewer false cells, and shorter walls.
    pub occupied: f64,
    /// Least chi^2 of a patch of 20 mm in a free cell. More: less is known to be free.
    pub free: f64,
    /// Distance from a segment within which no cell is free, metres.
    pub clear_m: f64,
    /// Least evidence of a segment that was left behind.
    pub evidence: f32,
}

impl SegmentDrawing {
    /// For a step per 10 mm.
    pub const STEPS: Self = Self {
        occupied: 16.0,
        free: 25.0,
        clear_m: 0.009,
        evidence: 12.0,
    };
}

/// A segment in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WorldWall {
    ends: [Vector; 2],
    evidence: f32,
}

/// A reading of one sensor.
#[derive(Clone, Copy, Debug)]
struct WorldReading {
    world_from_sensor: Pose2,
    /// ln(d + d0).
    log_signal: f64,
    sigma: f64,
}

/// What would change if a cell were occupied.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Patch {
    chi2: f64,
    cost: f64,
}

/// Maps the segments of a [`SegmentTracker`] that the readings need.
#[derive(Clone, Debug)]
pub struct SegmentMapper {
    cell_m: f64,
    drawing: SegmentDrawing,
    photometry: Photometry,
    mounts: Vec<Pose2>,
    /// alpha / S0, counts m^2.
    gain: f64,
    model: SegmentModel,
    tracker: SegmentTracker,
    pose: Option<Pose>,
    walls: BTreeMap<u16, WorldWall>,
    /// Walls that are left for good: their numbers may be used again.
    left: Vec<WorldWall>,
    measured: Vec<WorldReading>,
}

impl SegmentMapper {
    /// An empty map. The law and the mounts are those of the setup's rig; a rig without
    /// reflective infrared sensors gives a map that stays empty.
    #[must_use]
    pub fn new(setup: &Setup<'_>, parameters: SegmentParameters, drawing: SegmentDrawing) -> Self {
        let infrared = setup
            .rig
            .mounts
            .iter()
            .find_map(|mount| match &mount.sensor {
                Sensor::Infrared(infrared) => Some(*infrared.photometry()),
                _ => None,
            });
        let photometry = infrared.unwrap_or(Photometry::VCNL4020);
        let mounts: Vec<Pose2> = setup
            .rig
            .mounts
            .iter()
            .map(|mount| mount.body_from_sensor)
            .collect();
        let ring = ring(&mounts);
        Self {
            cell_m: setup.cell_m,
            drawing,
            photometry,
            mounts,
            gain: f64::from(photometry.alpha_counts_m2) / full_lobe(&photometry),
            model: SegmentModel::new(parameters, &photometry, &ring),
            tracker: SegmentTracker::new(),
            pose: None,
            walls: BTreeMap::new(),
            left: Vec::new(),
            measured: Vec::new(),
        }
    }

    fn add(&mut self, scan: &RangeScan) {
        let Ok(signals) = <[Option<f64>; SENSORS]>::try_from(scan.signals.as_slice()) else {
            return;
        };
        let beta = self.photometry.beta_counts;
        let samples = signals.map(|signal| match signal {
            Some(signal) => Sample::Counts((signal + f64::from(beta)).round() as i32),
            None => Sample::Missing,
        });
        let place = scan.world_from_body.position;
        let heading = scan.world_from_body.heading_rad();
        let pose = Pose::new(place.x as f32, place.y as f32, heading as f32);
        let motion = self.pose.map_or(Motion::NONE, |last| last.motion_to(&pose));
        self.pose = Some(pose);
        let mut left = Vec::new();
        self.tracker
            .step(&self.model, &motion, &samples, &mut |segment| {
                left.push((segment.id(), segment.evidence()));
            });
        for (id, evidence) in left {
            // Its last place is that of the step before.
            if let Some(wall) = self.walls.remove(&id)
                && evidence >= self.drawing.evidence
            {
                self.left.push(wall);
            }
        }
        self.walls.clear();
        for segment in self.tracker.segments() {
            let ends = segment
                .ends()
                .map(|end| Vector::from(pose.world_from_body(self.tracker.body_from_track(end))));
            let wall = WorldWall {
                ends,
                evidence: segment.evidence(),
            };
            self.walls.insert(segment.id(), wall);
        }
        self.measure(scan, &samples);
    }

    fn measure(&mut self, scan: &RangeScan, samples: &[Sample]) {
        let parameters = self.model.parameters();
        for (mount, sample) in self.mounts.iter().zip(samples) {
            let Sample::Counts(counts) = sample else {
                continue;
            };
            let signal = f64::from(*counts) - f64::from(self.photometry.beta_counts);
            let lifted = (signal + f64::from(parameters.soft_counts)).max(2.0);
            let noise = f64::from(parameters.sigma_counts) / lifted;
            let body = &scan.world_from_body;
            self.measured.push(WorldReading {
                world_from_sensor: Pose2 {
                    position: body.place(mount.position),
                    heading: mount.heading.after(body.heading),
                },
                log_signal: lifted.ln(),
                sigma: noise.hypot(f64::from(parameters.relative_sigma)),
            });
        }
    }

    /// Return of a piece of surface, counts: its place in the sensor's frame, cos(i), and
    /// its length.
    fn part(&self, place: Vector, cosine: f64, length_m: f64) -> f64 {
        let bearing = place.y.atan2(place.x);
        if bearing.abs() > f64::from(self.photometry.theta_max_rad) {
            return 0.0;
        }
        let lobe = (f64::from(self.photometry.xi) * bearing).cos().max(0.0);
        let range = place.norm().max(LEAST_RANGE_M);
        self.gain * lobe * cosine * cosine * length_m / (range * range * range)
    }

    fn all_walls(&self) -> Vec<[Vector; 2]> {
        let all = self.left.iter().chain(self.walls.values());
        all.map(|wall| wall.ends).collect()
    }

    /// Signal of all pieces in each reading, and chi^2 of each piece.
    fn judge_pieces(&self, walls: &[[Vector; 2]], pieces: &[WallPiece]) -> (Vec<f64>, Vec<f64>) {
        let soft = f64::from(self.model.parameters().soft_counts);
        let mut chi2 = vec![0.0; pieces.len()];
        let mut signals = Vec::new();
        let mut parts: Vec<(usize, f64)> = Vec::new();
        for measured in &self.measured {
            let sensor = &measured.world_from_sensor;
            let near = near(walls, sensor.position);
            parts.clear();
            for (index, piece) in pieces.iter().enumerate() {
                let way = piece.place - sensor.position;
                let range = way.norm();
                if range > REACH_M {
                    continue;
                }
                let cosine = (piece.along.cross(way) / range.max(1e-9)).abs();
                let part = self.part(sensor.view(piece.place), cosine, piece.length_m);
                if part > 0.0 && !is_hidden(walls, &near, Some(piece.wall), sensor, piece.place) {
                    parts.push((index, part));
                }
            }
            let signal: f64 = parts.iter().map(|(_, part)| part).sum();
            for (index, part) in &parts {
                let judged = (part * JUDGED_M / PIECE_M).min(signal);
                let change = ((signal + soft) / (signal - judged + soft)).ln() / measured.sigma;
                if let Some(chi2) = chi2.get_mut(*index) {
                    *chi2 += change * change;
                }
            }
            signals.push(signal);
        }
        (signals, chi2)
    }

    /// What patches in the cells about the sensors would change.
    fn judge_cells(&self, walls: &[[Vector; 2]], signals: &[f64]) -> Grid<Patch> {
        let soft = f64::from(self.model.parameters().soft_counts);
        let mut patches = Grid::new(self.cell_m, Patch::default());
        let count = (REACH_M / self.cell_m).ceil() as i32;
        for (measured, signal) in self.measured.iter().zip(signals) {
            let sensor = &measured.world_from_sensor;
            let near = near(walls, sensor.position);
            let Some(centre) = patches.cell_at(sensor.position.x, sensor.position.y) else {
                continue;
            };
            let residual = (measured.log_signal - (signal + soft).ln()) / measured.sigma;
            for row in centre.row - count..=centre.row + count {
                for column in centre.column - count..=centre.column + count {
                    let cell = crate::lattice::Cell { row, column };
                    let (x, y) = patches.centre(cell);
                    let place = Vector::new(x, y);
                    let part = self.part(sensor.view(place), 1.0, JUDGED_M);
                    let change = ((signal + part + soft) / (signal + soft)).ln() / measured.sigma;
                    // Changes below a tenth of a standard deviation add up to nothing.
                    if change < 0.1 || is_hidden(walls, &near, None, sensor, place) {
                        continue;
                    }
                    if let Some(patch) = patches.reach(cell) {
                        patch.chi2 += change * change;
                        patch.cost += huber(residual - change) - huber(residual);
                    }
                }
            }
        }
        patches
    }
}

impl Mapper for SegmentMapper {
    fn take(&mut self, record: &Record) {
        match record {
            Record::Scan(scan) => self.add(scan),
            Record::OdometryReset { .. } => {
                self.left.extend(
                    self.walls
                        .values()
                        .filter(|wall| wall.evidence >= self.drawing.evidence),
                );
                self.walls.clear();
                self.tracker.reset();
                self.pose = None;
            }
            Record::Pose { .. } | Record::Outcomes(_) => {}
        }
    }

    fn map(&self) -> Map {
        let walls = self.all_walls();
        let pieces = pieces(&walls);
        let (signals, chi2) = self.judge_pieces(&walls, &pieces);
        let patches = self.judge_cells(&walls, &signals);
        let mut map = Map::unknown(self.cell_m);
        for (cell, patch) in patches.iter() {
            let (x, y) = patches.centre(cell);
            let place = Vector::new(x, y);
            let is_clear = walls
                .iter()
                .all(|[from, to]| place.distance_from_segment(*from, *to) > self.drawing.clear_m);
            if patch.chi2 > self.drawing.free
                && patch.cost > 0.0
                && is_clear
                && let Some(belief) = map.reach(cell)
            {
                *belief = Belief::of_probability(0.0);
            }
        }
        for (piece, chi2) in pieces.iter().zip(chi2) {
            if chi2 > self.drawing.occupied
                && let Some(belief) = map.reach_at(piece.place.x, piece.place.y)
            {
                *belief = Belief::of_probability(1.0);
            }
        }
        map
    }
}

/// The ring of the mounts of an AMiRo; its own for other robots.
fn ring(mounts: &[Pose2]) -> Ring {
    let mut ring = Ring::AMIRO;
    if mounts.len() == SENSORS {
        for (axis, mount) in ring.axis_rad.iter_mut().zip(mounts) {
            *axis = mount.heading_rad() as f32;
        }
        if let Some(mount) = mounts.first() {
            ring.radius_m = mount.position.norm() as f32;
        }
    }
    ring
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::{Method, Occupancy};
    use crate::rig::Rig;
    use amiro_ipf::filter::Profile;
    use amiro_ipf::geometry::{Point, Rotation};
    use amiro_ipf::model::{Wall, WallLaw};
    use amiro_ipf::node::Config;

    /// A drive along x past a wall from x = 0.2 to 0.6, 60 mm left of the hull.
    fn drive(mapper: &mut dyn Mapper, config: &Config) {
        let law = WallLaw::of(&config.photometry);
        let wall: Wall = [Point::new(0.2, 0.11), Point::new(0.6, 0.11)];
        for step in 0..=70_u8 {
            let pose = Pose::new(0.01 * f32::from(step), 0.0, 0.0);
            let body = Rotation::by(pose.heading.radians()).inverse();
            let samples = core::array::from_fn::<_, SENSORS, _>(|sensor| {
                let mount = config.ring.mount(sensor);
                let seen =
                    wall.map(|end| mount.sensor_from_body((end - pose.position).rotated(body)));
                Sample::Counts(amiro_ipf::math::round_to_i32(
                    law.signal(&[seen]) + law.beta_counts(),
                ))
            });
            for record in crate::drive::scan_records(&config.photometry, 0, pose, &samples) {
                mapper.take(&record);
            }
        }
    }

    #[test]
    fn a_wall_is_drawn_in_its_place_and_what_is_before_it_is_free() {
        let config = Config::amiro(Profile::Paper);
        let mut mapper = Method::SEGMENTS.mapper(&Setup::new(&Rig::from(&config), 0.01));
        drive(&mut mapper, &config);
        let map = mapper.map();
        let occupied: Vec<_> = map.cells_of(Occupancy::Occupied).collect();
        for cell in &occupied {
            let (x, y) = map.centre(*cell);
            assert!(
                (y - 0.11).abs() < 0.006 && (0.19..0.61).contains(&x),
                "{x}, {y}"
            );
        }
        // A wall on the edge of two rows of cells may be drawn in either.
        let columns: std::collections::BTreeSet<_> =
            occupied.iter().map(|cell| cell.column).collect();
        assert!(columns.len() >= 38, "{columns:?}");
        for (x, y) in [(0.3, 0.085), (0.5, 0.09), (0.35, -0.1)] {
            let cell = map.cell_at(x, y).unwrap();
            let belief = map.get(cell).unwrap();
            assert_eq!(belief.occupancy(), Occupancy::Free, "{x}, {y}");
        }
        assert!(map.count(Occupancy::Free) > 300);
    }

    #[test]
    fn a_robot_without_counts_has_an_empty_map() {
        let config = Config::amiro(Profile::Paper);
        let mut mapper = Method::SEGMENTS.mapper(&Setup::new(&Rig::from(&config), 0.01));
        mapper.take(&Record::Scan(RangeScan {
            stamp_us: 0,
            world_from_body: Pose2::new(0.0, 0.0, 0.0),
            mounts: 0..0,
            returns: Vec::new(),
            signals: Vec::new(),
        }));
        assert_eq!(mapper.map().count(Occupancy::Free), 0);
    }
}
