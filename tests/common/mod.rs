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
use std::sync::OnceLock;

use sim_harness::device::{Board, Image, Layout, build_image};

/// Says in one line, past the test runner's capture, why a test did not run.
///
/// With `IPF_NO_SKIP` set, as in the check script, a skipped test fails instead.
pub(crate) fn skip(reason: &str) {
    assert!(
        std::env::var_os("IPF_NO_SKIP").is_none(),
        "a test was skipped that must run here: {reason}"
    );
    say_skipped(reason);
}

/// The line alone: for what depends on the user, not on the machine.
#[expect(clippy::disallowed_methods, reason = "past the test runner's capture")]
pub(crate) fn say_skipped(reason: &str) {
    // Nothing depends on the line being seen.
    let _ = writeln!(std::io::stderr(), "skipped: {reason}");
}

/// The folder of recorded drives: `IPF_DATA`, or `../shared/data` beside the project.
pub(crate) fn recordings() -> Option<PathBuf> {
    let folder = std::env::var_os("IPF_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data")),
        PathBuf::from,
    );
    folder.join("amiro").is_dir().then_some(folder)
}

/// Whether images can be built and run here; says in one line why not.
pub(crate) fn can_emulate() -> bool {
    if !Board::is_qemu_installed() {
        skip("no QEMU (qemu-system-arm)");
        return false;
    }
    if !is_target_installed() {
        skip("no standard library for thumbv7em-none-eabihf");
        return false;
    }
    true
}

/// The image, built once; `None`, said in one line, where it cannot be built or run.
pub(crate) fn image() -> Option<&'static Image> {
    static IMAGE: OnceLock<Option<Image>> = OnceLock::new();
    built_once(&IMAGE, Layout::Bare)
}

/// The image for AMiRo's boot loader, built once; `None` as for [`image`].
pub(crate) fn amiro_image() -> Option<&'static Image> {
    static IMAGE: OnceLock<Option<Image>> = OnceLock::new();
    built_once(&IMAGE, Layout::Amiro)
}

fn built_once(image: &'static OnceLock<Option<Image>>, layout: Layout) -> Option<&'static Image> {
    image
        .get_or_init(|| {
            if !can_emulate() {
                return None;
            }
            let path = build_image(layout).unwrap();
            Some(Image::read(&path).unwrap())
        })
        .as_ref()
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

/// Every Rust file below a folder of the project, or the file itself, with its text.
pub(crate) fn rust_files(place: &str) -> Vec<(PathBuf, String)> {
    let mut rest = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join(place)];
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
