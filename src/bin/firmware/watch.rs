//! What the tasks tell each other beside their work: that they run, that it is over.

use core::sync::atomic::{AtomicBool, Ordering};

use amiro_ipf::board::supervision::Roll;

/// Who still runs.
pub(crate) static ROLL: Roll = Roll::new();

/// Whether somebody wants the robot off.
static SHUTDOWN: AtomicBool = AtomicBool::new(false);

/// Somebody wants the robot off.
pub(crate) fn want_shutdown() {
    SHUTDOWN.store(true, Ordering::Relaxed);
}

/// Whether somebody wants the robot off.
pub(crate) fn is_shutdown_wanted() -> bool {
    SHUTDOWN.load(Ordering::Relaxed)
}
