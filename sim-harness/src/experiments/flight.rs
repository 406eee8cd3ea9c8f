//! The beam filter on several drones in a room with exact walls, alone and sharing.

use amiro_ipf::beam_filter::{
    BeamFilterParameters, BeamModel, BeamParticle, BeamParticleFilter, BeamRange, RangeBeam,
};
use amiro_ipf::filter::ParameterError;
use amiro_ipf::geometry::{Angle, Motion, Point, Pose};
use amiro_ipf::random::Generator;

use super::RoomWalls;
use crate::datasets::{Dataset, DatasetError, DriveFile, NanoSwarm};
use crate::drive::{RangeScan, Record, Return};
use crate::escape::whole_escaped;
use crate::geometry::{Pose2, Vector};
use crate::mapping::mount_returns;
use crate::rig::Rig;
use crate::sensors::Sensor;
use crate::world::TrueWorld;

/// Runs of the recordings nano_swarm; drones share in those with four.
pub const RUNS: [FlightRun; 4] = [
    FlightRun::new("exp1/two-drones", false),
    FlightRun::new("exp1/four-drones", true),
    FlightRun::new("exp2/two-drones", false),
    FlightRun::new("exp2/four-drones", true),
];

/// Particles of a drone.
const PARTICLES: usize = 1000;

/// How much shorter than the disc's radius a beam is at most, metres.
const MARGIN_M: f64 = 0.1;

/// Frames of a scan.
const FRAMES: usize = 15;

/// A particle is at a wall, and a point of a wall is found, within this distance, metres.
const NEAR_M: f64 = 0.10;

/// Points of walls up to this distance and in sight are to be found, metres.
const SURFACE_M: f64 = 1.3;

/// One run of the recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlightRun {
    /// Its folder.
    pub folder: &'static str,
    /// Whether its drones share.
    pub is_shared: bool,
}

impl FlightRun {
    const fn new(folder: &'static str, is_shared: bool) -> Self {
        Self { folder, is_shared }
    }
}

/// The form of the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlightForm {
    /// [`BeamFilterParameters::MOVING`].
    Moving,
    /// [`BeamFilterParameters::PAPER`].
    Paper,
}

impl FlightForm {
    /// Both forms.
    pub const ALL: [Self; 2] = [Self::Moving, Self::Paper];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving robot",
            Self::Paper => "paper's form",
        }
    }

    fn parameters(self) -> BeamFilterParameters {
        match self {
            Self::Moving => BeamFilterParameters::MOVING.for_frames(),
            Self::Paper => BeamFilterParameters::PAPER.for_frames(),
        }
    }
}

/// The scans of one drone, each a list of frames: pose and beams.
#[derive(Clone, Debug, Default)]
pub struct Drone {
    scans: Vec<Vec<(Pose2, Vec<RangeBeam>)>>,
}

/// Figures of drones after each of their scans.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightFigures {
    /// Distance of the nearest high particle less that of the nearest wall, metres.
    nearest_error_m: Vec<f64>,
    /// Scans after which no particle was high.
    pub blind: usize,
    /// High particles: near a wall, and all.
    precision: [f64; 2],
    /// Share of the points in sight that are found, summed over scans.
    recall: f64,
    /// Share of all points within the disc that are found, summed over scans.
    recall_of_all: f64,
    /// Particles taken over from other drones.
    pub imported: u64,
    /// Scans.
    pub scans: usize,
}

/// Drones of one recording in a room.
#[derive(Clone, Debug)]
pub struct Flight {
    drones: Vec<Drone>,
    walls: RoomWalls,
}

impl Flight {
    /// Reads a recording and the walls beside it; its drones have beams up to the disc's
    /// radius less a margin.
    ///
    /// # Errors
    /// As [`Dataset::read`], and where no walls are beside it.
    pub fn read(drive: &DriveFile<'_>) -> Result<Self, DatasetError> {
        let Some(TrueWorld::Walls(walls)) = NanoSwarm.true_world(drive.path)? else {
            return Err(DatasetError::Read {
                file: whole_escaped(drive.path.to_string_lossy().chars()),
                source: std::io::Error::other("no file of walls is beside the experiments"),
            });
        };
        let radius_m = f64::from(FlightForm::Moving.parameters().local_radius_m);
        let mut drones = vec![Vec::new()];
        NanoSwarm.read(drive, &mut |_, _| {}, &mut |record| match record {
            Record::OdometryReset { .. } => drones.push(Vec::new()),
            Record::Scan(scan) => {
                if let Some(frames) = drones.last_mut() {
                    let beams = beams(drive.rig, scan, radius_m - MARGIN_M);
                    frames.push((scan.world_from_body, beams));
                }
            }
            _ => {}
        })?;
        let drones = drones.into_iter().map(|frames: Vec<_>| Drone {
            scans: frames.chunks(FRAMES).map(<[_]>::to_vec).collect(),
        });
        Ok(Self {
            drones: drones.collect(),
            walls: RoomWalls::new(walls),
        })
    }

