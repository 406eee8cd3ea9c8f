//! The program of the image on a host, which prints the memory budget.

use std::process::Command;

#[cfg(unix)]
#[test]
fn the_memory_budget_is_printed_into_a_closed_pipe_without_a_panic() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut budget = Command::new(env!("CARGO_BIN_EXE_firmware"));
    let output = budget.stdout(writer).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
}
