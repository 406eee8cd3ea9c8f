//! A simulated drive: what the robot would have been told.

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::input::Input;
use amiro_ipf::random::Generator;

use super::odometry::Odometer;
use super::{Drive, Dropout, Options, Scenario, Sensing};

/// Keeps the world's noise apart from a filter with the same seed: "world" in ASCII.
const NOISE_STREAM: u64 = 0x77_6f72_6c64;
/// Keeps lost samples apart from both: "drops". A drive's noise is then the same
/// whatever is lost of it.
const DROPOUT_STREAM: u64 = 0x64_726f_7073;
/// Keeps the wheels' errors apart: "wheel".
const WHEEL_STREAM: u64 = 0x77_6865_656c;

/// A simulated drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// For each sample the odometry that has come in by then, if any is new, and then
    /// the readings.
    pub inputs: Vec<Input>,
    /// Stamps and true poses of the samples.
    pub poses: Vec<(u64, Pose)>,
}

/// Drives through a world that is as the filter's model says; the odometry is perfect.
///
/// As [`simulate_with`] and no options.
#[must_use]
pub fn simulate(scenario: &Scenario, seed: u64) -> Simulation {
    simulate_with(scenario, seed, &Options::default())
}

/// Drives through a world and records the sensors and the odometry.
///
/// Equal scenarios, seeds and options give equal inputs, bit for bit, on every machine.
/// Options that [`Options::validate`] refuses give readings that mean nothing.
#[must_use]
pub fn simulate_with(scenario: &Scenario, seed: u64, options: &Options) -> Simulation {
    // The profile does not matter here: the sensors are the same.
    let config = scenario.config(Profile::Paper);
    let stream = |stream: u64| Generator::seeded(seed ^ stream);
    let drive = Drive::of(scenario);
    let mut sensing = Sensing::new(
        config.ring,
        config.sensors,
        options.photometry(&config.photometry),
        options.physics,
        stream(NOISE_STREAM),
    );
    let mut dropout = Dropout::new(options.dropout, stream(DROPOUT_STREAM));
    let mut odometer = Odometer::new(options.odometry, &drive.pose_at(0), stream(WHEEL_STREAM));
    let poses: Vec<_> = drive.samples().collect();
    let mut inputs = Vec::with_capacity(2 * poses.len());
    for &(stamp_us, pose) in &poses {
        let told = odometer.told_at(&drive, stamp_us);
        inputs.extend(told.map(|(stamp_us, pose)| Input::Odometry { stamp_us, pose }));
        let drift_counts = options.drift.at(stamp_us, drive.end_us());
        let samples = sensing.sample(&scenario.shapes, &pose, drift_counts);
        let samples = dropout.thin(samples);
        inputs.push(Input::Proximity { stamp_us, samples });
    }
    Simulation { inputs, poses }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::checksum::CRC;
    use amiro_ipf::sensor::Sample;

    const TURNING: &str = r#"
        name = "turning"
        cell_m = 0.01
        extent_m = [-1, -1, 1, 1]
        speed_m_per_s = 0.08
        start = [0, 0, 20]
        [[drive]]
        straight_m = 0.1
        [[drive]]
        turn_deg = 70
        [[drive]]
        arc_deg = -60
        radius_m = 0.1
        [[box]]
        min = [0.2, 0.05]
        max = [0.3, 0.15]
        angle_deg = 30
        [[cylinder]]
        center = [0.05, 0.3]
        radius_m = 0.03
    "#;

    fn counts(simulation: &Simulation) -> Vec<u8> {
        let samples = simulation.inputs.iter().filter_map(|input| match input {
            Input::Proximity { samples, .. } => Some(*samples),
            _ => None,
        });
        samples
            .flatten()
            .flat_map(|sample| match sample {
                Sample::Counts(counts) => counts.to_le_bytes(),
                Sample::Saturated => [0xff; 4],
                Sample::Missing => [0xfe; 4],
            })
            .collect()
    }

    #[test]
    fn equal_seeds_give_equal_drives_and_others_do_not() {
        let scenario = Scenario::parse(TURNING).unwrap();
        let simulation = simulate(&scenario, 5);
        assert_eq!(simulation, simulate(&scenario, 5));
        assert_ne!(simulation, simulate(&scenario, 6));
        assert_eq!(simulation.inputs.len(), 2 * simulation.poses.len());
    }

    #[test]
    fn the_same_counts_come_out_on_every_machine() {
        // Pinned: a changed digest means that recordings can no longer be made again.
        let simulation = simulate(&Scenario::parse(TURNING).unwrap(), 1);
        assert_eq!(CRC.checksum(&counts(&simulation)), 0xc00a_2a23);
    }
}
