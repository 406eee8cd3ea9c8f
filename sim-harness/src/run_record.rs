//! The record of a run: its map, path and statistics.

use amiro_ipf::filter::SegmentParameters;
use amiro_ipf::node::odometry::{MAX_AGE_US, MAX_SPEED_M_PER_S};
use amiro_ipf::node::{Config, Event, StepDone};
use serde::Serialize;

use crate::drive::{FilterRecords, KnownWalls, Record};
use crate::geometry::Pose2;
use crate::mapping::{CountingMapper, FootprintMapper, Map, Mapper, Occupancy};

/// Collects the events of a run, on a host's node or on a board.
#[derive(Clone, Debug)]
pub struct RunRecord {
    records: FilterRecords,
    mapper: FootprintMapper<CountingMapper>,
    walls: KnownWalls,
    /// Index and stamp of the last step that began.
    begun: Option<(u32, u64)>,
    poses: Vec<Pose2>,
    /// The poses to which the robot did not drive from the pose before, by index.
    jumps: Vec<usize>,
    last: Option<(u64, Pose2)>,
    /// Whether the odometry was reset since the last step.
    is_reset: bool,
    statistics: RunStatistics,
}

/// The statistics of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RunStatistics {
    /// Steps of the filter.
    pub steps: u64,
    /// Outcomes that counted as occupied.
    pub survived_past_gate: u64,
    /// Survivors below the gate, which count nothing.
    pub survived_below_gate: u64,
    /// Outcomes that counted as free.
    pub rejected_free: u64,
    /// Rejected outcomes that count nothing.
    #[serde(rename = "rejected_behind")]
    pub rejected_unobserved: u64,
    /// Particles that left the local radius.
    pub departed: u64,
    /// Steps in which no particle had any weight.
    pub degenerate_steps: u64,
    /// Digest of the particle set after the last step.
    pub last_digest: Option<u32>,
    /// Mean distance between the poses of consecutive steps, metres, without jumps.
    pub mean_step_m: Option<f64>,
    /// Length of the path through the steps' poses, metres, without jumps.
    pub path_m: f64,
    /// Jumps of the path: steps before which the odometry was reset, or that are farther
    /// from the step before than the robot can have driven.
    pub jumps: u64,
    /// Occupied cells of the map.
    pub cells_occupied: u64,
    /// Free cells of the map.
    pub cells_free: u64,
    /// Updates of cells that were refused because the map would exceed its limit; above
    /// zero, the map is cut.
    pub cells_refused: u64,
    /// Radius of the robot's hull, whose footprint is free in the map, metres; `None`
    /// if the map has no footprint.
    pub footprint_radius_m: Option<f64>,
}

impl RunRecord {
    /// An empty record of a robot with a configuration, with map cells of the given size,
    /// metres; with a radius, metres, the footprint of that hull is free in the map.
    #[must_use]
    pub fn new(config: &Config, cell_m: f64, hull_radius_m: Option<f64>) -> Self {
        let mapper = CountingMapper::new(cell_m);
        Self {
            records: FilterRecords::new(config),
            mapper: FootprintMapper::new(mapper, cell_m, hull_radius_m),
            walls: KnownWalls::new(f64::from(SegmentParameters::STEPS.drop_evidence)),
            begun: None,
            poses: Vec::new(),
            jumps: Vec::new(),
            last: None,
            is_reset: false,
            statistics: RunStatistics::default(),
        }
    }

    /// Takes the next event.
    pub fn take(&mut self, event: &Event) {
        match event {
            Event::StepBegun(step) => self.begun = Some((step.index, step.stamp_us)),
            Event::Walls(walls) => {
                let begun = self.begun.filter(|(index, _)| *index == walls.index);
                self.walls.take(walls, begun.map(|(_, stamp_us)| stamp_us));
            }
            Event::OdometryReset { .. } => self.walls.reset(),
            Event::StepDone(done) => self.statistics.add(done),
            Event::Configured(_) | Event::Particles(_) => {}
        }
        let Self {
            records,
            mapper,
            poses,
            jumps,
            last,
            is_reset,
            ..
        } = self;
        records.translate(event, &mut |record| {
            mapper.take(record);
            match record {
                Record::Pose {
                    stamp_us,
                    world_from_body,
                } => {
                    let to = (*stamp_us, *world_from_body);
                    let is_jump = |from: &_| *is_reset || !is_drivable(from, &to);
                    if last.as_ref().is_some_and(is_jump) {
                        jumps.push(poses.len());
                    }
                    poses.push(*world_from_body);
                    *last = Some(to);
                    *is_reset = false;
                }
                Record::OdometryReset { .. } => *is_reset = true,
                Record::Scan(_) | Record::Outcomes(_) => {}
            }
        });
    }

    /// The robot's pose at each step.
    #[must_use]
    pub fn poses(&self) -> &[Pose2] {
        &self.poses
    }

    /// The path through the steps' poses, metres.
    #[must_use]
    pub fn path(&self) -> Vec<(f64, f64)> {
        self.poses
            .iter()
            .map(|pose| (pose.position.x, pose.position.y))
            .collect()
    }

    /// The poses to which the robot did not drive from the pose before, by index in
    /// [`poses`](Self::poses) and [`path`](Self::path), in order.
    #[must_use]
    pub fn jumps(&self) -> &[usize] {
        &self.jumps
    }

