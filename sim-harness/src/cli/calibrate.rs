//! `cargo ipf calibrate`: the photometric law fitted to a table of measurements.

use std::path::PathBuf;

use clap::Args;
use sim_harness::calibration::{Fixed, Table, fit};
use sim_harness::report::fit_chart;
use sim_harness::{console, output};

use super::{CommandResult, ExitStatus, arguments};

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub(super) struct Calibrate {
    /// The table: CSV under a header that names range_m (or range_cm, range_mm),
    /// angle_deg (or angle_rad), counts, and weight if wanted. Commas between the
    /// values, or semicolons: then the numbers may have decimal commas.
    table: PathBuf,
    /// A parameter that is known already: alpha, beta, xi, delta or sigma.
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true)]
    fix: Vec<String>,
    /// Folder for `fit.png`, `fit.csv` and `photometry.json`.
    #[arg(long, value_name = "DIR", value_parser = arguments::path())]
    out: Option<PathBuf>,
}

impl Calibrate {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        if let Some(folder) = &self.out {
            let outputs = ["fit.png", "fit.csv", "photometry.json"].map(|name| folder.join(name));
            arguments::check_folder("--out", folder)?;
            output::check(&outputs, &[&self.table])?;
        }
        let fixed = Fixed::parse(self.fix.iter().map(String::as_str))
            .map_err(|error| format!("--fix: {error}"))?;
        let named = |error: &dyn std::error::Error| format!("{}: {error}", self.table.display());
        let table = Table::load(&self.table).map_err(|error| named(&error))?;
        let fit = fit(&table, &fixed).map_err(|error| named(&error))?;
        let json = serde_json::to_string_pretty(&fit)?;
        if let Some(folder) = &self.out {
            output::create_folder(folder)?;
            fit_chart(&fit).save_png(&folder.join("fit.png"))?;
            output::write(&folder.join("fit.csv"), fit.csv().as_bytes())?;
            output::write(
                &folder.join("photometry.json"),
                format!("{json}\n").as_bytes(),
            )?;
        }
        console::print_text(format_args!(
            "{fit}\n{}\n{}\n\n{json}",
            fit.residuals(),
            fit.rust()
        ));
        Ok(ExitStatus::Good)
    }
}
