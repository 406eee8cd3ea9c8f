//! Walls beside a recorded drive, leg by leg, as each method maps them.

use amiro_ipf::filter::Profile;
use amiro_ipf::model::{Photometry, SensorMask};
use amiro_ipf::node::{Config, Input};
use serde::Serialize;

use super::{MappedPath, WallReport, WallSide};
use crate::drive::Record;
use crate::mapping::{Mapper, Method, Setup};
use crate::rig::Rig;
use crate::{RunError, pipeline};

/// Side of a map cell, metres.
const CELL_M: f64 = 0.010;

/// What a recorded drive is mapped with.
#[derive(Clone, Copy, Debug)]
pub struct WallRowSettings {
    /// The sensors that are used.
    pub sensors: SensorMask,
    /// The sensors' law for filters and inverse sensor models.
    pub photometry: Photometry,
    /// Particles for each sensor in use.
    pub particles_per_sensor: u16,
    /// Gain of the law of extended surfaces, counts m^2, for methods that fit signals.
    pub wall_alpha_counts_m2: f32,
}

/// One side of a nearly straight leg of a drive, in the map of one method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WallRow {
    /// The method's name.
    pub method: &'static str,
    /// Number of the leg, from 1.
    pub leg: usize,
    /// Whether the side is the left one.
    pub is_left: bool,
    /// The occupied cells of that side, and the straight line through most of them.
    #[serde(flatten)]
    pub side: WallSide,
}

impl WallRow {
    /// Maps a drive of an AMiRo and looks for a wall on both sides of each leg; sides
    /// without an occupied cell are left out.
    ///
    /// # Errors
    /// As [`pipeline::records`].
    pub fn of(
        inputs: &[Input],
        method: &Method,
        settings: &WallRowSettings,
    ) -> Result<Vec<Self>, RunError> {
        let mut config = Config {
            sensors: settings.sensors,
            photometry: settings.photometry,
            particles_per_sensor: settings.particles_per_sensor,
            ..Config::amiro(method.profile.unwrap_or(Profile::Paper))
        };
        if method.fits_signals {
            config.photometry.alpha_counts_m2 = settings.wall_alpha_counts_m2;
        }
        let mut mapper = method.mapper(&Setup::new(&Rig::from(&config), CELL_M));
        let (mut path, mut jumps) = (Vec::new(), Vec::new());
        pipeline::run(
            |take| pipeline::records(method, &config, inputs, take),
            &mut mapper,
            &mut |record, _| match record {
                Record::Pose {
                    world_from_body, ..
                } => path.push((world_from_body.position.x, world_from_body.position.y)),
                Record::OdometryReset { .. } => jumps.push(path.len()),
                Record::Scan(_) | Record::Outcomes(_) => {}
            },
        )?;
        jumps.retain(|jump| (1..path.len()).contains(jump));
        jumps.dedup();
        let map = mapper.map();
        let legs = WallReport::by_leg(&MappedPath {
            jumps: &jumps,
            ..MappedPath::new(&map, &path)
        });
        let rows = (1..).zip(&legs).flat_map(|(leg, walls)| {
            [(true, walls.left), (false, walls.right)].map(|(is_left, side)| Self {
                method: method.name,
                leg,
                is_left,
                side,
            })
        });
        Ok(rows.filter(|row| row.side.occupied > 0).collect())
    }
}
