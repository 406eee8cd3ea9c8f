//! `cargo ipf map`: recorded drives of any robot, mapped by one method or by many.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use sim_harness::console;
use sim_harness::datasets::{Dataset, PoseSource, recognise};
use sim_harness::drive::TrueWorld;
use sim_harness::evaluation::json_lines;
use sim_harness::mapping::Method;
use sim_harness::output;
use sim_harness::rig::Rig;

use super::keyframe_arguments::KeyframeArguments;
use super::map_drive::{MapSettings, MappedRecording, Recording};
use super::{CommandResult, ExitStatus, arguments};

/// Arguments of `map`.
#[derive(Debug, Args)]
pub(super) struct MapCommand {
    /// Recorded drives: folders with `od.txt` and `sonar.txt`, or with `scans.csv`; or an
    /// AMiRo's files, as for `replay`.
    #[arg(required = true, value_name = "DRIVE")]
    drives: Vec<PathBuf>,
    /// The robot: a rig file, as in `rigs/`; the usual one of the recording's format if not
    /// given.
    #[arg(long, value_name = "FILE")]
    rig: Option<PathBuf>,
    /// The methods, separated by commas, as in `ism,mal,wall-map`; or `all`.
    #[arg(
        long,
        visible_alias = "method",
        value_delimiter = ',',
        default_value = "ism",
        value_name = "METHOD,..."
    )]
    methods: Vec<String>,
    /// Only sensors whose names begin so, as in `sonar`; those of the rig that the method
    /// maps if not given.
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    sensors: Vec<String>,
    /// Alpha and gains of the sensors of an AMiRo, as `calibrate --from-drive` writes them;
    /// alpha is that of the rig's infrared sensors too.
    #[arg(long, value_name = "FILE")]
    gains: Option<PathBuf>,
    /// Which poses of the recording: `odometry`, `matched` or `mocap`.
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
    /// The true walls to score the maps with: CSV with the header x1,y1,x2,y2, metres.
    /// Without it the truth is the recording's own, if it has one.
    #[arg(long, value_name = "FILE")]
    walls: Option<PathBuf>,
    /// Count cells before the limit of a return without an echo as free.
    #[arg(long)]
    no_echo_is_free: bool,
    /// Side of a cell, millimetres; the usual one of the recording's format if not given.
    #[arg(long, value_name = "MM", value_parser = clap::value_parser!(u16).range(1..=1000))]
    cell_mm: Option<u16>,
    /// The same in metres.
    #[arg(long, value_name = "M", conflicts_with = "cell_mm", value_parser = cell_m)]
    cell: Option<u16>,
    #[command(flatten)]
    keyframes: KeyframeArguments,
    /// Where maps and summaries go; in a folder per method and drive where there are several.
    #[arg(long, default_value = "out/map", value_name = "DIR", value_parser = arguments::path())]
    out: PathBuf,
    /// Writes the scores as JSON, a row per drive and method.
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    json: Option<PathBuf>,
    /// End with exit code 2 if a row of a recording was refused.
    #[arg(long)]
    strict: bool,
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
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        arguments::check_folder("--out", &self.out)?;
        let methods = self.methods()?;
        let settings = MapSettings {
            is_alone: methods.len() == 1,
            methods,
            calibration: arguments::calibration(self.gains.as_deref())?,
            poses: if self.matched {
                PoseSource::Matched
            } else {
                self.poses
            },
            no_echo_is_free: self.no_echo_is_free,
            sensors: &self.sensors,
            keyframes: &self.keyframes,
            cell_mm: self.cell_mm.or(self.cell),
        };
        let recordings = self.recordings(&settings)?;
        self.check_outputs(&recordings, &settings)?;
        let mut rows = Vec::new();
        let mut has_refused = false;
        for recording in &recordings {
            if recordings.len() > 1 {
                console::print(format_args!("{}", recording.path.display()));
            }
            let mapped: MappedRecording = recording.map(&settings)?;
            has_refused |= mapped.has_refused_rows;
            rows.extend(mapped.rows);
        }
        if let Some(path) = &self.json {
            output::write(path, json_lines(&rows)?.as_bytes())?;
        }
        Ok(if self.strict && has_refused {
            ExitStatus::Refused
        } else {
            ExitStatus::Good
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

    /// The recordings with their robots, truths and folders for output.
    fn recordings(
        &self,
        settings: &MapSettings<'_>,
    ) -> Result<Vec<Recording>, Box<dyn std::error::Error>> {
        let mut names = BTreeSet::new();
        let mut recordings = Vec::new();
        for path in &self.drives {
            let dataset = recognise(path)?;
            let mut rig = self.rig_of(dataset, path)?;
            if let Some(calibration) = &settings.calibration {
                rig.set_alpha(calibration.alpha_counts_m2);
            }
            for name in &self.sensors {
                if !rig.mounts.iter().any(|mount| mount.name.starts_with(name)) {
                    let known: Vec<_> = rig.mounts.iter().map(|it| it.name.as_str()).collect();
                    let (rig, known) = (&rig.name, known.join(", "));
                    return Err(format!("--sensors {name}: rig {rig} has {known}").into());
                }
            }
            let world = match &self.walls {
                Some(walls) => {
                    let world = TrueWorld::load_walls(walls);
                    Some(world.map_err(|error| format!("--walls: {error}"))?)
                }
                None => dataset.true_world(path)?,
            };
            let mut out = self.out.clone();
            if self.drives.len() > 1 {
                let name = folder_name(path);
                if !names.insert(name.clone()) {
                    return Err(format!("two drives would be written to {name}").into());
                }
                out.push(name);
            }
            recordings.push(Recording {
                path: path.clone(),
                dataset,
                rig,
                world,
                out,
            });
        }
        Ok(recordings)
    }

    fn rig_of(
        &self,
        dataset: &dyn Dataset,
        drive: &Path,
    ) -> Result<Rig, Box<dyn std::error::Error>> {
        match (&self.rig, dataset.usual_rig()) {
            (Some(path), _) => Ok(Rig::load(path)?),
            (None, Some(text)) => Ok(Rig::parse(dataset.name(), text)?),
            (None, None) => Err(format!(
                "{}: recordings of {} are of any robot: --rig names it",
                drive.display(),
                dataset.name()
            )
            .into()),
        }
    }

    fn check_outputs(
        &self,
        recordings: &[Recording],
        settings: &MapSettings<'_>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let files = recordings.iter().flat_map(|it| it.outputs(settings));
        let files: Vec<PathBuf> = files.chain(self.json.clone()).collect();
        let inputs = self.drives.iter().chain(&self.rig).chain(&self.gains);
        let inputs: Vec<&Path> = inputs.chain(&self.walls).map(PathBuf::as_path).collect();
        output::check(&files, &inputs)?;
        if let Some(path) = &self.json {
            arguments::check_file("--json", path)?;
        }
        Ok(())
    }
}

/// The name of a drive's folder of output: its own two last names.
fn folder_name(path: &Path) -> String {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut names: Vec<String> = path
        .components()
        .rev()
        .take(2)
        .map(|part| part.as_os_str().to_string_lossy().replace('/', ""))
        .collect();
    names.reverse();
    names.join("-")
}
