//! Atomic writing of files: a killed run leaves the old file or the new one, never a part.
//!
//! Earlier output of a command is replaced. Two kinds of files are not: the inputs of the
//! command, see [`check`], and the recording of a robot, which cannot be repeated.

use std::error::Error;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::escape::whole_escaped;
use crate::log::{head_of, is_of_a_robot};

/// The kind of a path that is neither a file nor a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Special {
    /// A pipe with a name in a folder: opening it waits for a reader.
    NamedPipe,
    /// A stream that this process has open: `/dev/stdout`, `/dev/fd/N`.
    OwnStream,
    /// `/dev/null`.
    Null,
    /// Any other device, or a socket.
    Device,
}

impl Special {
    /// The kind of a path; `None` for a missing path, a file or a folder.
    #[must_use]
    pub fn at(path: &Path) -> Option<Self> {
        let found = fs::metadata(path).ok()?;
        if found.is_file() || found.is_dir() {
            return None;
        }
        let is_own = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc/self/fd"]
            .iter()
            .any(|own| path.starts_with(own));
        Some(if is_own {
            Self::OwnStream
        } else if is_same_device(path, Path::new("/dev/null")) {
            Self::Null
        } else if is_pipe(&found) {
            Self::NamedPipe
        } else {
            Self::Device
        })
    }
}

/// Whether two paths lead to the same character device, under one name or two.
#[must_use]
pub fn is_same_device(one: &Path, other: &Path) -> bool {
    let numbers = |path| fs::metadata(path).ok().as_ref().and_then(device_number);
    numbers(one).is_some_and(|one| numbers(other) == Some(one))
}

#[cfg(unix)]
fn is_pipe(found: &fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&found.file_type())
}

#[cfg(unix)]
fn device_number(found: &fs::Metadata) -> Option<u64> {
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    let is_device = found.file_type().is_char_device();
    is_device.then(|| found.rdev())
}

#[cfg(not(unix))]
fn is_pipe(_found: &fs::Metadata) -> bool {
    false
}

#[cfg(not(unix))]
fn device_number(_found: &fs::Metadata) -> Option<u64> {
    None
}

/// A file that could not be written, and why.
#[derive(Debug)]
pub struct WriteError {
    /// The requested file.
    pub path: PathBuf,
    /// The system's error.
    pub cause: io::Error,
}

impl fmt::Display for WriteError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "cannot write {}: {}",
            whole_escaped(self.path.to_string_lossy().chars()),
            self.cause
        )
    }
}

impl Error for WriteError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        Some(&self.cause)
    }
}

/// Writes a file atomically; an existing one is replaced.
///
/// # Errors
/// As [`write_with`].
pub fn write(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    write_with(path, |file| file.write_all(content))
}

/// Writes a file with the output of `fill`; an existing one is replaced.
///
/// The content goes to a neighbour named `.ipf-RANDOM.partial`, which takes the file's name
/// when it is complete and on the disk; a killed run may leave the neighbour behind. Links
/// are followed, and a path that is neither a file nor a folder (`/dev/stdout`, a pipe) is
/// written to directly, because a rename would replace it. A file that is mounted on its
/// own, which no file can replace, is written in place once the content is complete.
///
/// # Errors
/// If `fill` fails, the folder is missing, full or not writable, or the old file is the
/// recording of a robot. The old file is then untouched and the neighbour removed.
pub fn write_with(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    replace(path, fill).map_err(|cause| WriteError {
        path: path.to_owned(),
        cause,
    })
}

/// Removes a file of an earlier run, if it is there; folders and devices stay.
///
/// # Errors
/// It cannot be removed, or it is the recording of a robot.
pub fn remove(path: &Path) -> Result<(), WriteError> {
    if !fs::symlink_metadata(path).is_ok_and(|found| found.is_file()) {
        return Ok(());
    }
    check_replaceable(path)
        .and_then(|()| fs::remove_file(path))
        .map_err(|cause| error_of(path, cause))
}

/// Checks, before the work, that the outputs of a command replace neither its inputs nor
/// the recording of a robot.
///
/// # Errors
/// The first of `outputs` that would.
pub fn check(outputs: &[PathBuf], inputs: &[&Path]) -> Result<(), WriteError> {
    let inputs: Vec<_> = inputs.iter().flat_map(fs::canonicalize).collect();
    for output in outputs {
        let cause = match fs::canonicalize(output) {
            Ok(_) if Special::at(output) == Some(Special::NamedPipe) => named_pipe(),
            // A device may be read and written.
            Ok(path) if !path.is_file() => continue,
            Ok(path) if inputs.contains(&path) => {
                io::Error::other("this command reads it: write elsewhere")
            }
            Ok(path) => match check_replaceable(&path) {
                Ok(()) => continue,
                Err(error) => error,
            },
            Err(_) => continue,
        };
        let path = output.clone();
        return Err(WriteError { path, cause });
    }
    Ok(())
}

