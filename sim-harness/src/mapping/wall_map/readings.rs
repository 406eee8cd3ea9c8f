//! The readings of a drive, by the places at which they were taken.

use std::collections::BTreeMap;
use std::ops::Range;

use super::WallMapParameters;
use crate::drive::RangeScan;
use crate::geometry::{Pose2, Vector};
use crate::rig::Rig;
use crate::sensors::{Sensor, WallLaw, WallSegment};

/// Most places of a drive that are kept: 200 m at 10 mm.
const MAX_STATIONS: usize = 20_000;

/// Most places that are kept in a square of 20 mm and an eighth of a turn.
const MAX_REPEATS: u8 = 8;
const REPEAT_M: f64 = 0.02;

/// Side of the squares by which places are found, metres.
const BIN_M: f64 = 0.25;

/// Farthest place, metres.
const FARTHEST_M: f64 = 1e6;

/// Least signal above the dark value that a reading counts with, as a share of the floor:
/// its logarithm would be undefined at -1.
const LEAST_SHARE: f64 = -0.7;

/// Signal from which on a reading is a reason to look for walls, standard deviations.
const LIT: f64 = 3.0;

/// Share of the readings with the lowest signal of all from which on a recorder is taken
/// to have clipped them. Of unclipped ones few have the very same count.
const CLIPPED_SHARE: f64 = 0.05;

/// One reading of one sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct SignalRow {
    /// The sensor's pose; its x is the axis.
    pub(super) world_from_sensor: Pose2,
    /// Index of the mount.
    pub(super) mount: usize,
    /// Counts above the dark value.
    pub(super) signal: f64,
    /// ln of the signal with the floor.
    level: f64,
    /// Standard deviation of the level.
    sigma: f64,
    sigma_counts: f64,
    /// Whether the signal is only known to be no more than this.
    is_bound: bool,
}

/// An infrared sensor of a rig.
#[derive(Clone, Copy, Debug)]
struct InfraredMount {
    body_from_sensor: Pose2,
    law: WallLaw,
    /// Cosine of the half width of its lobe.
    edge_cosine: f64,
    /// Standard deviation of a sample, counts (sig).
    sigma_counts: f64,
}

/// A place at which the sensors were read.
#[derive(Clone, Debug)]
pub(super) struct ScanPlace {
    pub(super) world_from_body: Pose2,
    pub(super) rows: Range<usize>,
}

/// All readings of a drive.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    parameters: WallMapParameters,
    /// The mounts; `None` for one without a law of walls.
    mounts: Vec<Option<InfraredMount>>,
    pub(super) rows: Vec<SignalRow>,
    pub(super) stations: Vec<ScanPlace>,
    bins: BTreeMap<(i64, i64), Vec<usize>>,
    repeats: BTreeMap<(i64, i64, i64), u8>,
    left_out: u64,
}

impl SignalRow {
    /// A reading at the world's origin.
    fn new(parameters: &WallMapParameters, mount: usize, sigma_counts: f64, signal: f64) -> Self {
        let floor = parameters.floor_counts;
        let counts = signal.max(LEAST_SHARE * floor) + floor;
        let (noise, relative) = (sigma_counts / counts, parameters.relative_sigma);
        Self {
            world_from_sensor: Pose2::new(0.0, 0.0, 0.0),
            mount,
            signal,
            level: libm::log(counts),
            sigma: (noise * noise + relative * relative).sqrt(),
            sigma_counts,
            is_bound: false,
        }
    }

    /// Whether the signal stands out of the noise.
    pub(super) fn is_lit(&self) -> bool {
        !self.is_bound && self.signal > LIT * self.sigma_counts
    }

    /// What is missing in an expected signal, standard deviations.
    pub(super) fn residual(&self, expected: f64, floor_counts: f64) -> f64 {
        if self.is_bound && expected <= self.signal {
            return 0.0;
        }
        (self.level - libm::log(expected + floor_counts)) / self.sigma
    }

    /// Derivative of the residual by the expected signal, 1/counts.
    pub(super) fn residual_by_signal(&self, expected: f64, floor_counts: f64) -> f64 {
        if self.is_bound && expected <= self.signal {
            return 0.0;
        }
        -1.0 / (self.sigma * (expected + floor_counts))
    }
}

impl Readings {
    pub(super) fn new(rig: &Rig, parameters: WallMapParameters) -> Self {
        let mount = |mount: &crate::rig::SensorMount| match &mount.sensor {
            Sensor::Infrared(sensor) => {
                let law = WallLaw::new(sensor.photometry());
                Some(InfraredMount {
                    body_from_sensor: mount.body_from_sensor,
                    law,
                    edge_cosine: libm::cos(law.edge_rad()),
                    sigma_counts: f64::from(sensor.photometry().sigma_counts),
                })
            }
            Sensor::Cone(_) | Sensor::Scanner(_) => None,
        };
        Self {
            parameters,
            mounts: rig.mounts.iter().map(mount).collect(),
            rows: Vec::new(),
            stations: Vec::new(),
            bins: BTreeMap::new(),
            repeats: BTreeMap::new(),
            left_out: 0,
        }
    }

