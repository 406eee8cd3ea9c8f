//! `cargo ipf calibrate`: the laws of a sensor fitted to a table of measurements, or gains of
//! sensors to recorded drives.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sim_harness::calibration::{Fit, Fixed, LawComparison, LawKind, Parameter, Table, fit_law};
use sim_harness::report::fit_chart;
use sim_harness::{console, output};

use super::calibrate_drives::DriveCalibration;
use super::{CommandResult, ExitStatus, arguments};

/// Files that `--out` writes.
const FILES: [&str; 3] = ["fit.png", "fit.csv", "photometry.json"];

/// What a user of the wall law with its delta must know.
const NO_DELTA: &str = "\nMaps of walls use no delta: for their alpha fit with --fix delta=0.\n";

/// The laws to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LawName {
    /// The law of small surfaces: counts fall with the bearing as cos(xi theta).
    Point,
    /// The law of extended surfaces: an endless wall, theta the bearing of its normal.
    Wall,
    /// Both, and which of them explains the table better.
    Both,
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub(super) struct Calibrate {
    /// The table: CSV under a header that names range_m (or range_cm, range_mm),
    /// angle_deg (or angle_rad), counts, and weight if wanted. Commas between the
    /// values, or semicolons: then the numbers may have decimal commas. Range and angle
    /// are those of the surface's nearest point.
    #[arg(required_unless_present = "from_drive")]
    table: Option<PathBuf>,
    /// The law to fit.
    #[arg(long, value_enum, default_value = "both")]
    law: LawName,
    /// A parameter that is known already: alpha, beta, xi, delta or sigma.
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true)]
    fix: Vec<String>,
    #[command(flatten)]
    drives: DriveCalibration,
    /// Folder for `fit.png`, `fit.csv` and `photometry.json`: of the better law, of the
    /// point law if the table does not decide. With --from-drive a TOML file for the gains.
    #[arg(long, value_name = "DIR|FILE", value_parser = arguments::path())]
    out: Option<PathBuf>,
}

impl Calibrate {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        match &self.table {
            Some(path) if !self.drives.is_asked_for() => self.run_table(path),
            _ => self.drives.run(self.out.as_deref()),
        }
    }

    fn run_table(&self, path: &Path) -> CommandResult {
        if let Some(folder) = &self.out {
            arguments::check_folder("--out", folder)?;
            output::check(&FILES.map(|name| folder.join(name)), &[path])?;
        }
        let fixed = Fixed::parse(self.fix.iter().map(String::as_str))
            .map_err(|error| format!("--fix: {error}"))?;
        let named = |error: &dyn Error| format!("{}: {error}", path.display());
        let table = Table::load(path).map_err(|error| named(&error))?;
        let (fit, text) = self
            .fitted(&table, &fixed)
            .map_err(|error| named(&*error))?;
        let json = serde_json::to_string_pretty(&fit)?;
        if let Some(folder) = &self.out {
            write_files(folder, &fit, &json)?;
        }
        let is_extended = fit.law == LawKind::Wall && fit.value(Parameter::Delta).abs() > 0.0;
        let note = if is_extended { NO_DELTA } else { "" };
        console::print_text(format_args!(
            "{text}{note}\n{}\n{}\n\n{json}",
            fit.residuals(),
            fit.rust()
        ));
        Ok(ExitStatus::Good)
    }

    /// The fit that is written, and the text about all that were made.
    fn fitted(&self, table: &Table, fixed: &Fixed) -> Result<(Fit, String), Box<dyn Error>> {
        let kind = match self.law {
            LawName::Point => LawKind::Point,
            LawName::Wall => LawKind::Wall,
            LawName::Both => {
                let both = LawComparison::of(table, fixed)?;
                let fit = both.better().map_err(Clone::clone)?.clone();
                let text = format!("{both}\nOf the {}:\n", fit.law.name());
                return Ok((fit, text));
            }
        };
        let fit = fit_law(kind, table, fixed)?;
        let text = fit.to_string();
        Ok((fit, text))
    }
}

fn write_files(folder: &Path, fit: &Fit, json: &str) -> Result<(), Box<dyn Error>> {
    output::create_folder(folder)?;
    let [chart, rows, law] = FILES.map(|name| folder.join(name));
    fit_chart(fit).save_png(&chart)?;
    output::write(&rows, fit.csv().as_bytes())?;
    output::write(&law, format!("{json}\n").as_bytes())?;
    Ok(())
}