/// Refuses a file that is the recording of a robot.
fn check_replaceable(path: &Path) -> io::Result<()> {
    if is_of_a_robot(&head_of(path)?) {
        return Err(io::Error::other(
            "it is the recording of a robot: write elsewhere, or remove it first",
        ));
    }
    Ok(())
}

/// Checks that a file can be created beside `path`, as a new file of its name would be.
///
/// # Errors
/// The folder is missing or not writable.
pub fn check_folder_of(path: &Path) -> Result<(), WriteError> {
    create_beside(path)
        .map(drop)
        .map_err(|cause| error_of(path, cause))
}

/// Checks, before the work, that a file can be written; leaves nothing behind.
///
/// # Errors
/// It is a folder or a named pipe, or its folder is missing, none, or not writable.
pub fn check_file(path: &Path) -> Result<(), WriteError> {
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(error_of(path, io::ErrorKind::IsADirectory.into())),
        Ok(found) if !found.is_file() => match Special::at(path) {
            Some(Special::NamedPipe) => Err(error_of(path, named_pipe())),
            // Errors of a device show when it is written to.
            _ => Ok(()),
        },
        Ok(_) => {
            let target = fs::canonicalize(path).map_err(|cause| error_of(path, cause))?;
            create_beside(&target)
                .map(drop)
                .map_err(|cause| error_of(path, cause))
        }
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => check_folder_of(path),
        Err(cause) => Err(error_of(path, cause)),
    }
}

/// Checks, before the work, that files can be written to a folder, which may have to be
/// created with those above it; leaves nothing behind.
///
/// # Errors
/// The path, or its first existing parent, is no folder or not writable.
pub fn check_folder(folder: &Path) -> Result<(), WriteError> {
    let failed = |cause| error_of(folder, cause);
    for existing in folder.ancestors() {
        let existing = match existing.as_os_str().is_empty() {
            true => Path::new("."),
            false => existing,
        };
        match fs::metadata(existing) {
            Ok(found) if !found.is_dir() => {
                return Err(failed(io::ErrorKind::NotADirectory.into()));
            }
            Ok(_) => return create_in(existing).map(drop).map_err(failed),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(failed(error)),
        }
    }
    Ok(())
}

/// Creates a folder and those above it, as far as they are missing.
///
/// # Errors
/// What the system reports.
pub fn create_folder(folder: &Path) -> Result<(), WriteError> {
    fs::create_dir_all(folder).map_err(|cause| error_of(folder, cause))
}

/// Why a named pipe is not written to.
#[must_use]
pub fn named_pipe() -> io::Error {
    io::Error::other("is a named pipe, which would wait for a reader: use a file or /dev/stdout")
}

fn error_of(path: &Path, cause: io::Error) -> WriteError {
    WriteError {
        path: path.to_owned(),
        cause,
    }
}

fn replace(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let old = match fs::metadata(path) {
        Ok(metadata) => Some(metadata),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    let Some(old) = old else {
        return rename_into(path, None, fill);
    };
    if old.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if Special::at(path) == Some(Special::NamedPipe) {
        return Err(named_pipe());
    }
    if !old.is_file() {
        return fill_up(File::options().write(true).open(path)?, fill).map(drop);
    }
    let path = fs::canonicalize(path)?;
    check_replaceable(&path)?;
    rename_into(&path, Some(old.permissions()), fill)
}

fn rename_into(
    path: &Path,
    permissions: Option<fs::Permissions>,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let (file, partial) = create_beside(path)?.into_parts();
    let file = fill_up(file, fill)?;
    if let Some(permissions) = permissions {
        file.set_permissions(permissions)?;
    }
    file.sync_all()?;
    // The neighbour is removed when it is dropped, also after an error.
    match partial.persist(path) {
        Ok(()) => Ok(()),
        Err(failed) if is_mount_point(&failed.error) => copy(&failed.path, path),
        Err(failed) => Err(failed.error),
    }
}

/// Whether a rename failed because a file system is mounted at the name, as containers do
/// with single files.
fn is_mount_point(error: &io::Error) -> bool {
    use io::ErrorKind::{CrossesDevices, ResourceBusy};
    matches!(error.kind(), CrossesDevices | ResourceBusy)
}

/// Writes a file into another one in place: not atomic, because a rename is impossible.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    let mut target = File::options().write(true).truncate(true).open(to)?;
    io::copy(&mut File::open(from)?, &mut target)?;
    target.sync_all()
}

