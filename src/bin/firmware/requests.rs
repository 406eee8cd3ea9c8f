//! Check-ins and requests that pass between the tasks.

use core::sync::atomic::{AtomicBool, Ordering};

use amiro_ipf::board::supervision::TaskCheckIn;

/// The tasks that have checked in.
pub(crate) static TASKS: TaskCheckIn = TaskCheckIn::new();

/// Whether a shutdown was requested.
static SHUTDOWN: AtomicBool = AtomicBool::new(false);

/// Requests a shutdown of the robot.
pub(crate) fn request_shutdown() {
    SHUTDOWN.store(true, Ordering::Relaxed);
}

/// Whether a shutdown was requested.
pub(crate) fn is_shutdown_requested() -> bool {
    SHUTDOWN.load(Ordering::Relaxed)
}