    /// Flies all drones, scan by scan; with sharing, drones near each other exchange their
    /// high particles after each scan.
    ///
    /// # Errors
    /// A parameter outside its range: none of the program's own is.
    pub fn fly(
        &self,
        form: FlightForm,
        is_shared: bool,
        seed: u64,
    ) -> Result<FlightFigures, ParameterError> {
        let model = BeamModel::new(form.parameters())?;
        let mut figures = FlightFigures::default();
        let mut pilots: Vec<_> = (0..self.drones.len() as u64)
            .map(|number| DroneFilter::new(seed.wrapping_mul(1000).wrapping_add(number)))
            .collect();
        let scans = self.drones.iter().map(|drone| drone.scans.len()).max();
        for number in 0..scans.unwrap_or(0) {
            let mut present = Vec::new();
            for (index, (drone, pilot)) in self.drones.iter().zip(&mut pilots).enumerate() {
                if let Some(scan) = drone.scans.get(number) {
                    pilot.fly(&model, scan);
                    present.push(index);
                }
            }
            if is_shared {
                figures.imported += share(&model, &mut pilots);
            }
            for index in present {
                if let Some(pilot) = pilots.get(index) {
                    figures.add(&self.walls, &model, pilot);
                }
            }
        }
        Ok(figures)
    }
}

/// The beams of a scan; a range beyond the reach is a beam without an echo.
fn beams(rig: &Rig, scan: &RangeScan, reach_m: f64) -> Vec<RangeBeam> {
    let mut beams = Vec::with_capacity(scan.returns.len());
    for mounted in mount_returns(rig, scan) {
        let Sensor::Scanner(scanner) = &mounted.mount.sensor else {
            continue;
        };
        for (index, measured) in mounted.recorded().enumerate() {
            let range = match measured {
                Return::Echo { range_m, .. } if range_m <= reach_m => {
                    BeamRange::Echo(range_m as f32)
                }
                Return::Echo { .. } | Return::NoEcho { .. } => BeamRange::NoEcho(reach_m as f32),
                Return::TooClose | Return::Invalid => continue,
            };
            let at = mounted.mount.body_from_sensor;
            let heading_rad = at.heading_rad() + scanner.bearing_rad(index);
            let axis = core_pose(at.position, heading_rad);
            beams.extend(RangeBeam::new(&axis, range));
        }
    }
    beams
}

fn core_pose(place: Vector, heading_rad: f64) -> Pose {
    Pose::new(place.x as f32, place.y as f32, heading_rad as f32)
}

/// The filter of one drone.
struct DroneFilter {
    filter: Box<BeamParticleFilter<PARTICLES>>,
    rng: Generator,
    pose: Option<Pose2>,
}

impl DroneFilter {
    fn new(seed: u64) -> Self {
        Self {
            filter: Box::new(BeamParticleFilter::new()),
            rng: Generator::seeded(seed),
            pose: None,
        }
    }

    /// One scan, a cycle per frame.
    fn fly(&mut self, model: &BeamModel, scan: &[(Pose2, Vec<RangeBeam>)]) {
        for (pose, beams) in scan {
            let motion = match self.pose.replace(*pose) {
                None => {
                    let heading = Angle::from_radians(pose.heading_rad() as f32);
                    self.filter.reset(model, PARTICLES, heading, &mut self.rng);
                    Motion::NONE
                }
                Some(last) => {
                    let heading = Angle::from_radians(last.heading_rad() as f32);
                    self.filter.set_heading(heading);
                    let Vector { x, y } = last.view(pose.position);
                    Motion {
                        displacement: Point::new(x as f32, y as f32),
                        turn: Angle::from_radians((pose.heading_rad() - last.heading_rad()) as f32),
                    }
                }
            };
            self.filter.cycle(model, &motion, beams, &mut self.rng);
        }
    }