    /// The same readings with the weights of other parameters.
    pub(super) fn reweighted(&self, parameters: &WallMapParameters) -> Self {
        let row = |row: &SignalRow| SignalRow {
            world_from_sensor: row.world_from_sensor,
            is_bound: row.is_bound,
            ..SignalRow::new(parameters, row.mount, row.sigma_counts, row.signal)
        };
        Self {
            parameters: *parameters,
            rows: self.rows.iter().map(row).collect(),
            ..self.clone()
        }
    }

    /// Marks the readings that a recorder has clipped: those of the lowest signal, if they
    /// are many. They are then upper bounds.
    pub(super) fn mark_clipped(&mut self) {
        let signals = self.rows.iter().map(|row| row.signal);
        let lowest = signals.fold(f64::INFINITY, f64::min);
        let is_lowest = |row: &SignalRow| row.signal <= lowest;
        let count = self.rows.iter().filter(|row| is_lowest(row)).count();
        let is_clipped = count as f64 >= CLIPPED_SHARE * self.rows.len() as f64;
        for row in &mut self.rows {
            row.is_bound = is_clipped && is_lowest(row);
        }
    }

    /// Number of mounts.
    pub(super) fn mounts(&self) -> usize {
        self.mounts.len()
    }

    /// The law of a mount.
    pub(super) fn law(&self, mount: usize) -> Option<&WallLaw> {
        Some(&self.mounts.get(mount)?.as_ref()?.law)
    }

    /// Cosine of the half width of a mount's lobe.
    pub(super) fn edge_cosine(&self, mount: usize) -> f64 {
        let mount = self.mounts.get(mount).and_then(Option::as_ref);
        mount.map_or(1.0, |mount| mount.edge_cosine)
    }

    /// Number of scans that were left out.
    pub(super) fn left_out(&self) -> u64 {
        self.left_out
    }

    /// Takes the signals of a scan; whether there were any to be kept.
    pub(super) fn take(&mut self, scan: &RangeScan) -> bool {
        let position = scan.world_from_body.position;
        let is_placed =
            scan.world_from_body.is_finite() && position.x.abs().max(position.y.abs()) < FARTHEST_M;
        if scan.signals.is_empty() || !is_placed {
            return false;
        }
        if !self.is_new(&scan.world_from_body) {
            self.left_out += 1;
            return false;
        }
        let first = self.rows.len();
        for (mount, signal) in scan.mounts.clone().zip(&scan.signals) {
            let sensor = self.mounts.get(mount).copied().flatten();
            if let (Some(sensor), Some(signal)) = (sensor, *signal)
                && signal.is_finite()
            {
                let world_from_sensor = scan.world_from_body * sensor.body_from_sensor;
                let sigma_counts = sensor.sigma_counts;
                let row = SignalRow::new(&self.parameters, mount, sigma_counts, signal);
                self.rows.push(SignalRow {
                    world_from_sensor,
                    ..row
                });
            }
        }
        let bin = bin_of(position);
        self.bins.entry(bin).or_default().push(self.stations.len());
        self.stations.push(ScanPlace {
            world_from_body: scan.world_from_body,
            rows: first..self.rows.len(),
        });
        true
    }

    /// Whether a place may be kept: the bounds on their number.
    fn is_new(&mut self, pose: &Pose2) -> bool {
        let place = |metres: f64| (metres / REPEAT_M).floor() as i64;
        let eighth = (pose.heading_rad() * 4.0 / core::f64::consts::PI).round() as i64;
        let key = (
            place(pose.position.x),
            place(pose.position.y),
            eighth.rem_euclid(8),
        );
        let repeats = self.repeats.entry(key).or_default();
        let is_new = *repeats < MAX_REPEATS && self.stations.len() < MAX_STATIONS;
        *repeats += u8::from(is_new);
        is_new
    }

    /// The places within a distance of a wall, in the order of the drive.
    pub(super) fn near(&self, wall: &WallSegment, distance_m: f64) -> Vec<usize> {
        let WallSegment { from, to } = *wall;
        let low = Vector::new(from.x.min(to.x) - distance_m, from.y.min(to.y) - distance_m);
        let high = Vector::new(from.x.max(to.x) + distance_m, from.y.max(to.y) + distance_m);
        let ((first_x, first_y), (last_x, last_y)) = (bin_of(low), bin_of(high));
        let mut near = Vec::new();
        for x in first_x..=last_x {
            for (_, stations) in self.bins.range((x, first_y)..=(x, last_y)) {
                near.extend(stations.iter().copied().filter(|station| {
                    self.stations.get(*station).is_some_and(|station| {
                        let place = station.world_from_body.position;
                        place.distance_from_segment(from, to) <= distance_m
                    })
                }));
            }
        }
        near.sort_unstable();
        near
    }

    /// The readings of a station.
    pub(super) fn rows_of(&self, station: usize) -> &[SignalRow] {
        let rows = self
            .stations
            .get(station)
            .and_then(|station| self.rows.get(station.rows.clone()));
        rows.unwrap_or_default()
    }
}

fn bin_of(place: Vector) -> (i64, i64) {
    let bin = |metres: f64| (metres / BIN_M).floor() as i64;
    (bin(place.x), bin(place.y))
}
