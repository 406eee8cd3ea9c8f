//! Bytes that are written in order and read once from the front; large amounts go to the disk.

use std::io::{self, BufReader, BufWriter, Read, Seek, Write};

use amiro_ipf::link::{Message, MessageRef};
use amiro_ipf::node::Event;
use tempfile::SpooledTempFile;

/// Bytes up to which no file is made: 1 MiB.
const IN_MEMORY: usize = 1 << 20;
/// Most bytes of an event: more than any frame of the link has.
const MOST_EVENT: usize = 255;

/// Bytes that are written in order, then read once from the front.
///
/// More than a mebibyte goes to a temporary file without a name, which the system removes
/// when the program ends in any way. A failure to write is kept and reported by
/// [`read`](Self::read), so that a run need not check it at each event.
#[derive(Debug)]
pub struct Spool {
    file: BufWriter<SpooledTempFile>,
    failed: Option<io::Error>,
}

impl Default for Spool {
    fn default() -> Self {
        Self {
            file: BufWriter::with_capacity(1 << 16, SpooledTempFile::new(IN_MEMORY)),
            failed: None,
        }
    }
}

impl Spool {
    /// Adds bytes.
    pub fn write(&mut self, bytes: &[u8]) {
        if self.failed.is_none() {
            self.failed = self.file.write_all(bytes).err();
        }
    }

    /// The bytes from the front.
    ///
    /// # Errors
    /// They could not be written, or cannot be read.
    pub fn read(self) -> io::Result<SpoolReader> {
        let read = || -> io::Result<SpoolReader> {
            if let Some(error) = self.failed {
                return Err(error);
            }
            let file = self.file.into_inner();
            let mut file = file.map_err(io::IntoInnerError::into_error)?;
            file.rewind()?;
            Ok(BufReader::with_capacity(1 << 16, file))
        };
        read().map_err(|error| {
            io::Error::new(error.kind(), format!("a temporary file failed: {error}"))
        })
    }
}

/// The bytes of a [`Spool`] from the front.
pub type SpoolReader = BufReader<SpooledTempFile>;

/// Events of a node that are written in order, then read once from the first on.
#[derive(Debug, Default)]
pub struct EventSpool {
    spool: Spool,
}

impl EventSpool {
    /// Adds an event.
    pub fn push(&mut self, event: &Event) {
        let mut bytes = [0; 1 + MOST_EVENT];
        let (length, content) = bytes.split_at_mut(1);
        match postcard::to_slice(&MessageRef::from(event), content) {
            Ok(written) => {
                let used = 1 + written.len();
                // At most 255.
                length.fill(written.len() as u8);
                self.spool.write(bytes.get(..used).unwrap_or_default());
            }
            Err(error) => {
                self.spool.failed.get_or_insert(io::Error::other(error));
            }
        }
    }

    /// The events from the first on.
    ///
    /// # Errors
    /// They could not be written, or cannot be read.
    pub fn events(self) -> io::Result<SpooledEvents> {
        Ok(SpooledEvents {
            spool: self.spool.read()?,
            failed: None,
        })
    }
}

/// The events of an [`EventSpool`], in order.
///
/// They end early when they cannot be read; [`finish`](Self::finish) gives the error.
#[derive(Debug)]
#[must_use]
pub struct SpooledEvents {
    spool: SpoolReader,
    failed: Option<io::Error>,
}

impl SpooledEvents {
    /// Checks that all events could be read.
    ///
    /// # Errors
    /// What the system reports.
    pub fn finish(self) -> io::Result<()> {
        self.failed.map_or(Ok(()), Err)
    }

    fn read(&mut self) -> io::Result<Option<Event>> {
        let mut length = [0];
        if self.spool.read(&mut length)? == 0 {
            return Ok(None);
        }
        let mut bytes = [0; MOST_EVENT];
        let [length] = length;
        let message = bytes.get_mut(..usize::from(length)).unwrap_or_default();
        self.spool.read_exact(message)?;
        match postcard::from_bytes(message) {
            Ok(Message::Event(event)) => Ok(Some(event)),
            Ok(_) => Err(io::Error::other("no event")),
            Err(error) => Err(io::Error::other(error)),
        }
    }
}

impl Iterator for SpooledEvents {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        if self.failed.is_some() {
            return None;
        }
        self.read().unwrap_or_else(|error| {
            self.failed = Some(error);
            None
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_back_in_order_from_memory_and_from_the_disk() {
        for many in [0, 3, 200_000_u64] {
            let mut spool = EventSpool::default();
            (0..many).for_each(|stamp_us| spool.push(&Event::OdometryReset { stamp_us }));
            let mut events = spool.events().unwrap();
            for stamp_us in 0..many {
                assert_eq!(events.next(), Some(Event::OdometryReset { stamp_us }));
            }
            assert_eq!(events.next(), None);
            events.finish().unwrap();
        }
    }
}
