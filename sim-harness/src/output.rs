//! Files that are whole: a killed run leaves the old file or the new one, never half.
//!
//! What a command wrote before is replaced. Two kinds of files are not: what the command
//! reads, see [`check`], and the recording of a robot, which cannot be made again.

use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use crate::escape::whole_escaped;
use crate::log::{DECIDING_BYTES, is_of_a_robot};

/// A file that could not be written, and why.
#[derive(Debug)]
pub struct WriteError {
    /// The file that was asked for.
    pub path: PathBuf,
    /// What the system said.
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

impl std::error::Error for WriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}

/// Writes a file at once, in place of one that is already there.
///
/// # Errors
/// As [`write_with`].
pub fn write(path: &Path, content: &[u8]) -> Result<(), WriteError> {
    write_with(path, |file| file.write_all(content))
}

/// Writes a file with what `fill` writes, in place of one that is already there.
///
/// The content goes to a neighbour named `.NAME.PROCESS-COUNT.partial`, which takes the
/// file's name when it is complete and on the disk; a killed run may leave the
/// neighbour behind. Links are followed, and what is neither a file nor a folder
/// (`/dev/stdout`, a pipe) is written to directly, for renaming would replace it.
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

/// Checks, before the work, that what a command will write replaces neither what it reads
/// nor the recording of a robot.
///
/// # Errors
/// The first of `outputs` that would.
pub fn check(outputs: &[PathBuf], inputs: &[&Path]) -> Result<(), WriteError> {
    let inputs: Vec<_> = inputs.iter().flat_map(fs::canonicalize).collect();
    for output in outputs {
        let cause = match fs::canonicalize(output) {
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
    let mut head = Vec::new();
    File::open(path)?
        .take(DECIDING_BYTES as u64)
        .read_to_end(&mut head)?;
    if is_of_a_robot(&head) {
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
    let failed = |cause| WriteError {
        path: path.to_owned(),
        cause,
    };
    let (partial, _) = create_beside(path).map_err(failed)?;
    fs::remove_file(partial).map_err(failed)
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
    let (partial, file) = create_beside(path)?;
    let done = fill_up(file, fill).and_then(|file| {
        if let Some(permissions) = permissions {
            file.set_permissions(permissions)?;
        }
        file.sync_all()?;
        fs::rename(&partial, path)
    });
    if done.is_err() {
        // The first error is the one to tell; a neighbour left behind is harmless.
        let _ = fs::remove_file(&partial);
    }
    done
}

fn fill_up(file: File, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut writer = BufWriter::new(file);
    fill(&mut writer)?;
    writer.into_inner().map_err(io::IntoInnerError::into_error)
}

/// A new file in the same folder, hence on the same disk, that no other writer uses.
fn create_beside(path: &Path) -> io::Result<(PathBuf, File)> {
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let process = std::process::id();
    // Process numbers return, most of all in containers: what a killed run left behind
    // is passed over, not overwritten, for its writer may be alive elsewhere.
    for count in 0..1000 {
        let mut partial = OsString::from(".");
        partial.push(name);
        partial.push(format!(".{process}-{count}.partial"));
        let partial = path.with_file_name(partial);
        match File::create_new(&partial) {
            Ok(file) => return Ok((partial, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other("1000 partial files lie beside it"))
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
        let said = error.to_string();
        assert!(
            said.contains("map.pgm") && said.contains("the well ran dry"),
            "{said}"
        );
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_a_killed_run_left_behind_is_passed_over() {
        let folder = folder("killed");
        let path = folder.join("map.pgm");
        let (partial, _) = create_beside(&path).unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read(&partial).unwrap(), b"");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn errors_name_the_path() {
        let folder = folder("errors");
        let missing = folder.join("no such folder").join("map.yaml");
        let said = write(&missing, b"x").unwrap_err().to_string();
        assert!(said.contains(&missing.display().to_string()), "{said}");
        let said = write(&folder, b"x").unwrap_err().to_string();
        assert!(said.contains(&folder.display().to_string()), "{said}");
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
