//! `cargo ipf image`: the flash image, built, checked and measured.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sim_harness::device::{Layout, build_image, to_s_records};
use sim_harness::{console, output};

use super::{CommandResult, ExitStatus, arguments};

/// Arguments of `image`.
#[derive(Debug, Args)]
pub(super) struct ImageCommand {
    /// Where the image is to lie in flash.
    #[arg(long, value_enum, default_value = "bare")]
    layout: LayoutName,
    /// Check this ELF file instead of building one.
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Write the bytes to flash here, and as S-records beside them (`.srec`).
    #[arg(long, value_name = "FILE", value_parser = arguments::path())]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum LayoutName {
    /// A bare board, from 0x0800_0000.
    Bare,
    /// Behind AMiRo's boot loader, from 0x0800_8000.
    Amiro,
}

impl ImageCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        if let Some(out) = &self.out {
            let inputs: Vec<_> = self.file.iter().map(PathBuf::as_path).collect();
            let beside = out.with_extension("srec");
            if beside == *out {
                return Err("--out names the binary; the S-records go beside it as .srec".into());
            }
            arguments::check_file("--out", out)?;
            arguments::check_file("--out", &beside)?;
            output::check(&[out.clone(), beside], &inputs)?;
        }
        let layout = match self.layout {
            LayoutName::Bare => Layout::Bare,
            LayoutName::Amiro => Layout::Amiro,
        };
        let path = match self.file {
            Some(path) => path,
            None => build_image(layout)?,
        };
        let image = sim_harness::device::Image::read(&path)?;
        let problems = image.problems(layout);
        let written = match &self.out {
            Some(out) if problems.is_empty() => Some(write(&image, layout, out)?),
            _ => None,
        };
        console::print_text(format_args!("{layout}: {image}"));
        for problem in &problems {
            console::print(format_args!("  {problem}"));
        }
        if !problems.is_empty() {
            return Ok(ExitStatus::Failed);
        }
        written.iter().for_each(console::print);
        Ok(ExitStatus::Good)
    }
}

/// Writes the bytes and the records; where they belong, in a line.
fn write(
    image: &sim_harness::device::Image,
    layout: Layout,
    out: &Path,
) -> Result<String, Box<dyn Error>> {
    let bytes = image.flashable(layout);
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    let records = to_s_records(&name, layout.start() as u32, &bytes);
    let beside = out.with_extension("srec");
    output::write(out, &bytes)?;
    output::write(&beside, records.as_bytes())?;
    Ok(format!(
        "{} bytes for {:#010x} in {} and {}",
        bytes.len(),
        layout.start(),
        out.display(),
        beside.display()
    ))
}
