//! `ipf`: the laboratory's program, run as `cargo ipf <command>`.

mod cli;

use std::process::ExitCode;

use peak_alloc::PeakAlloc;

/// `map` reports the memory that each method takes.
#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

fn main() -> ExitCode {
    cli::main()
}
