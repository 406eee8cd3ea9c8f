//! The stepped series: which file, which world, which stations.
//!
//! The robot was put down by hand every 50 mm along a straight line. Its own odometry
//! saw nothing of that, it stays within some millimetres of 0 in all six files, and is
//! not used: station i is at the ruler's mark, x = 0.15 + 0.05 i metres, y = 0, looking
//! along x. The headings in the files wander by up to 30 mrad without being put down
//! differently, and are not used either.

use std::path::Path;

use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{SENSORS, Sample, SensorMask};
use amiro_ipf::node::Input;

use super::RecordedError;
use crate::log;
use crate::world::{Scenario, Shape, Vector};

/// The sensors that see the guide robot ahead at every station.
const GUIDE: SensorMask = SensorMask::NONE.with(3).with(4);
/// The sensors that look at nothing but the world beside and behind the robot.
pub(super) const SIDES: SensorMask = GUIDE.complement();
/// Distance between stations, metres.
const STATION_M: f32 = 0.05;
/// Where the first station is, metres.
const FIRST_STATION_M: f32 = 0.15;
/// 50 mm at the 80 mm/s of the paper's drives. The stations have no time of their own.
const STATION_US: u64 = 625_000;
/// Radius of the robot, metres: gaps are measured from its rim.
const RIM_M: f64 = 0.05;
/// The box: along the robot's path, and away from it.
const BOX_M: (f64, f64) = (0.40, 0.10);

/// A side of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

/// A series as it was recorded: file, gap, sides, where the wall begins.
#[derive(Clone, Copy, Debug)]
struct Setting {
    name: &'static str,
    gap_m: f64,
    sides: &'static [Side],
    /// x of the box's near end, metres.
    near_m: f64,
    has_cylinder: bool,
    about: &'static str,
}

const FOLLOWED: &str = "stations by the ruler; box and cylinder as recorded";
/// The ends of these walls were not written down. The side sensors light up and go dark
/// one station earlier than in `follow_wall20`, at both ends and on both sides: the same
/// box, 50 mm nearer.
const BESIDE: &str = "stations every 50 mm; the wall's distance as recorded, its ends (40 cm, \
                      20 cm ahead of the first station) from where the readings begin and end";

const fn followed(name: &'static str, gap_m: f64) -> Setting {
    Setting {
        name,
        gap_m,
        sides: &[Side::Left],
        near_m: 0.40,
        has_cylinder: true,
        about: FOLLOWED,
    }
}

const fn beside(name: &'static str, gap_m: f64, sides: &'static [Side]) -> Setting {
    Setting {
        name,
        gap_m,
        sides,
        near_m: 0.35,
        has_cylinder: false,
        about: BESIDE,
    }
}

const SETTINGS: [Setting; 6] = [
    followed("follow_wall20", 0.02),
    followed("follow_wall40", 0.04),
    followed("follow_wall60", 0.06),
    beside("Data_Gang_25", 0.025, &[Side::Left, Side::Right]),
    beside("Data_Right_10", 0.01, &[Side::Right]),
    beside("Data_Right_50", 0.05, &[Side::Right]),
];

/// A face of a wall that the robot drove along: from its near to its far end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) near: Vector,
    pub(super) far: Vector,
}

/// A station: where the robot stood and what its sensors read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    pub(super) pose: Pose,
    pub(super) samples: [Sample; SENSORS],
}

/// A stepped series with its world.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    /// Where the readings are from.
    pub(super) readings: &'static str,
    pub(super) stations: Vec<Station>,
    pub(super) faces: Vec<Face>,
    pub(super) shapes: Vec<Shape>,
}

impl Series {
    /// All series of a folder.
    pub(super) fn load_all(folder: &Path) -> Result<Vec<Self>, RecordedError> {
        let load = |setting: &Setting| Self::load(folder, setting);
        SETTINGS.iter().map(load).collect()
    }

    fn load(folder: &Path, setting: &Setting) -> Result<Self, RecordedError> {
        let recording = log::read(&folder.join(format!("{}.txt", setting.name)))?;
        let readings = recording.inputs.iter().filter_map(|input| match input {
            Input::Proximity { samples, .. } => Some(*samples),
            _ => None,
        });
        let series = Self::of(setting, readings)?;
        // A refused row would move all stations behind it.
        if series.stations.is_empty() || !recording.refusals.is_empty() {
            return Err(RecordedError::Incomplete {
                series: setting.name,
                rows: series.stations.len(),
                refused: recording.refusals.count(),
            });
        }
        Ok(series)
    }

    /// A series with the given readings, a station each.
    fn of(
        setting: &Setting,
        readings: impl Iterator<Item = [Sample; SENSORS]>,
    ) -> Result<Self, RecordedError> {
        let station = |(index, samples): (u16, _)| Station {
            pose: Pose::new(FIRST_STATION_M + STATION_M * f32::from(index), 0.0, 0.0),
            samples,
        };
        let sides = setting.sides.iter();
        Ok(Self {
            name: setting.name,
            about: setting.about,
            readings: "recorded",
            stations: (0..).zip(readings).map(station).collect(),
            faces: sides.map(|side| setting.face(*side)).collect(),
            shapes: setting.shapes()?,
        })
    }

    /// The first series with empty readings, for tests.
    #[cfg(test)]
    pub(super) fn blank() -> Self {
        let [first, ..] = &SETTINGS;
        let nothing = std::iter::repeat_n([Sample::Counts(0); SENSORS], 19);
        Self::of(first, nothing).unwrap()
    }

    /// A node's inputs: pose and readings of each station.
    pub(super) fn inputs(&self) -> Vec<Input> {
        (0_u64..)
            .zip(&self.stations)
            .flat_map(|(index, station)| {
                let stamp_us = index * STATION_US;
                let (pose, samples) = (station.pose, station.samples);
                [
                    Input::Odometry { stamp_us, pose },
                    Input::Proximity { stamp_us, samples },
                ]
            })
            .collect()
    }
}

impl Setting {
    fn face(&self, side: Side) -> Face {
        let distance = RIM_M + self.gap_m;
        let y = match side {
            Side::Left => distance,
            Side::Right => -distance,
        };
        Face {
            near: Vector::new(self.near_m, y),
            far: Vector::new(self.near_m + BOX_M.0, y),
        }
    }

    fn shapes(&self) -> Result<Vec<Shape>, RecordedError> {
        let mut text = format!(
            "name = \"{}\"\ncell_m = 0.01\nextent_m = [-1, -1, 2, 1]\n\
             speed_m_per_s = 0.08\nstart = [0, 0, 0]\n",
            self.name
        );
        for side in self.sides {
            let Face { near, far } = self.face(*side);
            let back = near.y + BOX_M.1.copysign(near.y);
            text += &format!(
                "[[box]]\nmin = [{}, {}]\nmax = [{}, {}]\n",
                near.x,
                near.y.min(back),
                far.x,
                near.y.max(back)
            );
        }
        if self.has_cylinder {
            // 82.5 cm ahead of the first station and 15 cm left of the robot's centre.
            text += "[[cylinder]]\ncenter = [0.975, 0.15]\nradius_m = 0.0335\n";
        }
        Ok(Scenario::parse(&text)?.shapes)
    }
}
