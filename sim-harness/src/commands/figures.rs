//! `cargo ipf figures`: the paper's figures from simulated drives.

use core::ops::Range;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use sim_harness::console;
use sim_harness::figures::{Figure, page};
use sim_harness::output;

use super::{Ending, Outcome, arguments};

/// Arguments of `figures`.
#[derive(Debug, Args)]
pub(super) struct Figures {
    /// Where `index.html` and the pictures go.
    #[arg(long, default_value = "out/figures", value_name = "DIR", value_parser = arguments::path())]
    out: PathBuf,
    /// Seeds from A up to B, without B; figures of one drive take the first.
    #[arg(long, default_value = "100..110", value_name = "A..B", value_parser = arguments::seeds, allow_hyphen_values = true)]
    seeds: Range<u64>,
    /// Draw only this figure; the page then shows no other.
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Figure::ALL.map(Figure::name)))]
    only: Option<String>,
}

impl Figures {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        arguments::check_folder("--out", &self.out)?;
        output::create_folder(&self.out)?;
        let is_wanted = |figure: &Figure| {
            let only = self.only.as_deref();
            only.is_none_or(|only| only == figure.name())
        };
        let mut plates = Vec::new();
        for figure in Figure::ALL.into_iter().filter(is_wanted) {
            let plate = figure.draw(&self.seeds)?;
            for panel in plate.panels() {
                panel.picture.save_png(&self.out.join(&panel.file))?;
            }
            if let Some((file, picture)) = &plate.excerpt {
                picture.save_png(&self.out.join(file))?;
            }
            plates.push(plate);
        }
        let index = self.out.join("index.html");
        output::write(&index, page(&plates).as_bytes())?;
        for plate in &plates {
            console::print(format_args!("{:>10}  {}", plate.name, plate.title));
        }
        console::print("");
        console::print(format_args!("Everything simulated: {}", index.display()));
        Ok(Ending::Good)
    }
}
