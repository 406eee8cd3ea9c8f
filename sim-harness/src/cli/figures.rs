//! `cargo ipf figures`: the paper's figures from simulated drives.

use core::ops::Range;
use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use sim_harness::report::{PaperFigure, page};
use sim_harness::{console, output};

use super::{CommandResult, ExitStatus, arguments};

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
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(PaperFigure::ALL.map(PaperFigure::name)))]
    only: Option<String>,
}

impl Figures {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        arguments::check_folder("--out", &self.out)?;
        output::create_folder(&self.out)?;
        let is_wanted = |figure: &PaperFigure| {
            let only = self.only.as_deref();
            only.is_none_or(|only| only == figure.name())
        };
        let mut sections = Vec::new();
        for figure in PaperFigure::ALL.into_iter().filter(is_wanted) {
            let section = figure.draw(&self.seeds)?;
            for panel in section.panels() {
                panel.picture.save_png(&self.out.join(&panel.file))?;
            }
            if let Some((file, picture)) = &section.excerpt {
                picture.save_png(&self.out.join(file))?;
            }
            sections.push(section);
        }
        let index = self.out.join("index.html");
        output::write(&index, page(&sections).as_bytes())?;
        for section in &sections {
            console::print(format_args!("{:>10}  {}", section.name, section.title));
        }
        console::print("");
        console::print(format_args!("Everything simulated: {}", index.display()));
        Ok(ExitStatus::Good)
    }
}
