//! The entries of a source of either format, one after another.

use std::io::Read;
use std::ops::ControlFlow;

use super::amiro_text::TextLines;
use super::rules::{Entry, Rules};
use super::source::ByteSource;
use super::stream::Frames;
use super::{Format, LogError, Problem, stream};

/// Reads a source from front to end; memory does not depend on its length.
#[derive(Debug)]
pub(super) struct Entries<R> {
    source: ByteSource<R>,
    rules: Rules,
    pieces: EntryReader,
    is_at_end: bool,
}

/// The reader of a format's entries.
#[derive(Debug)]
enum EntryReader {
    Text(TextLines),
    Stream(Frames),
}

impl<R: Read> Entries<R> {
    /// The entries of a source with the name that errors call it by; they may take so many
    /// bytes where they are collected.
    ///
    /// # Errors
    /// A source that cannot be read, is empty or in UTF-16.
    pub(super) fn new(name: &str, read: R, room: u64) -> Result<Self, LogError> {
        let source = ByteSource::new(name, read)?;
        let format = format_of(source.head()).map_err(|problem| source.error(None, problem))?;
        Ok(Self {
            source,
            rules: Rules::new(format, room),
            pieces: match format {
                Format::AmiroText => EntryReader::Text(TextLines::default()),
                Format::Stream => EntryReader::Stream(Frames::default()),
            },
            is_at_end: false,
        })
    }

    /// The next entry; `None` where the source or its run ends.
    ///
    /// # Errors
    /// A source that cannot be read, or that is no recording.
    pub(super) fn next(&mut self) -> Result<Option<Entry>, LogError> {
        loop {
            if let Some(entry) = self.rules.pop() {
                return Ok(Some(entry));
            }
            if self.is_at_end {
                return Ok(None);
            }
            let flow = match &mut self.pieces {
                EntryReader::Text(lines) => lines.read_one(&mut self.source, &mut self.rules)?,
                EntryReader::Stream(frames) => {
                    frames.read_one(&mut self.source, &mut self.rules)?
                }
            };
            if flow == ControlFlow::Break(()) {
                self.is_at_end = true;
                if let EntryReader::Stream(frames) = &mut self.pieces {
                    frames.finish(&mut self.rules);
                }
            }
        }
    }

    /// The state of the rules.
    pub(super) fn rules(&self) -> &Rules {
        &self.rules
    }

    /// The same, at the end of reading.
    pub(super) fn into_rules(self) -> Rules {
        self.rules
    }

    /// The first 4 KiB, or all there is.
    pub(super) fn head(&self) -> &[u8] {
        self.source.head()
    }

    /// The error that `problem` is in this source.
    pub(super) fn error(&self, problem: Problem) -> LogError {
        self.source.error(None, problem)
    }
}

/// Detects the format from the first bytes: a source that is no stream must be text.
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
    fn utf16_is_recognised_with_and_without_its_mark() {
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
