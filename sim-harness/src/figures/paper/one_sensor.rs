//! One sensor that looks straight ahead, at the origin of the figures.

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{Photometry, Ring, SENSORS, Sample, SensorMask};
use amiro_ipf::node::{Config, StepBegun};

/// A robot with one sensor, which looks straight ahead.
pub(super) fn config(profile: Profile) -> Config {
    let mut ring = Ring::AMIRO;
    ring.axis_rad = [0.0; SENSORS];
    Config {
        ring,
        sensors: SensorMask::NONE.with(0),
        ..Config::amiro(profile)
    }
}

/// The step in which the sensor has come so far from the origin and reads counts.
pub(super) fn step(index: u32, travelled_m: f32, counts: i32) -> StepBegun {
    let mut samples = [Sample::Missing; SENSORS];
    if let Some(sample) = samples.first_mut() {
        *sample = Sample::Counts(counts);
    }
    StepBegun {
        index,
        stamp_us: 125_000 * u64::from(index),
        // The body's centre is behind the sensor.
        pose: Pose::new(travelled_m - Ring::AMIRO.radius_m, 0.0, 0.0),
        samples,
    }
}

/// Counts of a surface so far ahead, without noise.
pub(super) fn counts_at(range_m: f32) -> i32 {
    let counts = Photometry::VCNL4020.counts(range_m, 0.0);
    // The cast saturates; counts have no fraction, and 0 is nothing in range.
    counts.unwrap_or(0.0).round_ties_even() as i32
}
