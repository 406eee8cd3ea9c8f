//! The build id is a hash of the sources, not of the checkout.

use std::path::{Path, PathBuf};
use std::{fs, io};

#[path = "../../build.rs"]
#[expect(dead_code, reason = "only the hash is tested")]
mod build_script;

use build_script::build_id;

/// A tree like the project's, in a folder of its own; removed when dropped.
struct Tree(PathBuf);

impl Tree {
    fn new(name: &str, line_end: &str) -> io::Result<Self> {
        let folder = format!("ipf-build-id-{name}-{}", std::process::id());
        let root = std::env::temp_dir().join(folder);
        for folder in ["src/deep", "drivers/pca9544a/src", "drivers/vcnl4020/src"] {
            fs::create_dir_all(root.join(folder))?;
        }
        for (file, text) in [
            ("build.rs", "fn main() {\n}\n"),
            ("Cargo.toml", "[package]\n"),
            ("Cargo.lock", "\n\nversion = 4\n"),
            ("memory.x", "MEMORY\n{\n}"),
            ("src/lib.rs", "mod deep;\n\n"),
            ("src/deep/mod.rs", "//! A lone \r stays.\n"),
            ("src/deep.txt", ""),
            ("drivers/pca9544a/Cargo.toml", "[package]\n"),
            ("drivers/pca9544a/src/lib.rs", "//! A multiplexer.\n"),
            ("drivers/vcnl4020/Cargo.toml", "[package]\n"),
            ("drivers/vcnl4020/src/lib.rs", "//! A sensor.\n"),
        ] {
            fs::write(root.join(file), text.replace('\n', line_end))?;
        }
        Ok(Self(root))
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        // Nothing depends on its being gone.
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn line_ends_of_the_checkout_do_not_change_the_build_id() {
    let unix = Tree::new("lf", "\n").unwrap();
    let windows = Tree::new("crlf", "\r\n").unwrap();
    let id = build_id(&unix.0).unwrap();
    assert_eq!(build_id(&windows.0).unwrap(), id);
    // Pinned: neither the order of the folder nor the separators of paths are in it.
    assert_eq!(id, 0x576e_15da_7b90_b150, "{id:#x}");
}

#[test]
fn every_other_change_of_a_source_changes_the_build_id() {
    let tree = Tree::new("changed", "\n").unwrap();
    let id = build_id(&tree.0).unwrap();
    let changed = |file: &str, text: &str| {
        let path = tree.0.join(file);
        let before = fs::read(&path).unwrap();
        fs::write(&path, text).unwrap();
        let changed = build_id(&tree.0).unwrap();
        fs::write(&path, before).unwrap();
        changed
    };
    for (file, text) in [
        ("src/lib.rs", "mod deep;\n"),
        ("src/lib.rs", "mod deep;\r\n\r"),
        ("src/deep/mod.rs", "//! A lone  stays.\n"),
        ("Cargo.lock", "\nversion = 4\n"),
        ("memory.x", ""),
        ("drivers/pca9544a/Cargo.toml", ""),
        ("drivers/vcnl4020/src/lib.rs", ""),
    ] {
        assert_ne!(changed(file, text), id, "{file}: {text:?}");
    }
    fs::rename(tree.0.join("src/deep.txt"), tree.0.join("src/deeq.txt")).unwrap();
    assert_ne!(build_id(&tree.0).unwrap(), id, "a file has another name");
}

#[test]
fn the_build_id_is_that_of_the_sources_here() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_eq!(build_id(root).unwrap(), amiro_ipf::BUILD_ID);
}

#[test]
fn a_source_that_cannot_be_read_has_no_build_id() {
    let tree = Tree::new("missing", "\n").unwrap();
    fs::remove_file(tree.0.join("memory.x")).unwrap();
    assert!(build_id(&tree.0).is_err());
}
