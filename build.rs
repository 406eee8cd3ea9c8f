//! Writes the linker's flash region and the build id.
//!
//! `memory.x` in the root holds the RAM and includes `flash.x`, which exists only in
//! the build's own folder: the linker would otherwise find the root's file first and
//! every layout would silently be the same.

use std::collections::hash_map::DefaultHasher;
use std::hash::Hasher;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// A bare board: the image starts where the core does.
const BARE: &str = "\
FLASH : ORIGIN = 0x08000000, LENGTH = 1024K
";

/// Behind AMiRo's boot loader, which owns the first 32 KiB.
const AMIRO: &str = "\
FLASH : ORIGIN = 0x08008000, LENGTH = 1024K - 32K
";

/// The boot loader writes a checksum over the vectors to 0x1ac after flashing, which
/// is inside the code of an ordinary image: code starts at 0x200 instead. Until then
/// the word holds AMiRo's placeholder.
const AMIRO_SECTIONS: &str = "
_stext = ORIGIN(FLASH) + 0x200;
SECTIONS
{
  .boot_checksum ORIGIN(FLASH) + 0x1ac :
  {
    LONG(0x55AA11EE)
  } > FLASH
} INSERT AFTER .vector_table;
";

fn main() -> io::Result<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let amiro = env::var_os("CARGO_FEATURE_AMIRO_LAYOUT").is_some();
    fs::write(out.join("flash.x"), if amiro { AMIRO } else { BARE })?;
    fs::write(
        out.join("layout.x"),
        if amiro { AMIRO_SECTIONS } else { "" },
    )?;
    println!("cargo::rustc-link-search={}", out.display());

    let mut sources = vec![
        PathBuf::from("build.rs"),
        PathBuf::from("Cargo.toml"),
        PathBuf::from("Cargo.lock"),
        PathBuf::from("memory.x"),
    ];
    collect(Path::new("src"), &mut sources)?;
    collect(Path::new("drivers"), &mut sources)?;
    sources.sort();
    let mut hasher = DefaultHasher::new();
    for source in &sources {
        println!("cargo::rerun-if-changed={}", source.display());
        hasher.write(source.to_string_lossy().as_bytes());
        hasher.write(&fs::read(source).unwrap_or_default());
    }
    println!("cargo::rerun-if-changed=src");
    println!(
        "cargo::rustc-env=AMIRO_IPF_BUILD_ID={:016x}",
        hasher.finish()
    );
    Ok(())
}

fn collect(folder: &Path, sources: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, sources)?;
        } else {
            sources.push(path);
        }
    }
    Ok(())
}
