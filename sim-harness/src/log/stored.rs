//! A recording that stays on the disk: an overview in memory, its rows read as a stream.

use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, Write, stdin};
use std::path::Path;
use std::time::SystemTime;

use amiro_ipf::geometry::Pose;
use amiro_ipf::link::Message;
use amiro_ipf::node::Input;

use super::entries::Entries;
use super::overview::{Overview, Uses, inspect};
use super::rules::Entry;
use super::{LogError, Problem};

/// A recording of any length, in bounded memory.
///
/// Opening it reads it once, from front to end, which decides the entries that are used; each
/// kind of rows is then read in a pass of its own. A file that changes in between is an
/// error. Standard input and pipes, which can be read only once, are copied to a temporary
/// file without a name while they are read first.
#[derive(Debug)]
pub struct StoredRecording {
    name: String,
    file: File,
    stamp: Stamp,
    overview: Overview,
    uses: Uses,
}

/// The metadata that a write to a file changes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        Self {
            length: metadata.len(),
            modified: metadata.modified().ok(),
        }
    }
}

impl StoredRecording {
    /// Reads a recording of either format through once; `-` is standard input.
    ///
    /// A pipe is waited for until its other end opens and closes it. `on_bytes` gets the
    /// bytes read so far and, where it is known, the length.
    ///
    /// # Errors
    /// As [`read`](super::read), and a file that changes meanwhile.
    pub fn open(path: &Path, mut on_bytes: impl FnMut(u64, Option<u64>)) -> Result<Self, LogError> {
        if path.as_os_str() == "-" {
            return Self::copied("standard input", stdin().lock(), on_bytes);
        }
        let name = path.to_string_lossy();
        let unreadable = |error| LogError::new(&name, None, Problem::Unreadable(error));
        let file = File::open(path).map_err(unreadable)?;
        let metadata = file.metadata().map_err(unreadable)?;
        // Files of the system, such as those of /proc, have a length of 0 and content.
        if !metadata.is_file() || metadata.len() == 0 {
            return Self::copied(&name, file, on_bytes);
        }
        let stamp = Stamp::of(&metadata);
        let read = Watched::new(&file, |bytes| on_bytes(bytes, Some(stamp.length)));
        let entries = Entries::new(&name, read, u64::MAX)?;
        let (overview, uses) = inspect(entries, drop)?;
        let stored = Self {
            name: name.into_owned(),
            file,
            stamp,
            overview,
            uses,
        };
        stored.check_unchanged()?;
        Ok(stored)
    }

    /// Reads a source that can be read once, and keeps a copy of what it read.
    fn copied(
        name: &str,
        read: impl Read,
        mut on_bytes: impl FnMut(u64, Option<u64>),
    ) -> Result<Self, LogError> {
        let unreadable = |error| LogError::new(name, None, Problem::Unreadable(error));
        let file = tempfile::tempfile().map_err(unreadable)?;
        let copying = Copying { read, copy: &file };
        let read = Watched::new(copying, |bytes| on_bytes(bytes, None));
        let (overview, uses) = inspect(Entries::new(name, read, u64::MAX)?, drop)?;
        let metadata = file.metadata().map_err(unreadable)?;
        Ok(Self {
            name: name.to_owned(),
            stamp: Stamp::of(&metadata),
            file,
            overview,
            uses,
        })
    }

    /// Everything but the rows.
    #[must_use]
    pub fn overview(&self) -> &Overview {
        &self.overview
    }

