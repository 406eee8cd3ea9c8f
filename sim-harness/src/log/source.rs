//! Bytes of a source in pieces of bounded length, with their places.

use std::io::{BufRead, BufReader, Chain, Cursor, ErrorKind, Read};

use super::{LogError, Place, Problem};

/// Bytes that are read to detect the format.
const HEAD: u64 = 4096;
/// Bytes after which a source that showed neither header nor frame is given up.
const PATIENCE: u64 = 1 << 20;

/// A source of bytes, read once from front to end.
#[derive(Debug)]
pub(super) struct ByteSource<R> {
    name: String,
    head: Vec<u8>,
    reader: BufReader<Chain<Cursor<Vec<u8>>, R>>,
    offset: u64,
    trusted: bool,
}

/// A piece of a source, up to a delimiter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    /// Offset of its first byte.
    pub(super) start: u64,
    /// Whether the delimiter was there; otherwise the source ended.
    pub(super) is_ended: bool,
    /// Whether bytes beyond the cap were skipped.
    pub(super) is_too_long: bool,
}

impl<R: Read> ByteSource<R> {
    /// A source with the name that errors call it by; reads its first 4 KiB.
    pub(super) fn new(name: &str, mut read: R) -> Result<Self, LogError> {
        let mut head = Vec::new();
        read.by_ref()
            .take(HEAD)
            .read_to_end(&mut head)
            .map_err(|error| LogError::new(name, None, Problem::Unreadable(error)))?;
        Ok(Self {
            name: name.to_owned(),
            reader: BufReader::with_capacity(1 << 16, Cursor::new(head.clone()).chain(read)),
            head,
            offset: 0,
            trusted: false,
        })
    }

    /// The first 4 KiB, or all there is.
    pub(super) fn head(&self) -> &[u8] {
        &self.head
    }

    /// Marks the format as recognised: from now on the source may be of any length.
    pub(super) fn trust(&mut self) {
        self.trusted = true;
    }

    /// The error that `problem` is in this source.
    pub(super) fn error(&self, place: Option<Place>, problem: Problem) -> LogError {
        LogError::new(&self.name, place, problem)
    }

    /// Reads to the next delimiter or the end; holds at most `cap` bytes, skips the rest.
    ///
    /// `None` at the end of the source.
    ///
    /// # Errors
    /// [`Problem::Unreadable`] with the system's error, [`Problem::Shapeless`] beyond the
    /// first MiB of a source without a recognised format.
    pub(super) fn read_piece(
        &mut self,
        delimiter: u8,
        cap: usize,
        bytes: &mut Vec<u8>,
    ) -> Result<Option<Piece>, LogError> {
        bytes.clear();
        let mut piece = Piece {
            start: self.offset,
            is_ended: false,
            is_too_long: false,
        };
        while !piece.is_ended {
            let chunk = self.fill()?;
            if chunk.is_empty() {
                break;
            }
            let end = chunk.iter().position(|byte| *byte == delimiter);
            let taken = chunk.get(..end.unwrap_or(chunk.len())).unwrap_or(chunk);
            let kept = taken.len().min(cap - bytes.len());
            bytes.extend_from_slice(taken.get(..kept).unwrap_or_default());
            piece.is_ended = end.is_some();
            piece.is_too_long |= kept < taken.len();
            let used = taken.len() + usize::from(piece.is_ended);
            self.reader.consume(used);
            self.offset += used as u64;
        }
        Ok((self.offset > piece.start).then_some(piece))
    }

    /// Bytes that are there to be consumed; none at the end of the source.
    fn fill(&mut self) -> Result<&[u8], LogError> {
        if self.offset > PATIENCE && !self.trusted {
            return Err(self.error(None, Problem::Shapeless));
        }
        loop {
            match self.reader.fill_buf() {
                Ok(_) => return Ok(self.reader.buffer()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    let place = Some(Place::Byte(self.offset));
                    return Err(self.error(place, Problem::Unreadable(error)));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives a byte at a time and is interrupted before each.
    struct Dribble<'a> {
        bytes: &'a [u8],
        interrupted: bool,
    }

    impl Read for Dribble<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            self.interrupted = !self.interrupted;
            if self.interrupted {
                return Err(ErrorKind::Interrupted.into());
            }
            let one = buffer.len().min(1);
            self.bytes.read(&mut buffer[..one])
        }
    }

    fn pieces(bytes: &[u8], cap: usize) -> Vec<(u64, Vec<u8>, bool, bool)> {
        let dribble = Dribble {
            bytes,
            interrupted: false,
        };
        let mut source = ByteSource::new("dribble", dribble).unwrap();
        let mut held = Vec::new();
        let mut pieces = Vec::new();
        while let Some(piece) = source.read_piece(b'\n', cap, &mut held).unwrap() {
            let Piece {
                start,
                is_ended,
                is_too_long,
            } = piece;
            pieces.push((start, held.clone(), is_ended, is_too_long));
        }
        pieces
    }

    #[test]
    fn pieces_are_cut_at_delimiters_and_at_the_cap() {
        assert_eq!(
            pieces(b"ab\n\n12345\nx", 3),
            [
                (0, b"ab".to_vec(), true, false),
                (3, b"".to_vec(), true, false),
                (4, b"123".to_vec(), true, true),
                (10, b"x".to_vec(), false, false),
            ]
        );
        assert_eq!(pieces(b"abc\n", 3), [(0, b"abc".to_vec(), true, false)]);
        assert_eq!(pieces(b"", 3), []);
    }

    #[test]
    fn endless_source_is_given_up_after_a_mebibyte_unless_trusted() {
        let mut held = Vec::new();
        let mut source = ByteSource::new("endless", std::io::repeat(b'x')).unwrap();
        let error = source.read_piece(b'\n', 10, &mut held).unwrap_err();
        assert!(matches!(error.problem(), Problem::Shapeless), "{error}");
        assert_eq!(held.len(), 10);
        let long = std::io::repeat(b'x').take(3 << 20);
        let mut source = ByteSource::new("long", long).unwrap();
        source.trust();
        let piece = source.read_piece(b'\n', 10, &mut held).unwrap().unwrap();
        assert!(piece.is_too_long && !piece.is_ended);
    }
}
