//! What a run's events add up to: the map, the path, the counts.

use amiro_ipf::event::{Event, StepDone};
use amiro_ipf::geometry::Pose;
use serde::Serialize;

use crate::mapping::{CountingMapper, FootprintMapper, Map, Mapper, Occupancy};

/// Collects a run's events, from a host's node or from a board alike.
#[derive(Clone, Debug)]
pub struct Survey {
    mapper: FootprintMapper<CountingMapper>,
    poses: Vec<Pose>,
    figures: Figures,
}

/// A run in figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Steps of the filter.
    pub steps: u64,
    /// Outcomes that counted as occupied.
    pub survived_past_gate: u64,
    /// Survivors below the gate, which count nothing.
    pub survived_below_gate: u64,
    /// Outcomes that counted as free.
    pub rejected_free: u64,
    /// Rejected outcomes that count nothing.
    pub rejected_behind: u64,
    /// Particles that left the local radius.
    pub departed: u64,
    /// Steps in which no particle had any weight.
    pub degenerate_steps: u64,
    /// Digest of the particle set after the last step.
    pub last_digest: Option<u32>,
    /// Mean distance between the poses of consecutive steps, metres.
    pub mean_step_m: Option<f64>,
    /// Length of the path through the steps' poses, metres.
    pub path_m: f64,
    /// Occupied cells of the map.
    pub cells_occupied: u64,
    /// Free cells of the map.
    pub cells_free: u64,
    /// Radius of the robot's hull, whose footprint is free in the map, metres; `None`
    /// if the map has no footprint.
    pub footprint_radius_m: Option<f64>,
}

impl Survey {
    /// An empty survey with map cells of the given size, metres.
    #[must_use]
    pub fn new(cell_m: f64) -> Self {
        Self::with_footprint(cell_m, None)
    }

    /// An empty survey in whose map the footprint of a hull of the given radius, metres,
    /// is free; without a radius as [`new`](Self::new).
    #[must_use]
    pub fn with_footprint(cell_m: f64, hull_radius_m: Option<f64>) -> Self {
        let mapper = CountingMapper::new(cell_m);
        Self {
            mapper: FootprintMapper::new(mapper, cell_m, hull_radius_m),
            poses: Vec::new(),
            figures: Figures::default(),
        }
    }

    /// Takes the next event.
    pub fn take(&mut self, event: &Event) {
        self.mapper.take(event);
        match event {
            Event::StepBegun(step) => self.poses.push(step.pose),
            Event::StepDone(done) => self.figures.add(done),
            _ => {}
        }
    }

    /// The robot's pose at each step.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// The path through the steps' poses, metres.
    #[must_use]
    pub fn path(&self) -> Vec<(f64, f64)> {
        self.poses
            .iter()
            .map(|pose| (f64::from(pose.position.x), f64::from(pose.position.y)))
            .collect()
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> Map {
        self.mapper.map()
    }

    /// The figures so far.
    #[must_use]
    pub fn figures(&self) -> Figures {
        let path = self.path();
        let lengths = path
            .iter()
            .zip(path.iter().skip(1))
            .map(|(from, to)| ((to.0 - from.0).powi(2) + (to.1 - from.1).powi(2)).sqrt());
        let path_m: f64 = lengths.sum();
        let gaps = path.len().saturating_sub(1);
        let map = self.map();
        let count = |wanted: Occupancy| {
            let cells = map.iter().filter(|(_, p)| Occupancy::of(**p) == wanted);
            cells.count() as u64
        };
        Figures {
            path_m,
            mean_step_m: (gaps > 0).then(|| path_m / gaps as f64),
            cells_occupied: count(Occupancy::Occupied),
            cells_free: count(Occupancy::Free),
            footprint_radius_m: self.mapper.hull_radius_m(),
            ..self.figures
        }
    }
}

impl Figures {
    fn add(&mut self, done: &StepDone) {
        self.steps += 1;
        self.survived_past_gate += u64::from(done.past_gate);
        self.survived_below_gate += u64::from(done.below_gate);
        self.rejected_free += u64::from(done.free);
        self.rejected_behind += u64::from(done.behind);
        self.departed += u64::from(done.departed);
        self.degenerate_steps += u64::from(done.degenerate);
        self.last_digest = Some(done.digest);
    }
}
