//! Orderly end of a board's use on SIGINT or SIGTERM.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Whether the program received SIGINT or SIGTERM while it used a board.
///
/// A [`Board`](super::Board) that is given one stops waiting within a tenth of a second
/// of the signal, with [`LinkError::Interrupted`](super::LinkError::Interrupted); its
/// user then ends in order and the emulator is ended with the board. A second signal
/// changes nothing until this is dropped: some parents, such as `timeout`, send two.
/// After that a signal has its default action, which ends the process.
#[derive(Debug)]
pub struct Interrupt {
    is_requested: Arc<AtomicBool>,
    is_over: Arc<AtomicBool>,
}

impl Interrupt {
    /// Watches for SIGINT and SIGTERM from now on, also where they were ignored, as in
    /// the background of a shell script.
    ///
    /// # Errors
    /// The error of the system.
    pub fn on_signals() -> io::Result<Self> {
        let is_requested = Arc::new(AtomicBool::new(false));
        let is_over = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            flag::register_conditional_default(signal, Arc::clone(&is_over))?;
            flag::register(signal, Arc::clone(&is_requested))?;
        }
        Ok(Self {
            is_requested,
            is_over,
        })
    }

    /// Whether a signal came.
    #[must_use]
    pub fn is_requested(&self) -> bool {
        self.is_requested.load(Ordering::Relaxed)
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}