fn fill_up(file: File, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut writer = BufWriter::new(file);
    fill(&mut writer)?;
    writer.into_inner().map_err(io::IntoInnerError::into_error)
}

/// A new file in the same folder, hence on the same disk, that no other writer uses.
///
/// Its name does not hold the name of `path`, which may be as long as a name can be.
fn create_beside(path: &Path) -> io::Result<NamedTempFile> {
    path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    create_in(folder.unwrap_or(Path::new(".")))
}

fn create_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ipf-").suffix(".partial");
    // As any new file: the user's mask decides, not the crate.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    if !fs::metadata(folder)?.is_dir() {
        return Err(io::ErrorKind::NotADirectory.into());
    }
    builder.tempfile_in(folder).map_err(|error| {
        use io::ErrorKind::{PermissionDenied, ReadOnlyFilesystem};
        match error.kind() {
            // The crate adds the neighbour's name, which the user does not need.
            kind @ (PermissionDenied | ReadOnlyFilesystem) => kind.into(),
            _ => error,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty folder of the test's own.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("ipf-output-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_and_nothing_else_left() {
        let folder = folder("replaced");
        let path = folder.join("map.pgm");
        write(&path, b"a long old content").unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(&folder), ["map.pgm"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_failure_half_way_leaves_the_old_file() {
        let folder = folder("half");
        let path = folder.join("map.pgm");
        write(&path, b"old").unwrap();
        let error = write_with(&path, |file| {
            file.write_all(&[0; 100_000])?;
            Err(io::Error::other("the well ran dry"))
        })
        .unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(&folder), ["map.pgm"]);
        let message = error.to_string();
        assert!(
            message.contains("map.pgm") && message.contains("the well ran dry"),
            "{message}"
        );
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_a_killed_run_left_behind_is_passed_over() {
        let folder = folder("killed");
        let path = folder.join("map.pgm");
        let (_, partial) = create_beside(&path).unwrap().keep().unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read(&partial).unwrap(), b"");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_name_as_long_as_names_can_be_is_written() {
        let folder = folder("long");
        for length in [239, 240, 254, 255] {
            let path = folder.join("n".repeat(length));
            check_file(&path).unwrap();
            write(&path, b"new").unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"new", "{length} bytes");
            fs::remove_file(&path).unwrap();
        }
        let path = folder.join("n".repeat(256));
        assert!(check_file(&path).is_err() && write(&path, b"new").is_err());
        assert!(names(&folder).is_empty());
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_has_the_mode_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = folder("mode");
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        let (any, path) = (folder.join("any"), folder.join("map.pgm"));
        fs::write(&any, b"new").unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(mode(&path), mode(&any));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        write(&path, b"newer").unwrap();
        assert_eq!(mode(&path) & 0o777, 0o640);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_check_finds_what_is_in_the_way_and_leaves_nothing() {
        let folder = folder("checked");
        let file = folder.join("file");
        write(&file, b"old").unwrap();
        for path in [&folder, &file.join("below"), &folder.join("missing/below")] {
            assert!(check_file(path).is_err(), "{}", path.display());
        }
        for path in [&file, &file.join("below"), &file.join("far/below")] {
            assert!(check_folder(path).is_err(), "{}", path.display());
        }
        check_file(&file).unwrap();
        check_file(&folder.join("new")).unwrap();
        check_folder(&folder).unwrap();
        check_folder(&folder.join("far/below")).unwrap();
        assert_eq!(names(&folder), ["file"]);
        assert_eq!(fs::read(&file).unwrap(), b"old");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn errors_name_the_path() {
        let folder = folder("errors");
        let missing = folder.join("no such folder").join("map.yaml");
        let message = write(&missing, b"x").unwrap_err().to_string();
        assert!(
            message.contains(&missing.display().to_string()),
            "{message}"
        );
        let message = write(&folder, b"x").unwrap_err().to_string();
        assert!(message.contains(&folder.display().to_string()), "{message}");
        assert!(write(Path::new(""), b"x").is_err());
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay_what_they_are() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let folder = folder("links");
        write(&folder.join("run-1.png"), b"old").unwrap();
        symlink("run-1.png", folder.join("latest.png")).unwrap();
        write(&folder.join("latest.png"), b"new").unwrap();
        assert_eq!(fs::read(folder.join("run-1.png")).unwrap(), b"new");
        let link = fs::symlink_metadata(folder.join("latest.png")).unwrap();
        assert!(link.file_type().is_symlink());
        write(Path::new("/dev/null"), b"gone").unwrap();
        let null = fs::metadata("/dev/null").unwrap();
        assert!(null.file_type().is_char_device());
        fs::remove_dir_all(folder).unwrap();
    }
}
