//! The table of an experiment, and what it is to show.

use std::ops::Range;

use super::{ExperimentCheck, RangeWorld, RoomWalls, SonarEchoes};
use crate::drive::Record;
use crate::evaluation::cell_truth::{
    CellScores, ScoredCells, TrueCell, TrueCells, truth_of_shapes,
};
use crate::geometry::{Rectangle, Vector};
use crate::lattice::Lattice;
use crate::mapping::{Map, Mapper, Method, Setup};
use crate::report::{CellWindow, ContactSheet, Picture, RocCurve};
use crate::rig::{Rig, RigError};
use crate::world::TrueWorld;

/// Side of a cell, metres. Walls lie on borders of cells: those on both sides are wall.
const CELL_M: f64 = 0.10;

/// Every simulated room lies within, metres.
const EXTENT: Rectangle = Rectangle {
    min: Vector::new(-50.0, -50.0),
    max: Vector::new(50.0, 50.0),
};

/// A room with 25 rays per sonar and echoes within 25 degrees, of walls x1, y1, x2, y2.
pub(super) fn room(walls: &[[f64; 4]]) -> RangeWorld {
    let ends = |[x1, y1, x2, y2]: &[f64; 4]| [Vector::new(*x1, *y1), Vector::new(*x2, *y2)];
    RangeWorld {
        walls: RoomWalls::new(walls.iter().map(ends).collect()),
        echoes: SonarEchoes::ROOM,
    }
}

/// A rig that is part of the program.
pub(super) fn rig(name: &str) -> Result<Rig, RigError> {
    let text = match name {
        "pioneer2dx.toml" => include_str!("../../../rigs/pioneer2dx.toml"),
        "pioneer3at.toml" => include_str!("../../../rigs/pioneer3at.toml"),
        _ => include_str!("../../../rigs/pioneer2dx_laser.toml"),
    };
    Rig::parse(name, text)
}

/// What an experiment found, to be printed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExperimentReport {
    /// Title, head and rows of its table.
    pub lines: Vec<String>,
    /// What was to be shown.
    pub checks: Vec<ExperimentCheck>,
    /// Labels and maps of the first seed, the truth first; none for an experiment without
    /// maps.
    pub maps: Vec<(String, Map)>,
    /// Receiver operating characteristics of these maps, where the paper draws them.
    pub curves: Vec<RocCurve>,
}

impl ExperimentReport {
    /// All maps on one sheet; `None` without a map.
    #[must_use]
    pub fn sheet(&self) -> Option<Picture> {
        let known = self
            .maps
            .iter()
            .filter_map(|(_, map)| CellWindow::known(map));
        let window = known.reduce(CellWindow::joined)?;
        let mut sheet = ContactSheet::new(window, &[], &[]);
        for (label, map) in &self.maps {
            sheet.add(label.clone(), map);
        }
        Some(sheet.render())
    }
}

/// The map of a method over all poses of a drive.
pub(super) fn map_of(method: &Method, rig: &Rig, records: &[Record]) -> Map {
    let mut mapper = method.mapper(&Setup::new(rig, Lattice::new(CELL_M)));
    records.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    mapper.map()
}

/// The cells of a room in which a robot has driven.
pub(super) fn truth_of(world: &RangeWorld, records: &[Record]) -> TrueCells {
    let places = records.iter().filter_map(|it| Some(it.pose()?.position));
    let places: Vec<Vector> = places.collect();
    let walls = TrueWorld::Walls(world.walls.segments().to_vec());
    let lattice = Lattice::new(CELL_M);
    // There is a truth of walls.
    truth_of_shapes(&walls, lattice, &places, &EXTENT)
        .unwrap_or_else(|| TrueCells::new(lattice, TrueCell::Outside))
}

/// The part of a truth whose cells have their centres in a part of the room.
pub(super) fn part_of(truth: &TrueCells, is_wanted: impl Fn(Vector) -> bool) -> TrueCells {
    let mut part = TrueCells::new(truth.lattice(), TrueCell::Outside);
    for (cell, is) in truth.iter() {
        let (x, y) = truth.centre(cell);
        if let Some(held) = part.reach(cell).filter(|_| is_wanted(Vector::new(x, y))) {
            *held = *is;
        }
    }
    part
}

/// The cells that an echo of a drive looks at.
pub(super) fn scored_cells(rig: &Rig, records: &[Record]) -> ScoredCells {
    let mounts = vec![true; rig.mounts.len()];
    let mut scored = ScoredCells::new(Lattice::new(CELL_M), rig, mounts);
    records.iter().for_each(|record| scored.take(record));
    scored
}

/// Scores of a method, a mean over seeds; NaN where a score does not exist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeanScores {
    pub(super) oe: f64,
    pub(super) tpr: f64,
    pub(super) fpr: f64,
    coverage: f64,
}

impl MeanScores {
    fn of(row: &[CellScores]) -> Self {
        let mean = |value: fn(&CellScores) -> Option<f64>| {
            let values = row.iter().map(|it| value(it).unwrap_or(f64::NAN));
            values.sum::<f64>() / row.len() as f64
        };
        Self {
            oe: mean(|it| it.oe),
            tpr: mean(|it| it.tpr),
            fpr: mean(|it| it.fpr),
            coverage: mean(|it| it.coverage),
        }
    }
}

/// Scores of several methods, each over seeds.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MethodScores {
    rows: Vec<(&'static str, Vec<CellScores>)>,
}

impl MethodScores {
    /// No scores yet, of methods of these names.
    pub(super) fn new(names: &[&'static str]) -> Self {
        Self {
            rows: names.iter().map(|name| (*name, Vec::new())).collect(),
        }
    }

    /// Adds the scores of a method of one seed.
    pub(super) fn add(&mut self, name: &str, scores: CellScores) {
        if let Some((_, row)) = self.rows.iter_mut().find(|(known, _)| *known == name) {
            row.push(scores);
        }
    }

    /// The mean of a method; NaN without any.
    pub(super) fn of(&self, name: &str) -> MeanScores {
        let row = self.rows.iter().find(|(known, _)| *known == name);
        MeanScores::of(row.map_or(&[], |(_, row)| row.as_slice()))
    }

    /// Title, head and rows.
    pub(super) fn lines(&self, title: &str, seeds: &Range<u64>) -> Vec<String> {
        let mut lines = vec![
            format!("{title}; seeds {}..{}", seeds.start, seeds.end),
            "method                OE    +-      TPR    FPR    coverage".to_owned(),
        ];
        for (name, row) in &self.rows {
            let mean = MeanScores::of(row);
            lines.push(format!(
                "{name:<18}  {:.3}  {:.3}  {:.3}  {:.3}  {:.3}",
                mean.oe,
                standard_error(row),
                mean.tpr,
                mean.fpr,
                mean.coverage,
            ));
        }
        lines
    }
}

/// Standard error of the mean OE.
fn standard_error(row: &[CellScores]) -> f64 {
    let (count, mean) = (row.len() as f64, MeanScores::of(row).oe);
    let squares = row
        .iter()
        .filter_map(|it| Some((it.oe? - mean) * (it.oe? - mean)));
    (squares.sum::<f64>() / (count * (count - 1.0).max(1.0))).sqrt()
}
