//! `cargo ipf odometry`: end errors of a recorded drive's odometry.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use sim_harness::calibration::{OdometryDrive, WheelFit, fit_wheels};
use sim_harness::datasets::{Dataset, DatasetError, DriveFile, PoseSource, recognise};
use sim_harness::geometry::Pose2;
use sim_harness::rig::Rig;
use sim_harness::{console, output};

use super::{CommandResult, ExitStatus, arguments};

/// Arguments of `odometry`.
#[derive(Debug, Args)]
pub(super) struct OdometryCommand {
    /// The recorded drive, with poses of the odometry and matched ones: a folder with
    /// `od.txt`, `sonar.txt` and `matched_poses.csv`.
    drive: PathBuf,
    /// The robot: a rig file with the distance between the wheels, as `rigs/kcma.toml`.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// How far the point of the matched poses lies before that of the odometry.
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 100,
        value_parser = clap::value_parser!(i32).range(-1000..=1000)
    )]
    lever_mm: i32,
    /// Write the figures to a file as JSON.
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    json: Option<PathBuf>,
}

const NONE: WheelFit = WheelFit {
    left: 1.0,
    right: 1.0,
    track: 1.0,
};

impl OdometryCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        if let Some(json) = &self.json {
            arguments::check_file("--json", json)?;
            output::check(std::slice::from_ref(json), &[&self.rig, &self.drive])?;
        }
        let rig = Rig::load(&self.rig)?;
        let track_m = rig
            .track_m
            .ok_or_else(|| format!("rig {}: track_m is needed", rig.name))?;
        let dataset = recognise(&self.drive)?;
        let odometry = self.poses(dataset, &rig, PoseSource::Odometry)?;
        let matched = self.poses(dataset, &rig, PoseSource::Matched)?;
        let lever_m = 1e-3 * f64::from(self.lever_mm);
        let drive = OdometryDrive::new(&odometry, &matched, track_m, lever_m).ok_or_else(|| {
            let drive = self.drive.display();
            format!("{drive}: fewer than two instants have a pose of both sources")
        })?;
        let fit = fit_wheels(&drive.segments(), track_m)
            .map_err(|error| format!("{}: {error}", self.drive.display()))?;
        let (raw, calibrated) = (drive.ends(&NONE)?, drive.ends(&fit)?);
        let (compass_deg, seeds) = (OdometryDrive::COMPASS_DEG, OdometryDrive::SEEDS);
        console::print_text(format_args!(
            "{} instants, {:.3} s apart; track {track_m} m\n\
             k1 {:.4}, k2 {:.4}, k3 {:.4}: fitted to this drive itself, segments of {} records\n\
             distance from the true end, m   k = 1   calibrated\n\
             wheels alone                    {:.3}   {:.3}\n\
             filtered with a compass         {:.3}   {:.3}\n\
             The compass is SIMULATED: the matched heading with {compass_deg} degrees of noise, \
             mean of {seeds} seeds. Wheel increments are computed from the poses of the odometry.",
            matched.len(),
            drive.period_s(),
            fit.left,
            fit.right,
            fit.track,
            OdometryDrive::SEGMENT,
            raw.wheels_m,
            calibrated.wheels_m,
            raw.filtered_m,
            calibrated.filtered_m,
        ));
        if let Some(json) = &self.json {
            let figures = serde_json::json!({
                "period_s": drive.period_s(),
                "k": [fit.left, fit.right, fit.track],
                "end_m": {
                    "raw": raw.wheels_m,
                    "calibrated": calibrated.wheels_m,
                    "filtered": raw.filtered_m,
                    "filtered_calibrated": calibrated.filtered_m,
                },
                "compass": { "simulated": true, "sigma_deg": compass_deg, "seeds": seeds },
            });
            output::write(json, format!("{figures:#}\n").as_bytes())?;
        }
        Ok(ExitStatus::Good)
    }

    /// The poses of a source by stamp.
    fn poses(
        &self,
        dataset: &dyn Dataset,
        rig: &Rig,
        poses: PoseSource,
    ) -> Result<BTreeMap<u64, Pose2>, DatasetError> {
        let drive = DriveFile {
            path: &self.drive,
            rig,
            poses,
            calibration: None,
            profile: None,
        };
        let mut by_stamp = BTreeMap::new();
        let mut take = |record: &sim_harness::drive::Record| {
            if let sim_harness::drive::Record::Pose {
                stamp_us,
                world_from_body,
            } = record
            {
                by_stamp.insert(*stamp_us, *world_from_body);
            }
        };
        let rows = dataset.read(&drive, &mut |_, _| {}, &mut take)?;
        if rows.refused.count > 0 {
            console::warn_text(&rows.refused);
        }
        Ok(by_stamp)
    }
}
