//! `ipf`: the laboratory's program, run as `cargo ipf <command>`.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