    /// Length of the source, bytes.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.stamp.length
    }

    /// The inputs, in the order of the source; `on_bytes` gets the bytes read so far.
    ///
    /// # Errors
    /// The file cannot be read again.
    pub fn inputs<'a>(
        &'a mut self,
        on_bytes: impl FnMut(u64) + 'a,
    ) -> Result<Rows<'a, Input>, LogError> {
        let count = self.overview.inputs;
        self.rows(on_bytes, count, |entry| match entry {
            Entry::Input(_, input) => Some(input),
            _ => None,
        })
    }

    /// The board's messages, in the order of the source.
    ///
    /// # Errors
    /// The file cannot be read again.
    pub fn messages<'a>(
        &'a mut self,
        on_bytes: impl FnMut(u64) + 'a,
    ) -> Result<Rows<'a, Message>, LogError> {
        let count = self.overview.messages;
        self.rows(on_bytes, count, |entry| match entry {
            Entry::Message(message) => Some(message),
            _ => None,
        })
    }

    /// The true poses: stamps in microseconds, never decreasing.
    ///
    /// # Errors
    /// The file cannot be read again.
    pub fn true_poses(&mut self) -> Result<Rows<'_, (u64, Pose)>, LogError> {
        let (ignore, count) = (|_: u64| (), self.overview.true_poses);
        self.rows(ignore, count, |entry| match entry {
            Entry::TruePose(stamp_us, pose) => Some((stamp_us, pose)),
            _ => None,
        })
    }

    // The passes share the file's position: `&mut` keeps them apart.
    fn rows<'a, T>(
        &'a mut self,
        on_bytes: impl FnMut(u64) + 'a,
        count: u64,
        pick: fn(Entry) -> Option<T>,
    ) -> Result<Rows<'a, T>, LogError> {
        self.check_unchanged()?;
        let mut file = &self.file;
        file.rewind().map_err(|error| self.unreadable(error))?;
        let read = Watched::new(&self.file, Box::new(on_bytes) as OnBytes<'a>);
        Ok(Rows {
            entries: Entries::new(&self.name, read, u64::MAX)?,
            recording: self,
            pick,
            number: 0,
            left: count,
            failed: None,
        })
    }

    fn check_unchanged(&self) -> Result<(), LogError> {
        let found = self.file.metadata();
        let found = found.map_err(|error| self.unreadable(error))?;
        if Stamp::of(&found) == self.stamp {
            return Ok(());
        }
        Err(LogError::new(&self.name, None, Problem::Changed))
    }

    fn unreadable(&self, error: io::Error) -> LogError {
        LogError::new(&self.name, None, Problem::Unreadable(error))
    }
}

type OnBytes<'a> = Box<dyn FnMut(u64) + 'a>;

/// The rows of one kind, in the order of the source.
///
/// They end early when the source fails; [`finish`](Self::finish) returns the error.
#[must_use]
pub struct Rows<'a, T> {
    recording: &'a StoredRecording,
    entries: Entries<Watched<&'a File, OnBytes<'a>>>,
    pick: fn(Entry) -> Option<T>,
    /// Number of the next entry.
    number: u64,
    /// Rows that are still to come: after the last of them nothing is read.
    left: u64,
    failed: Option<LogError>,
}

impl<T> Rows<'_, T> {
    /// Checks that the rows that were read are all there are up to here.
    ///
    /// # Errors
    /// The source could not be read, or has changed since it was opened.
    pub fn finish(self) -> Result<(), LogError> {
        match self.failed {
            Some(error) => Err(error),
            None => self.recording.check_unchanged(),
        }
    }
}

impl<T> Iterator for Rows<'_, T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        while self.left > 0 && self.failed.is_none() {
            let entry = match self.entries.next() {
                Ok(entry) => entry?,
                Err(error) => {
                    self.failed = Some(error);
                    return None;
                }
            };
            let is_used = self.recording.uses.keep(self.number, &entry);
            self.number += 1;
            if is_used && let Some(row) = (self.pick)(entry) {
                self.left -= 1;
                return Some(row);
            }
        }
        None
    }
}

/// Bytes whose number is reported as they are read.
#[derive(Debug)]
struct Watched<R, F> {
    read: R,
    bytes: u64,
    on_bytes: F,
}

impl<R, F: FnMut(u64)> Watched<R, F> {
    fn new(read: R, on_bytes: F) -> Self {
        Self {
            read,
            bytes: 0,
            on_bytes,
        }
    }
}

impl<R: Read, F: FnMut(u64)> Read for Watched<R, F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.read.read(buffer)?;
        self.bytes += length as u64;
        (self.on_bytes)(self.bytes);
        Ok(length)
    }
}

/// Bytes that are written to another place as they are read.
#[derive(Debug)]
struct Copying<R, W> {
    read: R,
    copy: W,
}

