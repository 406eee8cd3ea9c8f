//! Random worlds of blocks, for scores that no geometry was chosen for.
//!
//! `cargo run -p sim-harness --example random_worlds -- FOLDER` writes ten scenarios; those
//! in `scenarios/random/` are from it. Equal seeds give equal files.

use std::error::Error;
use std::path::PathBuf;

use amiro_ipf::random::{Generator, uniform, uniform_below};
use clap::Parser;
use sim_harness::output;
use sim_harness::world::{Drive, Scenario, Vector};

/// Number of worlds, and seed of the first.
const WORLDS: u64 = 10;
const FIRST_SEED: u64 = 7_100;
/// A block's sides, metres.
const BLOCK_M: (f64, f64) = (0.2, 0.05);
/// Distance of a block from the way of the robot's centre, metres: 25 to 90 mm from its
/// rim, so that each block comes into the sensors' range.
const NEAREST_M: f64 = 0.075;
const FARTHEST_M: f64 = 0.14;
/// Distance of the blocks' centres, metres: blocks do not overlap.
const APART_M: f64 = 0.21;
/// Draws of a place before the world is begun anew.
const TRIES: u32 = 2_000;

/// Writes the random worlds.
#[derive(Debug, Parser)]
struct Arguments {
    /// Where the files go.
    folder: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Arguments::parse().folder;
    std::fs::create_dir_all(&folder)?;
    for seed in FIRST_SEED..FIRST_SEED + WORLDS {
        let mut draws = Generator::seeded(seed);
        let text = loop {
            if let Some(text) = world(seed, &mut draws)? {
                break text;
            }
        };
        Scenario::parse(&text)?.check_drive()?;
        output::write(&folder.join(format!("blocks_{seed}.toml")), text.as_bytes())?;
    }
    Ok(())
}

/// A number between two bounds, rounded to thousandths.
fn between(draws: &mut Generator, low: f64, high: f64) -> f64 {
    (1e3 * (low + (high - low) * f64::from(uniform(draws)))).round() / 1e3
}

/// A drive of about a metre and blocks beside it; `None` if they find no room.
fn world(seed: u64, draws: &mut Generator) -> Result<Option<String>, Box<dyn Error>> {
    let mut text = format!(
        "name = \"blocks_{seed}\"\n\
         about = \"random blocks of 200 x 50 mm beside a drive of about 1 m\"\n\
         # Made by the example random_worlds.\n\
         cell_m = 0.01\nextent_m = [-0.4, -1.2, 1.4, 1.2]\nspeed_m_per_s = 0.08\n\
         start = [0, 0, 0]\n"
    );
    let mut left_m = 1.0;
    for _ in 0..2 {
        let straight_m = between(draws, 0.15, 0.3);
        let radius_m = between(draws, 0.15, 0.3);
        let side = if uniform_below(draws, 2) == 0 {
            1.0
        } else {
            -1.0
        };
        let arc_deg = (side * between(draws, 20.0, 60.0)).round();
        left_m -= straight_m + radius_m * arc_deg.abs().to_radians();
        text += &format!(
            "[[drive]]\nstraight_m = {straight_m}\n\
             [[drive]]\narc_deg = {arc_deg}\nradius_m = {radius_m}\n"
        );
    }
    text += &format!("[[drive]]\nstraight_m = {:.3}\n", f64::max(left_m, 0.1));
    let drive = Drive::of(&Scenario::parse(&text)?);
    let way: Vec<Vector> = drive
        .samples()
        .map(|(_, pose)| Vector::from(pose.position))
        .collect();
    let wanted = 8 + uniform_below(draws, 3) as usize;
    let mut centres: Vec<Vector> = Vec::new();
    for _ in 0..TRIES {
        if centres.len() == wanted {
            return Ok(Some(text));
        }
        let centre = Vector::new(between(draws, -0.2, 1.2), between(draws, -1.0, 1.0));
        let angle_deg = between(draws, -90.0, 90.0).round();
        let block = block(centre, angle_deg);
        let shape = Scenario::parse(&format!("{text}{block}"))?.shapes.pop();
        let distances = way
            .iter()
            .filter_map(|place| Some(shape.as_ref()?.distance_m(*place)));
        let nearest_m = distances.fold(f64::INFINITY, f64::min);
        let is_apart = |other: &Vector| (*other - centre).norm() >= APART_M;
        if (NEAREST_M..=FARTHEST_M).contains(&nearest_m) && centres.iter().all(is_apart) {
            centres.push(centre);
            text += &block;
        }
    }
    Ok(None)
}

fn block(centre: Vector, angle_deg: f64) -> String {
    let (x, y) = (0.5 * BLOCK_M.0, 0.5 * BLOCK_M.1);
    format!(
        "[[box]]\nmin = [{:.3}, {:.3}]\nmax = [{:.3}, {:.3}]\nangle_deg = {angle_deg}\n",
        centre.x - x,
        centre.y - y,
        centre.x + x,
        centre.y + y
    )
}
