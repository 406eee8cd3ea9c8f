//! Walls beside recorded drives of an AMiRo, leg by leg, as each method maps them.
//!
//! `cargo run --release -p sim-harness --example moving_drives -- FILE... --masked 3,4`

use std::error::Error;
use std::path::PathBuf;

use amiro_ipf::model::{Photometry, SENSORS, SensorMask};
use clap::Parser;
use serde::Serialize;
use sim_harness::evaluation::{Number, WallSideRow, WallSideSettings, json_lines};
use sim_harness::mapping::Method;
use sim_harness::{console, log, output};

/// Occupied cells on both sides of each leg, and the straight line through most of them.
#[derive(Debug, Parser)]
struct Arguments {
    /// Recordings, as for `replay`.
    #[arg(required = true, value_name = "FILE")]
    drives: Vec<PathBuf>,
    /// Methods, separated by commas.
    #[arg(
        long,
        value_name = "METHODS",
        value_delimiter = ',',
        default_value = "plus,wall-map"
    )]
    methods: Vec<Method>,
    /// Sensors that are not used, separated by commas, such as those that see another robot.
    #[arg(
        long,
        value_name = "N,...",
        value_delimiter = ',',
        value_parser = clap::value_parser!(u8).range(0..SENSORS as i64)
    )]
    masked: Vec<u8>,
    /// Range limit of filters and inverse sensor models, metres.
    #[arg(long, value_name = "M", default_value_t = 0.20)]
    x_max_m: f32,
    /// Gain of their law, counts m^2; the sensor's own if not given.
    #[arg(long, value_name = "A")]
    alpha: Option<f32>,
    /// Gain of the law of extended surfaces, counts m^2, for methods that fit signals; that
    /// of the six recorded series if not given.
    #[arg(long, value_name = "A", default_value_t = 1.97)]
    wall_alpha: f32,
    /// Particles for each sensor in use.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    particles: u16,
    /// File for the figures.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// A row with the drive that it is of.
#[derive(Debug, Serialize)]
struct DriveRow<'r> {
    drive: &'r str,
    #[serde(flatten)]
    row: &'r WallSideRow,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let masked = arguments.masked.iter().map(|sensor| usize::from(*sensor));
    let masked: SensorMask = masked.collect();
    let own = Photometry::VCNL4020;
    let settings = WallSideSettings {
        sensors: masked.complement(),
        photometry: Photometry {
            x_max_m: arguments.x_max_m,
            alpha_counts_m2: arguments.alpha.unwrap_or(own.alpha_counts_m2),
            ..own
        },
        particles_per_sensor: arguments.particles,
        wall_alpha_counts_m2: arguments.wall_alpha,
    };
    console::print(
        "On the line: occupied cells of the side within 20 mm of the line through most of them.",
    );
    let mut rows = Vec::new();
    for path in &arguments.drives {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let recording = log::read(path)?;
        console::print("");
        console::print(&name);
        console::print(format_args!(
            "{:12} {:>3} {:5}  {:>11} {:>5} {:>10} {:>10} {:>10}",
            "method", "leg", "side", "on the line", "share", "RMS there", "RMS all", "covered mm"
        ));
        for method in &arguments.methods {
            for row in WallSideRow::of(&recording.inputs, method, &settings)? {
                console::print(line(&row));
                rows.push((name.clone(), row));
            }
        }
    }
    if let Some(path) = &arguments.json {
        let rows = rows.iter().map(|(drive, row)| DriveRow { drive, row });
        output::write(path, json_lines(rows)?.as_bytes())?;
    }
    Ok(())
}

fn line(row: &WallSideRow) -> String {
    let side = &row.side;
    let millimetres = |metres: Option<f64>| Number {
        value: metres.map(|metres| 1e3 * metres),
        decimals: 1,
    };
    let share = Number {
        value: side.share,
        decimals: 2,
    };
    format!(
        "{:12} {:3} {:5}  {:4} of {:4} {share:5} {:10} {:10} {:10.0}",
        row.method,
        row.leg,
        if row.is_left { "left" } else { "right" },
        side.inliers,
        side.occupied,
        millimetres(side.rms_inliers_m),
        millimetres(side.rms_all_m),
        1e3 * side.covered_m,
    )
}
