//! The door: a path or bytes in, a recording out.

use std::fs::File;
use std::io::{Read, stdin};
use std::path::Path;

use super::source::Source;
use super::{Format, LogError, Problem, Recording, amiro_text, plausibility, stream};

/// Reads a recording of either format from a file; `-` is standard input.
///
/// A pipe is waited for until its other end opens and closes it.
///
/// # Errors
/// A source that cannot be read, is no recording, has nothing usable, or whose numbers
/// cannot be in the units that they claim.
pub fn read(path: &Path) -> Result<Recording, LogError> {
    if path.as_os_str() == "-" {
        return read_named("standard input", stdin().lock());
    }
    let name = path.to_string_lossy();
    match File::open(path) {
        Ok(file) => read_named(&name, file),
        Err(error) => Err(LogError::new(&name, None, Problem::Unreadable(error))),
    }
}

/// Reads a recording of either format from anything that gives bytes.
///
/// # Errors
/// As [`read`].
pub fn read_from(read: impl Read) -> Result<Recording, LogError> {
    read_named("recording", read)
}

fn read_named(name: &str, read: impl Read) -> Result<Recording, LogError> {
    let mut source = Source::new(name, read)?;
    let format = format_of(source.head()).map_err(|problem| source.error(None, problem))?;
    let recording = match format {
        Format::AmiroText => amiro_text::read(&mut source)?,
        Format::Stream => stream::read(&mut source)?,
    };
    let doubt = match format {
        Format::AmiroText if recording.inputs.is_empty() => amiro_text::doubt(source.head()),
        _ => plausibility::doubt(&recording),
    };
    if let Some(found) = doubt {
        return Err(source.error(None, Problem::ImplausibleUnits { found }));
    }
    if recording.inputs.is_empty() && recording.messages.is_empty() {
        return Err(source.error(None, Problem::NothingUsable(recording.refusals)));
    }
    Ok(recording)
}

/// Tells the format by the first bytes: what is no stream must be text.
fn format_of(head: &[u8]) -> Result<Format, Problem> {
    if head.is_empty() {
        return Err(Problem::Empty);
    }
    if is_utf16(head) {
        return Err(Problem::Utf16);
    }
    if stream::is_stream(head) {
        return Ok(Format::Stream);
    }
    Ok(Format::AmiroText)
}

/// Whether text begins with UTF-16's byte order mark, or with four of its characters.
fn is_utf16(head: &[u8]) -> bool {
    if head.starts_with(&[0xFF, 0xFE]) || head.starts_with(&[0xFE, 0xFF]) {
        return true;
    }
    let Some(first) = head.first_chunk::<8>() else {
        return false;
    };
    let is_text = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let (pairs, _) = first.as_chunks::<2>();
    pairs.iter().all(|[low, high]| is_text(*low) && *high == 0)
        || pairs.iter().all(|[high, low]| is_text(*low) && *high == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf16_is_told_with_and_without_its_mark() {
        for text in [
            &b"\xFF\xFEP"[..],
            b"\xFE\xFF\0P",
            b"P\0R\0V\0 \0",
            b"\0P\0R\0V\0 ",
        ] {
            assert!(is_utf16(text), "{text:?}");
        }
        for other in [&b"PRV 0\tPRV 1"[..], b"\0\0\0\0\0\0\0\0", b"P\0R\0", b""] {
            assert!(!is_utf16(other), "{other:?}");
        }
    }
}
