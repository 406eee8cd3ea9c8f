//! The files that a recording of a robot goes to.

use std::ffi::OsString;
use std::fmt::Display;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::output::{self, Special};

/// Numbers of parts that are tried for a free name.
const MOST_NAMES: u32 = 10_000;

/// The parts of a recording: `drive.ipf`, then `drive.2.ipf` and so on with the next
/// number that is free.
///
/// A recording cannot be made again: a file that exists is never opened for writing,
/// except the first one where the user asked to replace it. `/dev/null` and the process's
/// own streams may be written to; another device is refused, the board's port above all.
#[derive(Debug)]
pub struct RecordingParts {
    first: PathBuf,
    replaces: bool,
    /// What was opened so far.
    opened: Vec<PathBuf>,
    next_number: u32,
}

impl RecordingParts {
    /// Parts that begin with this file, of the board at `port`; `replaces` it if it exists.
    ///
    /// # Errors
    /// The file exists, is a device or a named pipe, or no file can be created in its folder.
    pub fn new(first: PathBuf, replaces: bool, port: &str) -> Result<Self, String> {
        let parts = Self {
            first,
            replaces,
            opened: Vec::new(),
            next_number: 2,
        };
        let path = &parts.first;
        if path.is_dir() {
            return Err(format!("--out {}: is a folder", path.display()));
        }
        let refused = |why: &dyn Display| Err(format!("--out {}: {why}", path.display()));
        if output::is_same_device(path, Path::new(port)) {
            return refused(&"is the port of the board");
        }
        match Special::at(path) {
            None => {}
            Some(Special::Null | Special::OwnStream) => return Ok(parts),
            Some(Special::NamedPipe) => return refused(&output::named_pipe()),
            Some(Special::Device) => return refused(&"is a device, which --force does not change"),
        }
        if fs::symlink_metadata(path).is_ok() {
            return if replaces {
                Ok(parts)
            } else {
                Err(parts.exists())
            };
        }
        output::check_folder_of(path).map_err(|error| format!("--out: {error}"))?;
        Ok(parts)
    }

    /// Opens the next part.
    ///
    /// # Errors
    /// What the system says; a first file that exists by now.
    pub fn open(&mut self) -> io::Result<File> {
        let (path, file) = if self.opened.is_empty() {
            (self.first.clone(), self.open_first()?)
        } else {
            self.open_later()?
        };
        self.opened.push(path);
        Ok(file)
    }

    /// What was opened so far, in order.
    #[must_use]
    pub fn opened(&self) -> &[PathBuf] {
        &self.opened
    }

    fn open_first(&self) -> io::Result<File> {
        let path = &self.first;
        let opened = if Special::at(path).is_some() {
            File::options().write(true).open(path)
        } else if self.replaces {
            File::create(path)
        } else {
            File::create_new(path)
        };
        opened.map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => io::Error::new(error.kind(), self.exists()),
            kind => io::Error::new(kind, format!("{}: {error}", path.display())),
        })
    }

    fn open_later(&mut self) -> io::Result<(PathBuf, File)> {
        while self.next_number < MOST_NAMES {
            let path = self.numbered(self.next_number);
            self.next_number += 1;
            match File::create_new(&path) {
                Ok(file) => return Ok((path, file)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => {
                    let named = format!("{}: {error}", path.display());
                    return Err(io::Error::new(error.kind(), named));
                }
            }
        }
        let first = self.first.display();
        let all = format!("{first}: {MOST_NAMES} parts lie beside it");
        Err(io::Error::new(io::ErrorKind::AlreadyExists, all))
    }

    fn exists(&self) -> String {
        let free = (2..MOST_NAMES)
            .map(|number| self.numbered(number))
            .find(|path| fs::symlink_metadata(path).is_err());
        let free = free.map_or(String::new(), |path| {
            format!(", {} is free", path.display())
        });
        format!(
            "{} exists and stays as it is: --force replaces it{free}",
            self.first.display()
        )
    }

    fn numbered(&self, number: u32) -> PathBuf {
        let mut extension = OsString::from(number.to_string());
        if let Some(last) = self.first.extension() {
            extension.push(".");
            extension.push(last);
        }
        self.first.with_extension(extension)
    }
}
