//! Files of bounded length.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads a whole file of any kind, up to a number of bytes.
///
/// # Errors
/// The system's, or that there are more bytes.
pub(crate) fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // One byte more than is allowed: enough for the refusal.
    File::open(path)?
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::other(format!("more than {most} bytes")));
    }
    Ok(bytes)
}
