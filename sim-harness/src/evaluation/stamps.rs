//! The effect of odometry frames without stamps on a map.

use core::ops::Range;

use amiro_ipf::filter::Profile;
use amiro_ipf::node::{Config, Input};
use rayon::prelude::*;

use super::{MeanStd, map};
use crate::RunError;
use crate::faults::ActiveFaults;
use crate::robot::{Robot, drive};
use crate::world::{Options, Scenario};

/// The same drives of a robot with four odometries.
#[derive(Clone, Debug)]
pub struct StampTrials {
    /// The worlds and drives.
    pub scenarios: Vec<Scenario>,
    /// Seeds of noise, clocks and filters; the end is excluded.
    pub seeds: Range<u64>,
}

/// One scenario and profile: overall errors at the best wall expansion over the seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct StampRow {
    /// The scenario's name.
    pub scenario: String,
    /// The filter.
    pub profile: Profile,
    /// With exact poses at the readings' stamps.
    pub exact: MeanStd,
    /// With the frames' poses, stamped with the time of their computation.
    pub true_stamps: MeanStd,
    /// With the frames' poses as the acquisition stamps them.
    pub own_stamps: MeanStd,
    /// With the mean age as the age of every frame's pose.
    pub mean_age: MeanStd,
    /// The same four without wall expansion.
    pub plain: [MeanStd; 4],
    /// Distance of the steps' poses from the truth with true stamps, with the acquisition's
    /// stamps and with the mean age, root of the mean square over a drive, metres.
    pub off_m: [MeanStd; 3],
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
            let errors: Vec<Option<f64>> = drives.iter().map(|(oe, _, _)| oe[of]).collect();
            MeanStd::of(&errors)
        };
        let plain = |of: usize| {
            let errors: Vec<Option<f64>> = drives.iter().map(|(_, plain, _)| plain[of]).collect();
            MeanStd::of(&errors)
        };
        let off = |of: usize| {
            let each: Vec<_> = drives.iter().map(|(_, _, off_m)| off_m[of]).collect();
            MeanStd::of(&each)
        };
        Ok(StampRow {
            scenario: scenario.name.clone(),
            profile,
            exact: spread(0),
            true_stamps: spread(1),
            own_stamps: spread(2),
            mean_age: spread(3),
            plain: [plain(0), plain(1), plain(2), plain(3)],
            off_m: [off(1), off(2), off(3)],
        })
    }
}

/// Overall errors at the best expansion and plain, and distances from the truth, by
/// odometry.
type DriveErrors = ([Option<f64>; 4], [Option<f64>; 4], [Option<f64>; 4]);

/// Overall errors of one drive with the four odometries, and how far the steps' poses
/// were from the truth.
fn errors(scenario: &Scenario, profile: Profile, seed: u64) -> Result<DriveErrors, RunError> {
    let config = Config {
        seed,
        ..scenario.config(profile)
    };
    let robot = Robot::new(scenario, seed, &Options::default(), ActiveFaults::none());
    let whole = drive(robot);
    let true_place = |stamp_us: u64| {
        let at = whole.poses.partition_point(|(at_us, _)| *at_us < stamp_us);
        whole.poses.get(at).map(|(_, pose)| pose.position)
    };
    let variants: [Vec<Input>; 4] = [
        whole.inputs_with_true_poses(),
        whole.inputs_with_true_stamps(),
        whole.inputs(),
        whole.inputs_with_mean_age(),
    ];
    let (mut oe, mut plain, mut off_m) = ([None; 4], [None; 4], [None; 4]);
    let figures = oe.iter_mut().zip(&mut plain).zip(&mut off_m);
    for (inputs, ((oe, plain), off_m)) in variants.iter().zip(figures) {
        let mapped = map(scenario, &config, inputs)?;
        let scores = mapped.scores(scenario);
        (*oe, *plain) = (scores.oe, scores.oe_unexpanded);
        let squares = mapped.steps().filter_map(|step| {
            let off = true_place(step.stamp_us)? - step.pose.position;
            Some(f64::from(off.norm()).powi(2))
        });
        let (count, sum) = squares.fold((0_u32, 0.0), |(count, sum), square| {
            (count + 1, sum + square)
        });
        *off_m = (count > 0).then(|| (sum / f64::from(count)).sqrt());
    }
    Ok((oe, plain, off_m))
}