impl<R: Read, W: Write> Read for Copying<R, W> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.read.read(buffer)?;
        self.copy
            .write_all(buffer.get(..length).unwrap_or_default())
            .map_err(|error| {
                let text = format!("its copy in a temporary file: {error}");
                io::Error::new(error.kind(), text)
            })?;
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{RecordingWriter, read_from};
    use amiro_ipf::link::{Encoder, Message, TruthMessage};
    use amiro_ipf::node::{Config, Event};

    /// A recording of every kind of row, part of it of the run before: with the board's
    /// inputs and events before it takes the configuration.
    fn recording() -> Vec<u8> {
        let config = Config::default();
        let tick = |stamp_us| Input::Tick { stamp_us };
        let pose = Pose::default();
        let mut bytes = Vec::new();
        let mut writer = RecordingWriter::new(&mut bytes).unwrap();
        let truth = |stamp_us| TruthMessage::Pose { stamp_us, pose };
        writer.write_truth(&truth(3)).unwrap();
        writer.write_input(&tick(1)).unwrap();
        writer.write_input(&Input::Configure(config)).unwrap();
        writer.write_input(&tick(5)).unwrap();
        let mut board = Encoder::new(7);
        for message in [
            Message::Input(tick(90)),
            Message::Boot(crate::device::boot_on_host(800)),
            Message::Event(Event::OdometryReset { stamp_us: 1 }),
            Message::Event(Event::Configured(config)),
            Message::Input(tick(10)),
            Message::Event(Event::OdometryReset { stamp_us: 2 }),
        ] {
            writer.write_frames(board.encode(&message)).unwrap();
        }
        writer.write_truth(&truth(8)).unwrap();
        bytes
    }

    fn rows_of(stored: &mut StoredRecording) -> (Vec<Input>, Vec<Message>, Vec<(u64, Pose)>) {
        let mut inputs = stored.inputs(|_| ()).unwrap();
        let inputs = (inputs.by_ref().collect(), inputs.finish().unwrap()).0;
        let mut messages = stored.messages(|_| ()).unwrap();
        let messages = (messages.by_ref().collect(), messages.finish().unwrap()).0;
        (inputs, messages, stored.true_poses().unwrap().collect())
    }

    #[test]
    fn rows_of_a_file_and_of_a_pipe_are_those_of_the_whole_recording() {
        let bytes = recording();
        let whole = read_from(bytes.as_slice()).unwrap();
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(&file, &bytes).unwrap();
        let mut read = 0;
        let of_file = StoredRecording::open(file.path(), |bytes, _| read = bytes).unwrap();
        let of_pipe = StoredRecording::copied("pipe", bytes.as_slice(), |_, _| ()).unwrap();
        assert_eq!(read, bytes.len() as u64);
        for mut stored in [of_file, of_pipe] {
            let (inputs, messages, poses) = rows_of(&mut stored);
            assert_eq!((inputs.len(), messages.len(), poses.len()), (2, 3, 2));
            assert_eq!((&inputs, &messages), (&whole.inputs, &whole.messages));
            assert_eq!(poses, whole.truth.as_ref().unwrap().poses);
            let overview = stored.overview();
            assert_eq!((overview.inputs, overview.messages), (2, 3));
            assert_eq!(overview.true_poses, 2);
            assert_eq!(overview.refusals, whole.refusals);
            assert_eq!(overview.segments, whole.segments);
            assert_eq!(stored.length(), bytes.len() as u64);
        }
    }

    #[test]
    fn a_file_that_changes_between_two_passes_is_an_error() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(&file, recording()).unwrap();
        let mut stored = StoredRecording::open(file.path(), |_, _| ()).unwrap();
        let mut inputs = stored.inputs(|_| ()).unwrap();
        assert_eq!(inputs.by_ref().count(), 2);
        std::fs::write(&file, [recording(), vec![0]].concat()).unwrap();
        let error = inputs.finish().unwrap_err();
        assert!(matches!(error.problem(), Problem::Changed), "{error}");
        assert!(stored.messages(|_| ()).is_err());
    }
}
