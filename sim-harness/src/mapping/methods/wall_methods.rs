//! Walls fitted to the signals of infrared sensors, as mapping methods.

use amiro_ipf::filter::SegmentParameters;

use super::{Method, SensorChoice};
use crate::mapping::{SegmentMapper, WallMapParameters, WallMapper};
use crate::sensors::SensorKind;

const SEGMENTS: &str = "this project: wall segments fitted to the law of walls";
const WALLS: &str = "this project: walls with ends under Lambert's law, mapping/wall_map";

const INFRARED: SensorChoice = SensorChoice::Each(&[SensorKind::Infrared]);

impl Method {
    /// Straight walls fitted to all signals of a drive at once.
    pub const WALL_MAP: Self = Self {
        fits_signals: true,
        ..Self::new("wall-map", WALLS, INFRARED, |s| {
            let parameters = WallMapParameters::STANDARD;
            Box::new(WallMapper::new(s.lattice, s.rig, parameters))
        })
    };
    /// Wall segments tracked over all readings of the last steps.
    pub const SEGMENTS: Self = Self {
        fits_signals: true,
        ..Self::new("segments", SEGMENTS, INFRARED, |s| {
            // Three stations of 50 mm, not the filter's four: 2.0 false cells per recorded
            // series, not 4.5. Drives with steps of 10 mm give the same map.
            let parameters = SegmentParameters {
                window_m: 0.125,
                ..SegmentParameters::STEPS
            };
            Box::new(SegmentMapper::new(
                s,
                parameters,
                WallMapParameters::STANDARD,
            ))
        })
    };
}
