//! What the maps of a recorded drive are scored with.

use super::from_shapes::places_in;
use super::{CellScores, ScannerTruth, ScoredCells, TrueCells, truth_of_shapes};
use crate::drive::Record;
use crate::geometry::{Rectangle, Vector};
use crate::lattice::Lattice;
use crate::mapping::Map;
use crate::rig::{Rig, SensorMount};
use crate::sensors::SensorKind;
use crate::world::TrueWorld;

/// Least scans for a class of a cell: of all keyframes, and of every second one.
const LEAST_SCANS: u16 = 3;
const LEAST_SCANS_OF_HALF: u16 = 2;

/// How far from the robot's places known walls bound the free cells, metres.
const ROOM_M: f64 = 20.0;

/// Reads the keyframes of a drive once, for the truth and the cells that are scored.
#[derive(Debug)]
pub struct DriveSurvey<'a> {
    world: &'a TrueWorld,
    lattice: Lattice,
    scored: ScoredCells,
    of_all: ScannerTruth,
    of_odd: ScannerTruth,
    /// Of the robot, one per keyframe.
    places: Vec<Vector>,
}

/// Truth and scored cells of a drive.
#[derive(Debug)]
pub struct DriveTruth {
    /// The truth about the cells.
    pub cells: TrueCells,
    /// The truth from the odd keyframes, where a scanner of the recording makes it.
    pub of_odd_keyframes: Option<TrueCells>,
    /// The cells that are scored.
    pub scored: ScoredCells,
    /// Keyframes, and how many of them lie in a free cell of known surroundings.
    pub places: [usize; 2],
}

impl<'a> DriveSurvey<'a> {
    /// Nothing read yet. The scored cells are those of all sensors but the scanners that make
    /// the truth.
    #[must_use]
    pub fn new(world: &'a TrueWorld, rig: &Rig, lattice: Lattice) -> Self {
        let makes_truth = matches!(world, TrueWorld::Scanner);
        let is_scored =
            |mount: &SensorMount| !(makes_truth && mount.sensor.kind() == SensorKind::Scanner);
        let mounts = rig.mounts.iter().map(is_scored).collect();
        Self {
            world,
            lattice,
            scored: ScoredCells::new(lattice, rig, mounts),
            of_all: ScannerTruth::new(lattice, rig, LEAST_SCANS),
            of_odd: ScannerTruth::new(lattice, rig, LEAST_SCANS_OF_HALF),
            places: Vec::new(),
        }
    }

    /// Takes the next record of the keyframes.
    pub fn take(&mut self, record: &Record) {
        if let Some(pose) = record.pose() {
            self.places.push(pose.position);
        }
        self.scored.take(record);
        if matches!(self.world, TrueWorld::Scanner) {
            self.of_all.take(record);
            // The keyframes count from 0: behind the second one, this is 1.
            if self.places.len().is_multiple_of(2) {
                self.of_odd.take(record);
            }
        }
    }

    /// The truth about the drive.
    #[must_use]
    pub fn finish(self) -> DriveTruth {
        let shapes = truth_of_shapes(self.world, self.lattice, &self.places, &self.extent());
        let makes_truth = shapes.is_none();
        let all = self.places.len();
        let inside = |cells: &TrueCells| places_in(cells, &self.places);
        let inside = shapes.as_ref().map_or(all, inside);
        DriveTruth {
            cells: shapes.unwrap_or_else(|| self.of_all.cells()),
            of_odd_keyframes: makes_truth.then(|| self.of_odd.cells()),
            scored: self.scored,
            places: [all, inside],
        }
    }

    fn extent(&self) -> Rectangle {
        if let TrueWorld::Scenario(scenario) = self.world {
            return scenario.extent;
        }
        let corner = |pick: fn(f64, f64) -> f64, start: f64, margin_m: f64| {
            let of = |along: fn(&Vector) -> f64| {
                self.places.iter().map(along).fold(start, pick) + margin_m
            };
            Vector::new(of(|it| it.x), of(|it| it.y))
        };
        Rectangle {
            min: corner(f64::min, f64::INFINITY, -ROOM_M),
            max: corner(f64::max, f64::NEG_INFINITY, ROOM_M),
        }
    }
}

impl DriveTruth {
    /// The scores of a map of all keyframes.
    #[must_use]
    pub fn scores(&self, map: &Map) -> CellScores {
        CellScores::of(map, &self.cells, &self.scored)
    }

    /// The scores of the map that is free everywhere.
    #[must_use]
    pub fn all_free(&self) -> CellScores {
        CellScores::of_all_free(&self.cells, &self.scored)
    }
}
