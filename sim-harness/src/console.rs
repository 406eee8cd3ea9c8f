//! Standard output and standard error: every line of the program is written here.
//!
//! Nothing here panics. Control characters are escaped, so that no text of a file, a
//! board or the command line can move a cursor or change the terminal. A line stays one
//! line: its line ends are escaped too.
//!
//! When the reader of standard output closes it, as `head` does, printing ends silently and
//! the program continues. Any other failure, such as a full disk, is reported once on
//! standard error. [`printed`] returns which of these happened; failures of standard error
//! are ignored.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use crate::escape::{lines_escaped, whole_escaped};
use crate::output::is_same_device;

/// The outcome of printing to standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Printed {
    /// All of it was written.
    Whole,
    /// Its reader closed it before the end.
    Closed,
    /// It could not be written, for example to a full disk.
    Failed,
}

static STDOUT: State = State::new();

/// Whether a progress line stands on the terminal without its line end.
static IS_PROGRESS_SHOWN: AtomicBool = AtomicBool::new(false);

/// Writes a line to standard output.
pub fn print(line: impl Display) {
    print_escaped(&line_escaped(&line.to_string()));
}

/// Writes text of one or more lines to standard output, and a line end.
///
/// Text of other origin in it must contain no line ends, so that it cannot look like a
/// line of the program.
pub fn print_text(text: impl Display) {
    print_escaped(&lines_escaped(&text.to_string()));
}

/// Writes bytes that are no text, such as a recording, to standard output as they are.
///
/// If the reader closes it, this ends without an error, and [`printed`] returns it. A
/// standard output that was closed before the start is reported as one that failed.
///
/// # Errors
/// Any other error of `fill`.
#[expect(clippy::disallowed_methods, reason = "the one module that may")]
pub fn print_bytes(fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    if STDOUT.printed() != Printed::Whole {
        return Ok(());
    }
    if is_stdout_missing() {
        fail(&io::Error::other("it is closed"));
        return Ok(());
    }
    let mut writer = io::BufWriter::new(io::stdout().lock());
    let written = fill(&mut writer).and_then(|()| writer.flush());
    // The rest of the buffer would fail again.
    let _ = writer.into_parts();
    match written {
        Err(error) if STDOUT.take(&error) == Printed::Closed => Ok(()),
        Err(error) => {
            let failed = format!("standard output cannot be written: {error}");
            Err(io::Error::new(error.kind(), failed))
        }
        Ok(()) => Ok(()),
    }
}

/// Writes a line to standard error.
pub fn warn(line: impl Display) {
    warn_escaped(&line_escaped(&line.to_string()));
}

/// Writes text of one or more lines to standard error, and a line end; see
/// [`print_text`].
pub fn warn_text(text: impl Display) {
    warn_escaped(&lines_escaped(&text.to_string()));
}

/// Shows a line on standard error that replaces the progress line before it; nothing
/// where standard error is no terminal.
pub fn show_progress(line: impl Display) {
    if is_interactive() {
        IS_PROGRESS_SHOWN.store(true, Ordering::Relaxed);
        let line = line_escaped(&line.to_string());
        write_ignoring_failure(&format!("\r\x1b[K{line}"));
    }
}

/// Whether standard error is a terminal: progress is shown there and nowhere else.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "the one module that may")]
pub fn is_interactive() -> bool {
    io::stderr().is_terminal()
}

/// Whether standard output is a terminal, which bytes that are no text would disturb.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "the one module that may")]
pub fn is_stdout_interactive() -> bool {
    io::stdout().is_terminal()
}

/// Flushes standard output; returns the outcome of everything printed.
#[expect(clippy::disallowed_methods, reason = "the one module that may")]
pub fn printed() -> Printed {
    if STDOUT.printed() == Printed::Whole
        && let Err(error) = io::stdout().flush()
    {
        fail(&error);
    }
    STDOUT.printed()
}

/// Whether the program was started without a standard output.
///
/// Rust's start code then opens `/dev/null` for reading and writing in its place; a shell's
/// `> /dev/null` is for writing only. Without `/proc` this is not detected.
fn is_stdout_missing() -> bool {
    let flags = std::fs::read_to_string("/proc/self/fdinfo/1").unwrap_or_default();
    let flags = flags.lines().find_map(|line| line.strip_prefix("flags:"));
    // Octal; the last two bits are 2 for reading and writing.
    let is_for_both = flags.is_some_and(|flags| flags.ends_with(['2', '6']));
    is_for_both && is_same_device(Path::new("/dev/stdout"), Path::new("/dev/null"))
}

fn line_escaped(line: &str) -> String {
    lines_escaped(line).replace('\n', "\\n")
}

#[expect(clippy::disallowed_methods, reason = "the one module that may")]
fn print_escaped(text: &str) {
    if STDOUT.printed() != Printed::Whole {
        return;
    }
    end_progress();
    // One call: the lines of two threads do not mix.
    if let Err(error) = io::stdout().write_all(format!("{text}\n").as_bytes()) {
        fail(&error);
    }
}

fn warn_escaped(text: &str) {
    end_progress();
    write_ignoring_failure(&format!("{text}\n"));
}

/// Ends a progress line, so that the next line begins at the left.
fn end_progress() {
    if IS_PROGRESS_SHOWN.swap(false, Ordering::Relaxed) {
        write_ignoring_failure("\n");
    }
}

#[expect(clippy::disallowed_methods, reason = "the one module that may")]
fn write_ignoring_failure(text: &str) {
    // There is no other place to report it.
    let _ = io::stderr().write_all(text.as_bytes());
}

fn fail(error: &io::Error) {
    if STDOUT.take(error) == Printed::Failed {
        let error = whole_escaped(error.to_string().chars());
        warn(format_args!(
            "ipf: standard output cannot be written: {error}"
        ));
    }
}

/// Whether a stream can still be written, and how it ended if not.
struct State(AtomicU8);

impl State {
    const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    fn printed(&self) -> Printed {
        match self.0.load(Ordering::Relaxed) {
            0 => Printed::Whole,
            1 => Printed::Closed,
            _ => Printed::Failed,
        }
    }

    /// Takes a failure to write; the first one decides.
    fn take(&self, error: &io::Error) -> Printed {
        let end = if error.kind() == io::ErrorKind::BrokenPipe {
            1
        } else {
            2
        };
        let _ = self
            .0
            .compare_exchange(0, end, Ordering::Relaxed, Ordering::Relaxed);
        self.printed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_holds_no_control_character_and_no_line_end() {
        let line = line_escaped("a\x1b[2J\r\nEQUAL\u{9b}m\u{7f}\u{202e}\\b 'c' µ");
        assert!(!line.chars().any(char::is_control), "{line}");
        assert_eq!(
            line,
            "a\\u{1b}[2J\\r\\nEQUAL\\u{9b}m\\u{7f}\\u{202e}\\b 'c' µ"
        );
    }

    #[test]
    fn a_closed_pipe_is_quiet_and_a_full_disk_is_not() {
        let state = State::new();
        assert_eq!(state.printed(), Printed::Whole);
        let closed = io::ErrorKind::BrokenPipe.into();
        assert_eq!(state.take(&closed), Printed::Closed);
        let full = io::ErrorKind::StorageFull.into();
        assert_eq!(state.take(&full), Printed::Closed);
        assert_eq!(State::new().take(&full), Printed::Failed);
    }
}
