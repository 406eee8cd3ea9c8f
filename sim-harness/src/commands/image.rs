//! `cargo ipf image`: the flash image, built, checked and measured.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sim_harness::link::{Layout, build_image};

use super::{Ending, Outcome};

/// Arguments of `image`.
#[derive(Debug, Args)]
pub(super) struct Image {
    /// Where the image is to lie in flash.
    #[arg(long, value_enum, default_value = "bare")]
    layout: LayoutName,
    /// Check this ELF file instead of building one.
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum LayoutName {
    /// A bare board, from 0x0800_0000.
    Bare,
    /// Behind AMiRo's boot loader, from 0x0800_8000.
    Amiro,
}

impl Image {
    /// Runs the command.
    pub(super) fn run(self) -> Outcome {
        let layout = match self.layout {
            LayoutName::Bare => Layout::Bare,
            LayoutName::Amiro => Layout::Amiro,
        };
        let path = match self.file {
            Some(path) => path,
            None => build_image(layout)?,
        };
        let image = sim_harness::link::Image::read(&path)?;
        println!("{layout}: {image}");
        let problems = image.problems(layout);
        for problem in &problems {
            println!("  {problem}");
        }
        if problems.is_empty() {
            Ok(Ending::Good)
        } else {
            Ok(Ending::Failed)
        }
    }
}