    /// The wall segments of the run's messages.
    #[must_use]
    pub fn known_walls(&self) -> &KnownWalls {
        &self.walls
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> Map {
        self.mapper.map()
    }

    /// The map so far without the robot's footprint: the particles' outcomes only.
    #[must_use]
    pub fn counted_map(&self) -> Map {
        self.mapper.counted().map()
    }

    /// The statistics so far.
    #[must_use]
    pub fn statistics(&self) -> RunStatistics {
        let path = self.path();
        let pairs = (1..).zip(path.iter().zip(path.iter().skip(1)));
        let driven = pairs.filter(|(index, _)| self.jumps.binary_search(index).is_err());
        let lengths = driven
            .map(|(_, (from, to))| ((to.0 - from.0).powi(2) + (to.1 - from.1).powi(2)).sqrt());
        // Not `sum`, which is -0 over nothing.
        let path_m = lengths.fold(0.0, |sum, length_m| sum + length_m);
        let gaps = path.len().saturating_sub(1 + self.jumps.len());
        let map = self.map();
        let count = |wanted| map.count(wanted) as u64;
        RunStatistics {
            path_m,
            jumps: self.jumps.len() as u64,
            mean_step_m: (gaps > 0).then(|| path_m / gaps as f64),
            cells_occupied: count(Occupancy::Occupied),
            cells_free: count(Occupancy::Free),
            cells_refused: map.refused(),
            footprint_radius_m: self.mapper.hull_radius_m(),
            ..self.statistics
        }
    }
}

/// Whether a robot can have driven from one step to the next in the time between.
///
/// Each pose may be predicted over the age that an odometry pose may have at most, so that
/// each may be off by the distance driven in that time.
fn is_drivable((from_us, from): &(u64, Pose2), (to_us, to): &(u64, Pose2)) -> bool {
    let between_us = to_us.saturating_sub(*from_us);
    let seconds = 1e-6 * between_us.saturating_add(2 * MAX_AGE_US) as f64;
    let way = to.position - from.position;
    way.norm() <= f64::from(MAX_SPEED_M_PER_S) * seconds
}

impl RunStatistics {
    fn add(&mut self, done: &StepDone) {
        self.steps += 1;
        self.survived_past_gate += u64::from(done.past_gate);
        self.survived_below_gate += u64::from(done.below_gate);
        self.rejected_free += u64::from(done.free);
        self.rejected_unobserved += u64::from(done.unobserved);
        self.departed += u64::from(done.departed);
        self.degenerate_steps += u64::from(done.degenerate);
        self.last_digest = Some(done.digest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::filter::{Outcome, Profile};
    use amiro_ipf::geometry::Pose;
    use amiro_ipf::model::{SENSORS, Sample};
    use amiro_ipf::node::{ParticleEvent, Particles, StepBegun};

    fn step(index: u32, x: f32, y: f32) -> Event {
        Event::StepBegun(StepBegun {
            index,
            stamp_us: 125_000 * u64::from(index),
            pose: Pose::new(x, y, 0.0),
            samples: [Sample::Missing; SENSORS],
        })
    }

    fn found(index: u32) -> Event {
        let mut particles = Particles {
            step: index as u8,
            ..Particles::default()
        };
        let event = ParticleEvent::new((6400, 0), Outcome::SurvivedPastGate);
        particles.outcomes.push(event).unwrap();
        Event::Particles(particles)
    }

    fn statistics(events: &[Event]) -> RunStatistics {
        let mut record = RunRecord::new(&Config::amiro(Profile::Plus), 0.01, None);
        events.iter().for_each(|event| record.take(event));
        record.statistics()
    }

    #[test]
    fn a_jump_of_the_odometry_is_not_part_of_the_path() {
        let was_reset = Event::OdometryReset { stamp_us: 0 };
        let statistics = statistics(&[
            step(0, 0.0, 0.0),
            step(1, 0.01, 0.0),
            was_reset,
            step(2, 85.0, 85.0),
            step(3, 85.01, 85.0),
        ]);
        assert!((statistics.path_m - 0.02).abs() < 1e-5, "{statistics:?}");
        assert!((statistics.mean_step_m.unwrap() - 0.01).abs() < 1e-5);
        assert_eq!(statistics.jumps, 1);
    }

    #[test]
    fn a_step_longer_than_a_robot_drives_is_a_jump_though_its_break_was_lost() {
        let jump = statistics(&[step(0, 0.0, 0.0), step(1, 0.6, 0.0)]);
        assert_eq!((jump.jumps, jump.mean_step_m), (1, None));
        assert!(jump.path_m.abs() < 1e-12 && jump.path_m.is_sign_positive());
        // 1 m/s for 125 ms, and two poses that are predicted over 200 ms.
        let fast = statistics(&[step(0, 0.0, 0.0), step(1, 0.5, 0.0)]);
        assert_eq!(fast.jumps, 0);
        assert_eq!(statistics(&[]).path_m.to_string(), "0");
    }

    #[test]
    fn a_map_that_is_cut_counts_the_cells_that_it_refused() {
        let near = [step(0, 0.0, 0.0), found(0)];
        assert_eq!(statistics(&near).cells_refused, 0);
        let far = [step(1, 85.0, 85.0), found(1), step(2, 4e30, 0.0), found(2)];
        let statistics = statistics(&[&near[..], &far].concat());
        assert_eq!(
            (statistics.cells_refused, statistics.cells_occupied),
            (2, 1)
        );
    }
}
