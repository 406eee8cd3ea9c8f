//! What it costs a map that a frame does not say when its pose was reckoned.

use core::ops::Range;

use amiro_ipf::config::Config;
use amiro_ipf::filter::Profile;
use amiro_ipf::input::Input;
use rayon::prelude::*;

use super::{Robot, RobotFaults, drive, map};
use crate::RunError;
use crate::evaluation::Spread;
use crate::world::{Options, Scenario};

/// The same drives of a robot with three odometries.
#[derive(Clone, Debug)]
pub struct StampTrials {
    /// The worlds and drives.
    pub scenarios: Vec<Scenario>,
    /// Seeds of noise, clocks and filters; the end is excluded.
    pub seeds: Range<u64>,
}

/// One scenario and profile: overall errors over the seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct StampRow {
    /// The scenario's name.
    pub scenario: String,
    /// The filter.
    pub profile: Profile,
    /// With exact poses at the readings' stamps.
    pub exact: Spread,
    /// With the frames' poses, stamped with the time that they were reckoned at.
    pub true_stamps: Spread,
    /// With the frames' poses as the senses stamp them.
    pub own_stamps: Spread,
    /// Largest distance between a step's pose and the truth with true stamps, and with
    /// the senses' own, metres.
    pub farthest_m: [f64; 2],
}

impl StampTrials {
    /// Drives and maps everything: by scenario, then profile.
    ///
    /// # Errors
    /// A filter did not run.
    pub fn run(&self) -> Result<Vec<StampRow>, RunError> {
        let profiles = [Profile::Paper, Profile::Plus];
        let rows = self
            .scenarios
            .iter()
            .flat_map(|scenario| profiles.map(|profile| self.row(scenario, profile)));
        rows.collect()
    }

    fn row(&self, scenario: &Scenario, profile: Profile) -> Result<StampRow, RunError> {
        let seeds: Vec<u64> = self.seeds.clone().collect();
        let drives: Result<Vec<_>, RunError> = seeds
            .par_iter()
            .map(|seed| errors(scenario, profile, *seed))
            .collect();
        let drives = drives?;
        let spread = |of: usize| {
            let errors: Vec<Option<f64>> = drives.iter().map(|(oe, _)| oe[of]).collect();
            Spread::of(&errors)
        };
        let farthest = |of: usize| {
            let each = drives.iter().map(|(_, off_m)| off_m[of]);
            each.fold(0.0, f64::max)
        };
        Ok(StampRow {
            scenario: scenario.name.clone(),
            profile,
            exact: spread(0),
            true_stamps: spread(1),
            own_stamps: spread(2),
            farthest_m: [farthest(1), farthest(2)],
        })
    }
}

/// Overall errors of one drive with the three odometries, and how far the steps' poses
/// were from the truth.
fn errors(
    scenario: &Scenario,
    profile: Profile,
    seed: u64,
) -> Result<([Option<f64>; 3], [f64; 3]), RunError> {
    let config = Config {
        seed,
        ..scenario.config(profile)
    };
    let robot = Robot::new(scenario, seed, &Options::default(), RobotFaults::none());
    let whole = drive(robot);
    let true_pose = |stamp_us: u64| {
        let at = whole.poses.partition_point(|(at_us, _)| *at_us < stamp_us);
        whole.poses.get(at).map(|(_, pose)| pose.position)
    };
    let variants: [Vec<Input>; 3] = [
        whole.inputs_with_true_poses(),
        whole.inputs_with_true_stamps(),
        whole.inputs(),
    ];
    let (mut oe, mut farthest_m) = ([None; 3], [0.0; 3]);
    for ((inputs, oe), farthest_m) in variants.iter().zip(&mut oe).zip(&mut farthest_m) {
        let mapped = map(scenario, &config, inputs)?;
        *oe = mapped.scores(scenario).oe;
        let off = mapped.steps().filter_map(|step| {
            let off = true_pose(step.stamp_us)? - step.pose.position;
            Some(f64::from(off.norm()))
        });
        *farthest_m = off.fold(0.0, f64::max);
    }
    Ok((oe, farthest_m))
}
