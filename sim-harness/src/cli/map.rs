//! `cargo ipf map`: a recorded drive of any robot, mapped from its ranges.

use std::cell::RefCell;
use std::path::PathBuf;

use clap::Args;
use sim_harness::datasets::{DriveFile, PoseSource, recognise};
use sim_harness::mapping::{FinishProgress, Mapper, NoEcho, Setup};
use sim_harness::output;
use sim_harness::pipeline::{self, DriveOptions};
use sim_harness::report::{DRIVE_FILES, DriveMapSummary};
use sim_harness::rig::Rig;

use super::keyframe_arguments::KeyframeArguments;
use super::progress::PassProgress;
use super::{CommandResult, ExitStatus, arguments, map_method, map_report};

/// Arguments of `map`.
#[derive(Debug, Args)]
pub(super) struct MapCommand {
    /// The recorded drive: a folder with `od.txt` and `sonar.txt`, or with `scans.csv`; or an
    /// AMiRo's, as for `replay`.
    drive: PathBuf,
    /// The robot: a rig file, as in `rigs/`.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// The method, as `ism`, `ism-decay`, `kleppe`, or `wall-map` for infrared sensors.
    #[arg(long, default_value = "ism", value_name = "METHOD")]
    method: String,
    /// Only sensors whose names begin so, as in `sonar`; all of the rig if not given.
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    sensors: Vec<String>,
    /// Alpha and gains of the sensors of an AMiRo, as `calibrate --from-drive` writes them;
    /// alpha is that of the rig's infrared sensors too.
    #[arg(long, value_name = "FILE")]
    gains: Option<PathBuf>,
    /// Which poses of the recording: `odometry`, `matched` or `motion-capture`.
    #[arg(
        long,
        value_name = "SOURCE",
        default_value_t,
        conflicts_with = "matched"
    )]
    poses: PoseSource,
    /// The same as `--poses matched`.
    #[arg(long)]
    matched: bool,
    /// Count cells before the limit of a return without an echo as free.
    #[arg(long)]
    no_echo_is_free: bool,
    /// Side of a cell; 100 if not given, 10 for an AMiRo.
    #[arg(long, value_name = "MM", value_parser = clap::value_parser!(u16).range(1..=1000))]
    cell_mm: Option<u16>,
    #[command(flatten)]
    keyframes: KeyframeArguments,
    /// Where map and summary go.
    #[arg(long, default_value = "out/map", value_name = "DIR", value_parser = arguments::path())]
    out: PathBuf,
    /// End with exit code 2 if a row of the recording was refused.
    #[arg(long)]
    strict: bool,
}

impl MapCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        arguments::check_folder("--out", &self.out)?;
        let mut rig = Rig::load(&self.rig)?;
        let calibration = arguments::calibration(self.gains.as_deref())?;
        if let Some(calibration) = &calibration {
            rig.set_alpha(calibration.alpha_counts_m2);
        }
        let method = map_method::named(&self.method, &rig)?;
        for name in &self.sensors {
            if !rig.mounts.iter().any(|mount| mount.name.starts_with(name)) {
                let known: Vec<_> = rig.mounts.iter().map(|it| it.name.as_str()).collect();
                let (rig, known) = (&rig.name, known.join(", "));
                return Err(format!("--sensors {name}: rig {rig} has {known}").into());
            }
        }
        let dataset = recognise(&self.drive)?;
        let outputs = DRIVE_FILES.map(|name| self.out.join(name));
        let inputs = [&self.rig, &self.drive].into_iter().chain(&self.gains);
        output::check(&outputs, &inputs.map(PathBuf::as_path).collect::<Vec<_>>())?;
        let usual = dataset.usual();
        let cell_m = 1e-3 * f64::from(self.cell_mm.unwrap_or(usual.cell_mm));
        let mut mapper = method.mapper(&Setup {
            no_echo: self.no_echo_is_free.then_some(NoEcho::Free),
            ..Setup::new(&rig, cell_m)
        });
        let poses = if self.matched {
            PoseSource::Matched
        } else {
            self.poses
        };
        let drive = DriveFile {
            path: &self.drive,
            rig: &rig,
            poses,
            calibration,
        };
        let options = DriveOptions {
            keyframes: self.keyframes.keyframes(method.keyframes(usual.keyframes)),
            mounts: self.sensors.clone(),
        };
        let progress = RefCell::new(PassProgress::default());
        let mut show = |bytes, length| progress.borrow_mut().show("mapped", bytes, length);
        let run = pipeline::run_with_progress(
            |take| pipeline::dataset_records(dataset, &drive, &options, &mut show, take),
            &mut mapper,
            &mut |_, _| {},
            &mut |FinishProgress { stage, done, of }| {
                progress.borrow_mut().show_count(stage, done, of);
            },
        )?;
        drop(progress);
        map_report::left_out(&run);
        let map = mapper.map();
        if let Err(reason) = run.check(&map) {
            return Err(format!("{}: no map: {reason}", self.drive.display()).into());
        }
        let words = [dataset.name(), method.name, poses.name()];
        let summary = DriveMapSummary::of(words, &rig, &run, &map);
        output::create_folder(&self.out)?;
        summary.save(&self.out, &map, &rig, &run)?;
        map_report::figures(&summary);
        Ok(if self.strict && run.refused.count > 0 {
            ExitStatus::Refused
        } else {
            ExitStatus::Good
        })
    }
}
