//! Writes the seeds of every target into its corpus: `cargo run --bin seeds` from here.

use std::path::Path;

use amiro_ipf_fuzz::seeds::{TARGETS, of};

fn main() -> std::io::Result<()> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for target in TARGETS {
        let folder = corpus.join(target);
        std::fs::create_dir_all(&folder)?;
        for (number, bytes) in of(target).iter().enumerate() {
            std::fs::write(folder.join(format!("seed-{number:02}")), bytes)?;
        }
    }
    Ok(())
}
