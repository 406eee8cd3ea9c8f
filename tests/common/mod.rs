//! What several test programs share.

#![allow(
    dead_code,
    clippy::allow_attributes,
    reason = "not every test program uses all of it"
)]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Says in one line, past the test runner's capture, why a test did not run.
///
/// With `IPF_NO_SKIP` set, as in the check script, a skipped test fails instead.
pub(crate) fn skip(reason: &str) {
    assert!(
        std::env::var_os("IPF_NO_SKIP").is_none(),
        "a test was skipped that must run here: {reason}"
    );
    report_skipped(reason);
}

/// The line alone: for what depends on the user, not on the machine.
#[expect(clippy::disallowed_methods, reason = "past the test runner's capture")]
pub(crate) fn report_skipped(reason: &str) {
    // Nothing depends on the line being seen.
    let _ = writeln!(std::io::stderr(), "skipped: {reason}");
}

/// Whether images can be built and run here; says in one line why not.
pub(crate) fn can_emulate() -> bool {
    let qemu = Command::new("qemu-system-arm").arg("--version").output();
    if qemu.is_err() {
        skip("no QEMU (qemu-system-arm)");
        return false;
    }
    if !is_target_installed() {
        skip("no standard library for thumbv7em-none-eabihf");
        return false;
    }
    true
}

fn is_target_installed() -> bool {
    Command::new("rustc")
        .args([
            "--print",
            "target-libdir",
            "--target",
            "thumbv7em-none-eabihf",
        ])
        .output()
        .is_ok_and(|output| {
            let folder = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            std::path::Path::new(&folder).is_dir()
        })
}

/// The folder of the workspace, from the tests of any of its packages.
pub(crate) fn root() -> &'static Path {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    folders
        .find(|folder| folder.join("Cargo.lock").is_file())
        .unwrap()
}

/// Every Rust file below a folder of the project, or the file itself, with its text.
pub(crate) fn rust_files(place: &str) -> Vec<(PathBuf, String)> {
    let mut rest = vec![root().join(place)];
    let mut files = Vec::new();
    while let Some(path) = rest.pop() {
        if path.is_dir() {
            let entries = fs::read_dir(&path).unwrap();
            rest.extend(entries.map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            files.push((path, text));
        }
    }
    assert!(!files.is_empty(), "nothing is at {place}");
    files
}