    /// The pose of the particles' axes, and the drone's pose.
    fn frame(&self) -> Option<(Pose, Vector)> {
        let pose = self.pose?;
        let body = core_pose(pose.position, pose.heading_rad());
        Some((self.filter.particle_frame(&body), pose.position))
    }

    /// Places of the high particles in the world.
    fn high(&self) -> Vec<Vector> {
        let Some((frame, _)) = self.frame() else {
            return Vec::new();
        };
        let high = self.filter.particles().filter(|it| it.is_high());
        high.map(|it| Vector::from(frame.world_from_body(it.position)))
            .collect()
    }
}

/// Every drone takes over the high particles of each other one whose disc meets its own;
/// all send what they had before. Gives how many particles were taken over.
fn share(model: &BeamModel, pilots: &mut [DroneFilter]) -> u64 {
    let sent: Vec<_> = pilots
        .iter()
        .map(|pilot| {
            let mut batch = vec![BeamParticle::default(); PARTICLES];
            let count = pilot.filter.export(&mut batch);
            batch.truncate(count);
            (pilot.frame(), batch)
        })
        .collect();
    let meet_m = 2.0 * f64::from(model.parameters().local_radius_m);
    let mut imported = 0;
    for (receiver, pilot) in pilots.iter_mut().enumerate() {
        let Some((own_frame, place)) = pilot.frame() else {
            continue;
        };
        for (sender, (frame, batch)) in sent.iter().enumerate() {
            if let Some((frame, from)) = frame
                && sender != receiver
                && (*from - place).norm() < meet_m
            {
                let tally = pilot.filter.import(model, &own_frame, frame, batch);
                imported += u64::from(tally.imported);
            }
        }
    }
    imported
}

impl FlightFigures {
    fn add(&mut self, walls: &RoomWalls, model: &BeamModel, pilot: &DroneFilter) {
        let Some((_, place)) = pilot.frame() else {
            return;
        };
        self.scans += 1;
        let high = pilot.high();
        let nearest = high.iter().map(|it| (*it - place).norm()).reduce(f64::min);
        match nearest {
            Some(nearest_m) => self
                .nearest_error_m
                .push((nearest_m - walls.distance_m(place)).abs()),
            None => self.blind += 1,
        }
        let right = high.iter().filter(|it| walls.distance_m(**it) <= NEAR_M);
        self.precision[0] += right.count() as f64;
        self.precision[1] += high.len() as f64;
        let is_found = |point: &&Vector| high.iter().any(|it| (*it - **point).norm() <= NEAR_M);
        let share = |points: &[Vector]| {
            let found = points.iter().filter(is_found).count();
            // A place without walls around it has nothing to be found.
            found as f64 / points.len().max(1) as f64
        };
        let radius_m = f64::from(model.parameters().local_radius_m);
        let all = walls.points_within(place, radius_m);
        let mut seen = walls.points_within(place, SURFACE_M);
        seen.retain(|point| walls.is_in_sight(place, *point));
        self.recall += share(&seen);
        self.recall_of_all += share(&all);
    }

    /// The figures of two flights together.
    #[must_use]
    pub fn plus(mut self, other: &Self) -> Self {
        self.nearest_error_m.extend(&other.nearest_error_m);
        self.blind += other.blind;
        for (sum, count) in self.precision.iter_mut().zip(other.precision) {
            *sum += count;
        }
        self.recall += other.recall;
        self.recall_of_all += other.recall_of_all;
        self.imported += other.imported;
        self.scans += other.scans;
        self
    }

    /// A quantile of the nearest obstacle's error, centimetres, blind scans left out; NaN
    /// without any.
    #[must_use]
    pub fn nearest_error_cm(&self, quantile: f64) -> f64 {
        let mut sorted = self.nearest_error_m.clone();
        sorted.sort_by(f64::total_cmp);
        // Between 0 and the last index.
        let index = (quantile * sorted.len().saturating_sub(1) as f64).round() as usize;
        sorted.get(index).map_or(f64::NAN, |error_m| 1e2 * error_m)
    }

    /// Share of the high particles within 10 cm of a wall.
    #[must_use]
    pub fn precision(&self) -> f64 {
        self.precision[0] / self.precision[1]
    }

    /// Share of the points of walls in sight within 1.3 m that are found, mean of the scans.
    #[must_use]
    pub fn recall(&self) -> f64 {
        self.recall / self.scans as f64
    }

    /// Share of all points of walls within the disc that are found, mean of the scans.
    #[must_use]
    pub fn recall_of_all(&self) -> f64 {
        self.recall_of_all / self.scans as f64
    }
}
