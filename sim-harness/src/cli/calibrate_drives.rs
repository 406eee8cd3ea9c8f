//! `cargo ipf calibrate --from-drive`: gains of the sensors from recorded drives.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use amiro_ipf::model::{SENSORS, SensorMask};
use clap::Args;
use sim_harness::calibration::{DriveGainSettings, DriveGains};
use sim_harness::{console, output};

use super::{CommandResult, ExitStatus, arguments};

/// Arguments of `calibrate --from-drive`.
#[derive(Debug, Args)]
pub(super) struct DriveCalibration {
    /// Fit alpha and the gains of the eight sensors to recorded drives of one robot: .ipf
    /// recordings or AMiRo's text.
    #[arg(
        long,
        value_name = "FILE",
        num_args = 1..,
        conflicts_with_all = ["table", "law", "fix"]
    )]
    from_drive: Vec<PathBuf>,
    /// Alpha, counts m^2, if it is known, as from a table: then the gains alone are fitted.
    #[arg(
        long,
        value_name = "A",
        requires = "from_drive",
        conflicts_with = "table"
    )]
    alpha: Option<f32>,
    /// Sensors to leave out, by index: those that see something that moves.
    #[arg(
        long,
        value_name = "I,J",
        value_delimiter = ',',
        requires = "from_drive",
        conflicts_with = "table",
        value_parser = clap::value_parser!(u8).range(0..SENSORS as i64)
    )]
    mask: Vec<u8>,
    /// Replace the file of --out if it exists.
    #[arg(long, requires = "from_drive", conflicts_with = "table")]
    force: bool,
}

impl DriveCalibration {
    /// Whether gains are fitted to drives.
    pub(super) fn is_asked_for(&self) -> bool {
        !self.from_drive.is_empty()
    }

    /// A drive that is given twice would count twice.
    fn refuse_repeated(&self) -> Result<(), String> {
        let mut seen = BTreeSet::new();
        for file in &self.from_drive {
            let same = file.canonicalize().unwrap_or_else(|_| file.clone());
            if !seen.insert(same) {
                return Err(format!("--from-drive: {} is named twice", file.display()));
            }
        }
        Ok(())
    }

    /// Runs the command; `out` is the file for the gains.
    pub(super) fn run(&self, out: Option<&Path>) -> CommandResult {
        self.refuse_repeated()?;
        if let Some(out) = out {
            arguments::check_file("--out", out)?;
            let inputs: Vec<&Path> = self.from_drive.iter().map(PathBuf::as_path).collect();
            output::check(&[out.to_owned()], &inputs)?;
            if !self.force && out.exists() {
                let out = out.display();
                return Err(format!("--out: {out} exists; --force replaces it").into());
            }
        }
        let masked: SensorMask = self
            .mask
            .iter()
            .map(|sensor| usize::from(*sensor))
            .collect();
        let settings = DriveGainSettings {
            masked,
            alpha_counts_m2: self.alpha,
        };
        let gains = DriveGains::of(&self.from_drive, settings)?;
        console::print_text(&gains);
        if let Some(out) = out {
            output::write(out, gains.file().text().as_bytes())?;
        }
        Ok(ExitStatus::Good)
    }
}
