//! What the test programs of the harness share, besides what those of the core share too.

#![allow(
    dead_code,
    unused_imports,
    clippy::allow_attributes,
    reason = "not every test program uses all of it"
)]

#[path = "../../../tests/common/mod.rs"]
mod shared;

use std::path::PathBuf;
use std::sync::OnceLock;

pub(crate) use shared::{can_emulate, report_skipped, root, rust_files, skip};
use sim_harness::device::{Image, Layout, build_image};
use tempfile::TempDir;

/// The folder of recorded drives: `IPF_DATA`, or `../shared/data` beside the project.
pub(crate) fn recordings() -> Option<PathBuf> {
    let folder =
        std::env::var_os("IPF_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    folder.join("amiro").is_dir().then_some(folder)
}

/// A folder of its own for a test, removed when it is dropped.
pub(crate) fn own_folder(name: &str) -> TempDir {
    let prefix = format!("ipf-{name}-");
    tempfile::Builder::new().prefix(&prefix).tempdir().unwrap()
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
