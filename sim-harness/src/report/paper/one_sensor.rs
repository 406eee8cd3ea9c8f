//! One sensor that looks straight ahead, at the origin of the figures.

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::{Point, Pose, Rotation};
use amiro_ipf::model::{Photometry, Ring, SENSORS, Sample, SensorMask};
use amiro_ipf::node::{Config, StepBegun};

/// Bearings between the middle and an end of an arc: half a degree apart.
const STEPS_PER_SIDE: i16 = 120;

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

/// The step in which the sensor has moved so far from the origin and reads counts.
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

/// The arc x(s, theta) of a reading plus so many standard deviations, in millimetres
/// ahead of the sensor and to its left.
pub(super) fn arc_mm(counts: f32, deviations: f32) -> Vec<(f64, f64)> {
    let law = Photometry::VCNL4020;
    let bearings = (-STEPS_PER_SIDE..=STEPS_PER_SIDE)
        .map(|step| law.theta_max_rad * f32::from(step) / f32::from(STEPS_PER_SIDE));
    bearings
        .filter_map(|bearing| {
            let range_m = law.range_m(counts, bearing)?;
            let sigma_m = law.range_sigma_m(counts, bearing)?;
            let reach_m = range_m + deviations * sigma_m;
            let point = Point::new(reach_m, 0.0).rotated(Rotation::by(bearing));
            Some((1e3 * f64::from(point.x), 1e3 * f64::from(point.y)))
        })
        .collect()
}
