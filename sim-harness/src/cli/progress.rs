//! How far long work has come.

use indicatif::{ProgressBar, ProgressStyle};
use sim_harness::console;

/// A bar over the bytes of a source, or over what else is counted, on a terminal; nothing
/// in a pipe. It is gone when dropped.
#[derive(Debug, Default)]
pub(super) struct PassProgress {
    bar: Option<(&'static str, ProgressBar)>,
}

const BYTES: &str = "{bar:40} {decimal_bytes} of {decimal_total_bytes} ";
const BYTES_ALONE: &str = "{spinner} {decimal_bytes} ";
const COUNT: &str = "{bar:40} {pos} of {len} ";

impl PassProgress {
    /// Shows the bytes that a pass has read, of `length` where that is known; `done` is what
    /// happens to them.
    pub(super) fn show(&mut self, done: &'static str, bytes: u64, length: Option<u64>) {
        let template = length.map_or(BYTES_ALONE, |_| BYTES);
        self.set(done, template, bytes, length);
    }

    /// Shows a count of what is done, such as `maps made`.
    pub(super) fn show_count(&mut self, done: &'static str, count: usize, of: usize) {
        self.set(done, COUNT, count as u64, Some(of as u64));
    }

    fn set(&mut self, done: &'static str, template: &str, position: u64, length: Option<u64>) {
        if self.bar.as_ref().is_none_or(|(shown, _)| *shown != done) {
            self.clear();
            self.bar = Some((done, bar(&format!("{template}{done}"), length)));
        }
        if let Some((_, bar)) = &self.bar {
            bar.set_position(position);
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

fn bar(template: &str, length: Option<u64>) -> ProgressBar {
    if !console::is_interactive() {
        return ProgressBar::hidden();
    }
    let bar = length.map_or_else(ProgressBar::new_spinner, ProgressBar::new);
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
