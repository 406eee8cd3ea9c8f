//! What is written in order and read once from the front, on the disk when there is much.

use std::fmt::Debug;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::marker::PhantomData;

use serde::Serialize;
use serde::de::DeserializeOwned;
use tempfile::SpooledTempFile;

/// Bytes up to which no file is made: 1 MiB.
const IN_MEMORY: usize = 1 << 20;
/// Most bytes of a record: as many as a frame of the link has at most, and room.
const MOST_RECORD: usize = 255;

/// Bytes that are written in order, then read once from the front.
///
/// More than a mebibyte goes to a temporary file without a name, which the system removes
/// whatever becomes of the program. A failure to write is kept and reported by
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

/// Records that are written in order, then read once from the first on.
///
/// A record has at most 255 bytes in postcard's format, as all events and inputs do.
#[derive(Debug)]
pub struct RecordSpool<T> {
    spool: Spool,
    record: PhantomData<T>,
}

impl<T> Default for RecordSpool<T> {
    fn default() -> Self {
        Self {
            spool: Spool::default(),
            record: PhantomData,
        }
    }
}

impl<T: Serialize + DeserializeOwned> RecordSpool<T> {
    /// Adds a record.
    pub fn push(&mut self, record: &T) {
        let mut bytes = [0; 1 + MOST_RECORD];
        let (length, content) = bytes.split_at_mut(1);
        match postcard::to_slice(record, content) {
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

    /// The records from the first on.
    ///
    /// # Errors
    /// They could not be written, or cannot be read.
    pub fn records(self) -> io::Result<Records<T>> {
        Ok(Records {
            spool: self.spool.read()?,
            failed: None,
            record: PhantomData,
        })
    }
}

/// The records of a [`RecordSpool`], in order.
///
/// They end early when they cannot be read; [`finish`](Self::finish) tells.
#[derive(Debug)]
#[must_use]
pub struct Records<T> {
    spool: SpoolReader,
    failed: Option<io::Error>,
    record: PhantomData<T>,
}

impl<T: DeserializeOwned> Records<T> {
    /// Checks that no record could not be read.
    ///
    /// # Errors
    /// What the system reports.
    pub fn finish(self) -> io::Result<()> {
        self.failed.map_or(Ok(()), Err)
    }

    fn read(&mut self) -> io::Result<Option<T>> {
        let mut length = [0];
        if self.spool.read(&mut length)? == 0 {
            return Ok(None);
        }
        let mut bytes = [0; MOST_RECORD];
        let [length] = length;
        let record = bytes.get_mut(..usize::from(length)).unwrap_or_default();
        self.spool.read_exact(record)?;
        postcard::from_bytes(record)
            .map(Some)
            .map_err(io::Error::other)
    }
}

impl<T: DeserializeOwned> Iterator for Records<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
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
    use amiro_ipf::event::Event;

    #[test]
    fn records_come_back_in_order_from_memory_and_from_the_disk() {
        for many in [0, 3, 200_000_u64] {
            let mut spool = RecordSpool::default();
            (0..many).for_each(|stamp_us| spool.push(&Event::BrokeOff { stamp_us }));
            let mut records = spool.records().unwrap();
            for stamp_us in 0..many {
                assert_eq!(records.next(), Some(Event::BrokeOff { stamp_us }));
            }
            assert_eq!(records.next(), None);
            records.finish().unwrap();
        }
    }
}
