//! The arguments of `map`.

use std::path::PathBuf;

use clap::Args;
use sim_harness::datasets::PoseSource;
use sim_harness::evaluation::drive_maps::MapSettings;
use sim_harness::mapping::Method;

use super::arguments;
use super::keyframe_arguments::KeyframeArguments;

/// Arguments of `map`.
#[derive(Debug, Args)]
pub(super) struct MapCommand {
    /// Recorded drives: folders with `od.txt` and `sonar.txt`, or with `scans.csv`; files of an
    /// AMiRo, as for `replay`; logs of Player 1; servo sweeps. rigs/README.md describes them.
    #[arg(required = true, value_name = "DRIVE")]
    pub(super) drives: Vec<PathBuf>,
    /// The robot: a rig file, as in `rigs/`; the usual one of the recording's format if not
    /// given.
    #[arg(long, value_name = "FILE")]
    pub(super) rig: Option<PathBuf>,
    /// The methods, separated by commas, as in `ism,mal,wall-map`; or `all`. docs/methods.md
    /// describes each.
    #[arg(
        long,
        visible_alias = "method",
        value_delimiter = ',',
        default_value = "ism",
        value_name = "METHOD,..."
    )]
    pub(super) methods: Vec<String>,
    /// Only sensors whose names begin so, as in `sonar`. A method maps those of the kind that
    /// it is made for: `ism` the cones if there are some, else scanners, else infrared.
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    pub(super) sensors: Vec<String>,
    /// Alpha and gains of the sensors of an AMiRo, as `calibrate --from-drive` writes them;
    /// alpha is that of the rig's infrared sensors too.
    #[arg(long, value_name = "FILE")]
    pub(super) gains: Option<PathBuf>,
    /// Which poses of the recording: `odometry`, `matched` or `mocap`.
    #[arg(
        long,
        value_name = "SOURCE",
        default_value_t,
        conflicts_with = "matched"
    )]
    pub(super) poses: PoseSource,
    /// The same as `--poses matched`.
    #[arg(long)]
    pub(super) matched: bool,
    /// The true walls to score the maps with: CSV with the header x1,y1,x2,y2, metres.
    /// Without it the truth is the recording's own, if it has one.
    #[arg(long, value_name = "FILE")]
    pub(super) walls: Option<PathBuf>,
    /// Count cells before the limit of a return without an echo as free.
    #[arg(long)]
    pub(super) no_echo_is_free: bool,
    /// Side of a cell, millimetres; the usual one of the recording's format if not given.
    #[arg(long, value_name = "MM", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(super) cell_mm: Option<u16>,
    /// The same in metres.
    #[arg(long, value_name = "M", conflicts_with = "cell_mm", value_parser = cell_m)]
    pub(super) cell: Option<u16>,
    #[command(flatten)]
    pub(super) keyframes: KeyframeArguments,
    /// Where maps and summaries go; in a folder per method and drive where there are several.
    #[arg(long, default_value = "out/map", value_name = "DIR", value_parser = arguments::path())]
    pub(super) out: PathBuf,
    /// Writes the scores as JSON, a row per drive and method.
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    pub(super) json: Option<PathBuf>,
    /// End with exit code 2 if a row of a recording was refused.
    #[arg(long)]
    pub(super) strict: bool,
}

/// Whole millimetres from 1 to 1000, given in metres.
fn cell_m(text: &str) -> Result<u16, String> {
    let metres = text.parse::<f64>().ok();
    let mm = metres.map(|metres| 1e3 * metres);
    let mm = mm.filter(|mm| (1.0..=1000.0).contains(mm) && (mm - mm.round()).abs() < 1e-6);
    // Within 1 to 1000.
    mm.map(|mm| mm.round() as u16)
        .ok_or_else(|| "whole millimetres from 0.001 to 1 are expected".to_owned())
}

impl MapCommand {
    /// How the drives are mapped.
    pub(super) fn settings(&self) -> Result<MapSettings, String> {
        if self.sensors.iter().any(String::is_empty) {
            return Err("--sensors: a name is empty".to_owned());
        }
        Ok(MapSettings {
            methods: self.methods()?,
            poses: if self.matched {
                PoseSource::Matched
            } else {
                self.poses
            },
            keyframes: self.keyframes.given(),
            sensors: self.sensors.clone(),
            cell_mm: self.cell_mm.or(self.cell),
            no_echo_is_free: self.no_echo_is_free,
            calibration: arguments::calibration(self.gains.as_deref())?,
        })
    }

    fn methods(&self) -> Result<Vec<Method>, String> {
        if self.methods.iter().any(|name| name == "all") {
            return Ok(Method::OF_DRIVES.to_vec());
        }
        let named = |name: &String| {
            // The inverse sensor models of the comparison have their names of there.
            let method = Method::of_drives(name).or_else(|| {
                let method = name.parse::<Method>().ok();
                method.filter(|method| method.profile.is_none())
            });
            method.ok_or_else(|| {
                let known = Method::OF_DRIVES.iter().map(|method| method.name);
                let known: Vec<_> = known.collect();
                format!("--methods {name}: all, {} are known", known.join(", "))
            })
        };
        let methods: Vec<Method> = self.methods.iter().map(named).collect::<Result<_, _>>()?;
        let methods = arguments::distinct(&methods);
        if methods == [Method::ALL_FREE] {
            return Err("--methods all-free: name a method to compare with it".to_owned());
        }
        Ok(methods)
    }
}
