//! Maps of tracked wall segments.
//!
//! The core's [`SegmentTracker`] follows the walls beside the robot. This mapper keeps the
//! last state of each segment in the world, with all readings of the drive, and draws the
//! segments as the batch map draws its walls: what the readings need. The far end of a
//! long wall that no reading shows is not drawn.

use amiro_ipf::filter::{SegmentModel, SegmentParameters, SegmentTracker};
use amiro_ipf::geometry::{Motion, Pose};
use amiro_ipf::model::{Photometry, Ring, SENSORS, Sample};

use super::WallMapParameters;
use super::readings::Readings;
use super::scene::WallScene;
use crate::drive::{KnownWall, KnownWalls, RangeScan, Record, WallState, WallStep};
use crate::geometry::Pose2;
use crate::mapping::{FinishProgress, Map, MappedWall, Mapper, Setup};
use crate::sensors::{Sensor, WallSegment};

/// Maps the segments of a [`SegmentTracker`] that the readings need.
///
/// Records other than scans with the signals of eight sensors are passed over. The
/// segments follow each scan; `finish` draws them, and before it all is unknown.
#[derive(Clone, Debug)]
pub struct SegmentMapper {
    drawing: WallMapParameters,
    photometry: Photometry,
    model: SegmentModel,
    tracker: SegmentTracker,
    pose: Option<Pose>,
    steps: u32,
    known: KnownWalls,
    readings: Readings,
    walls: Vec<MappedWall>,
    map: Map,
}

impl SegmentMapper {
    /// An empty map. The law and the mounts are those of the setup's rig; a rig without
    /// eight reflective infrared sensors gives a map that stays empty.
    #[must_use]
    pub fn new(
        setup: &Setup<'_>,
        parameters: SegmentParameters,
        drawing: WallMapParameters,
    ) -> Self {
        let mounts = &setup.rig.mounts;
        let photometry = mounts.iter().find_map(|mount| match &mount.sensor {
            Sensor::Infrared(infrared) => Some(*infrared.photometry()),
            Sensor::Cone(_) | Sensor::Scanner(_) => None,
        });
        let photometry = photometry.unwrap_or(Photometry::VCNL4020);
        let poses: Vec<Pose2> = mounts.iter().map(|mount| mount.body_from_sensor).collect();
        Self {
            drawing,
            photometry,
            model: SegmentModel::new(parameters, &photometry, &ring(&poses)),
            tracker: SegmentTracker::new(),
            pose: None,
            steps: 0,
            known: KnownWalls::new(f64::from(parameters.drop_evidence)),
            readings: Readings::new(setup.rig, drawing),
            walls: Vec::new(),
            map: Map::unknown(setup.lattice),
        }
    }

    fn add(&mut self, scan: &RangeScan) {
        let Ok(signals) = <[Option<f64>; SENSORS]>::try_from(scan.signals.as_slice()) else {
            return;
        };
        let beta_counts = f64::from(self.photometry.beta_counts);
        let samples = signals.map(|signal| match signal {
            Some(signal) => Sample::Counts((signal + beta_counts).round() as i32),
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
                if segment.evidence() >= self.model.parameters().drop_evidence {
                    left.push(segment.id());
                }
            });
        let step = WallStep {
            index: self.steps,
            stamp_us: Some(scan.stamp_us),
        };
        self.steps = self.steps.wrapping_add(1);
        let segments = self.tracker.segments().iter();
        let seen =
            segments.map(|segment| (segment.id(), WallState::of(&self.tracker, segment, &pose)));
        self.known.step(step, seen, &[], &left);
        self.readings.take(scan);
    }
}

impl Mapper for SegmentMapper {
    fn take(&mut self, record: &Record) {
        match record {
            Record::Scan(scan) => self.add(scan),
            // The tracker starts again; what it knew stays in the map.
            Record::OdometryReset { .. } => {
                self.known.reset();
                self.tracker.reset();
                self.pose = None;
            }
            Record::Pose { .. } | Record::Outcomes(_) => {}
        }
    }

    fn finish(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        self.readings.mark_clipped();
        self.walls = self.known.standing().map(mapped).collect();
        let mut scene = WallScene::new(&self.readings, &self.drawing);
        for wall in &self.walls {
            scene.change(&[(scene.next(), Some(wall.segment))]);
        }
        self.map = scene.draw(self.map.lattice(), progress);
    }

    fn is_online(&self) -> bool {
        false
    }

    fn walls(&self) -> &[MappedWall] {
        &self.walls
    }

    fn map(&self) -> Map {
        self.map.clone()
    }
}

/// A segment as a wall of the map: its deviations along and across as a covariance.
fn mapped(wall: &KnownWall) -> MappedWall {
    let state = &wall.state;
    let [from, to] = state.ends;
    let way = to - from;
    let along = way.scaled(1.0 / way.norm().max(1e-9));
    let mut covariance_m2 = [[0.0; 4]; 4];
    for (end, (along_m, across_m)) in state.along_m.iter().zip(state.across_m).enumerate() {
        let block = match (along_m, across_m) {
            (Some(t), Some(n)) => {
                let (t, n) = (t * t, n * n);
                let (xx, yy) = (along.x * along.x, along.y * along.y);
                let xy = (t - n) * along.x * along.y;
                [[t * xx + n * yy, xy], [xy, t * yy + n * xx]]
            }
            _ => [[f64::INFINITY; 2]; 2],
        };
        for (row, values) in covariance_m2.iter_mut().skip(2 * end).zip(block) {
            for (place, value) in row.iter_mut().skip(2 * end).zip(values) {
                *place = value;
            }
        }
    }
    MappedWall {
        segment: WallSegment::new(from, to),
        covariance_m2,
        gain: state.evidence,
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
    use amiro_ipf::model::{TabulatedWallLaw, Wall};
    use amiro_ipf::node::Config;

    /// A drive along x past a wall from x = 0.2 to 0.6, 60 mm left of the hull.
    fn drive(mapper: &mut dyn Mapper, config: &Config) {
        let law = TabulatedWallLaw::of(&config.photometry);
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
            for record in crate::drive::scan_records(config, 0, pose, &samples) {
                mapper.take(&record);
            }
        }
    }

    #[test]
    fn a_wall_is_drawn_in_its_place_and_what_is_before_it_is_free() {
        let config = Config::amiro(Profile::Paper);
        let mut mapper = Method::SEGMENTS.mapper(&Setup::new(&Rig::from(&config), 0.01));
        drive(&mut mapper, &config);
        mapper.finish(&mut |_| {});
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
        mapper.finish(&mut |_| {});
        assert_eq!(mapper.map().count(Occupancy::Free), 0);
    }
}
