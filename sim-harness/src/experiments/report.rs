//! The table of an experiment, and what it is to show.

use std::ops::Range;

use super::{CellScores, CellTruth, ExperimentCheck, RangeWorld, RoomWalls, SonarEchoes};
use crate::drive::Record;
use crate::geometry::Vector;
use crate::lattice::Lattice;
use crate::mapping::{Map, Mapper, Method, Setup};
use crate::rig::{Rig, RigError};

/// Side of a cell, metres.
pub(super) const CELL_M: f64 = 0.10;

/// Half the diagonal of a cell: a cell that a wall touches is wall.
pub(super) const WALL_M: f64 = 0.071;

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
}

/// The map of a method over all poses of a drive.
pub(super) fn map_of(method: &Method, rig: &Rig, records: &[Record]) -> Map {
    let mut mapper = method.mapper(&Setup::new(rig, Lattice::new(CELL_M)));
    records.iter().for_each(|record| mapper.take(record));
    mapper.finish(&mut |_| {});
    mapper.map()
}

/// The truth of a drive through a room, scored where an echo looks.
pub(super) fn truth_of(world: &RangeWorld, rig: &Rig, records: &[Record]) -> CellTruth {
    let places = records.iter().filter_map(|it| Some(it.pose()?.position));
    let mut truth = CellTruth::new(Lattice::new(CELL_M), &world.walls, WALL_M, places);
    for record in records {
        if let Record::Scan(scan) = record {
            truth.look(rig, scan);
        }
    }
    truth
}

/// Scores of several methods, each a mean over seeds.
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
    pub(super) fn of(&self, name: &str) -> CellScores {
        let row = self.rows.iter().find(|(known, _)| *known == name);
        CellScores::mean(row.map_or(&[], |(_, row)| row.as_slice()))
    }

    /// Standard error of a method's error.
    fn standard_error(row: &[CellScores]) -> f64 {
        let (count, mean) = (row.len() as f64, CellScores::mean(row).error);
        let squares = row.iter().map(|it| (it.error - mean) * (it.error - mean));
        (squares.sum::<f64>() / (count * (count - 1.0).max(1.0))).sqrt()
    }

    /// Title, head and rows.
    pub(super) fn lines(&self, title: &str, seeds: &Range<u64>) -> Vec<String> {
        let mut lines = vec![
            format!("{title}; seeds {}..{}", seeds.start, seeds.end),
            "method              error   +-      TPR     FPR  coverage".to_owned(),
        ];
        for (name, row) in &self.rows {
            let mean = CellScores::mean(row);
            lines.push(format!(
                "{name:<18}  {:.3}  {:.3}  {:.3}  {:.3}     {:.3}",
                mean.error,
                Self::standard_error(row),
                mean.true_positives,
                mean.false_positives,
                mean.coverage,
            ));
        }
        lines
    }
}
