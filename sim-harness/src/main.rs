//! `ipf`: the laboratory's program, run as `cargo ipf <command>`.

mod commands;

use std::process::ExitCode;

fn main() -> ExitCode {
    commands::main()
}
