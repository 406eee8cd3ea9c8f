//! Writes the linker's flash region and the build id.
//!
//! `memory.x` in the root holds the RAM and includes `flash.x`, which exists only in
//! the build's own folder: the linker would otherwise find the root's file first and
//! every layout would silently be the same.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

use crc::{CRC_64_XZ, Crc};

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

/// What the flash image is made of: files, and folders with all that is in them.
const FILES: [&str; 6] = [
    "build.rs",
    "Cargo.toml",
    "Cargo.lock",
    "memory.x",
    "drivers/pca9544a/Cargo.toml",
    "drivers/vcnl4020/Cargo.toml",
];
const FOLDERS: [&str; 3] = ["src", "drivers/pca9544a/src", "drivers/vcnl4020/src"];

#[expect(
    clippy::disallowed_macros,
    reason = "how a build script reports to cargo"
)]
fn main() -> io::Result<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let amiro = env::var_os("CARGO_FEATURE_AMIRO_LAYOUT").is_some();
    fs::write(out.join("flash.x"), if amiro { AMIRO } else { BARE })?;
    fs::write(
        out.join("layout.x"),
        if amiro { AMIRO_SECTIONS } else { "" },
    )?;
    println!("cargo::rustc-link-search={}", out.display());

    for source in sources(Path::new(""))? {
        println!("cargo::rerun-if-changed={}", source.display());
    }
    for folder in FOLDERS {
        println!("cargo::rerun-if-changed={folder}");
    }
    println!(
        "cargo::rustc-env=AMIRO_IPF_BUILD_ID={:016x}",
        build_id(Path::new(""))?
    );
    Ok(())
}

/// A hash of everything below a root that the flash image is made of: the same for
/// every checkout, whatever its line ends and the separators of its paths.
pub(crate) fn build_id(root: &Path) -> io::Result<u64> {
    let mut texts = sources(root)?
        .into_iter()
        .map(|source| {
            let text = fs::read(root.join(&source))?;
            Ok((name(&source), with_line_feeds(&text)))
        })
        .collect::<io::Result<Vec<_>>>()?;
    texts.sort_unstable();
    let crc = Crc::<u64>::new(&CRC_64_XZ);
    let mut digest = crc.digest();
    for (name, text) in texts {
        digest.update(name.as_bytes());
        digest.update(&[0]);
        digest.update(&(text.len() as u64).to_le_bytes());
        digest.update(&text);
    }
    Ok(digest.finalize())
}

/// Paths from the root of everything that the flash image is made of.
fn sources(root: &Path) -> io::Result<Vec<PathBuf>> {
    let mut sources: Vec<PathBuf> = FILES.map(PathBuf::from).into();
    for folder in FOLDERS {
        collect(root, Path::new(folder), &mut sources)?;
    }
    Ok(sources)
}

/// A path with `/` between its parts.
fn name(path: &Path) -> String {
    let parts: Vec<_> = path
        .components()
        .map(|part| part.as_os_str().to_string_lossy())
        .collect();
    parts.join("/")
}

/// A text with a line feed alone at the end of each line.
fn with_line_feeds(text: &[u8]) -> Vec<u8> {
    let next = text.iter().skip(1).map(Some).chain([None]);
    text.iter()
        .zip(next)
        .filter(|pair| *pair != (&b'\r', Some(&b'\n')))
        .map(|(byte, _)| *byte)
        .collect()
}

fn collect(root: &Path, folder: &Path, sources: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(root.join(folder))? {
        let path = folder.join(entry?.file_name());
        if root.join(&path).is_dir() {
            collect(root, &path, sources)?;
        } else {
            sources.push(path);
        }
    }
    Ok(())
}
