//! How far a long pass over a file has come.

use indicatif::{ProgressBar, ProgressStyle};
use sim_harness::console;

/// A bar over the bytes of a source on a terminal, nothing in a pipe; gone when dropped.
#[derive(Debug, Default)]
pub(super) struct PassProgress {
    bar: Option<(&'static str, ProgressBar)>,
}

impl PassProgress {
    /// Shows the bytes that a pass has read, of `length` where that is known; `done` is what
    /// happens to them.
    pub(super) fn show(&mut self, done: &'static str, bytes: u64, length: Option<u64>) {
        if self.bar.as_ref().is_none_or(|(shown, _)| *shown != done) {
            self.clear();
            self.bar = Some((done, bar(done, length)));
        }
        if let Some((_, bar)) = &self.bar {
            bar.set_position(bytes);
        }
    }

    fn clear(&mut self) {
        if let Some((_, bar)) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for PassProgress {
    fn drop(&mut self) {
        self.clear();
    }
}

fn bar(done: &'static str, length: Option<u64>) -> ProgressBar {
    if !console::is_interactive() {
        return ProgressBar::hidden();
    }
    let (bar, template) = match length {
        Some(length) => (
            ProgressBar::new(length),
            "{bar:40} {decimal_bytes} of {decimal_total_bytes} ",
        ),
        None => (ProgressBar::new_spinner(), "{spinner} {decimal_bytes} "),
    };
    match ProgressStyle::with_template(&format!("{template}{done}")) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
