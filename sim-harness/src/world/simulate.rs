//! A simulated drive: what the robot would have been told.

use amiro_ipf::geometry::Pose;
use amiro_ipf::node::Input;
use amiro_ipf::random::Generator;

use super::odometry::Odometer;
use super::{Drive, Dropout, Options, Scenario, Sensing};

/// Keeps lost samples apart from the sensors' noise and from a filter with the same
/// seed: "drops" in ASCII. A drive's noise is then the same whatever is lost of it.
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
    let stream = |stream: u64| Generator::seeded(seed ^ stream);
    let drive = Drive::of(scenario);
    let mut sensing = Sensing::of(scenario, seed, options);
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
    use amiro_ipf::model::Sample;

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

    #[test]
    fn registers_along_a_drive_hold_its_samples_and_the_offsets() {
        let scenario = Scenario::parse(TURNING).unwrap();
        let options = Options::default();
        let simulation = simulate_with(&scenario, 4, &options);
        let mut sensing = Sensing::of(&scenario, 4, &options);
        let offsets = [2469, 2412, 2381, 2491, 2488, 2449, 2413, 2320];
        let readings = simulation.inputs.iter().filter_map(|input| match input {
            Input::Proximity { samples, .. } => Some(*samples),
            _ => None,
        });
        let mut compared = 0;
        for (samples, (_, pose)) in readings.zip(&simulation.poses) {
            let raw = sensing.raw_counts(&scenario.shapes, pose, 0.0, &offsets);
            for ((sample, raw), offset) in samples.into_iter().zip(raw).zip(offsets) {
                // The arc ends against the box.
                if raw == u16::MAX {
                    assert_eq!(sample, Sample::Saturated);
                } else {
                    let counts = i32::from(raw) - i32::from(offset);
                    assert_eq!(sample, Sample::Counts(counts));
                    compared += 1;
                }
            }
        }
        assert!(compared > 7 * simulation.poses.len(), "{compared}");
    }
}
