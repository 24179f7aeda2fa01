//! A panic anywhere stops the robot: the hook raises a flag that the drive activity obeys.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::realtime::guard;

static PANICKED: AtomicBool = AtomicBool::new(false);

/// Installs the hook. What it has to say goes to the log: printing it here could hold up the thread that has to stop the robot.
pub fn install_hook() {
    std::panic::set_hook(Box::new(|info| {
        PANICKED.store(true, Ordering::SeqCst);
        let real_time = guard::lift_for_panic();
        let thread = std::thread::current();
        let name = thread.name().unwrap_or("?");
        // A trace takes longer than a real-time thread has.
        let trace = if real_time {
            Backtrace::disabled()
        } else {
            Backtrace::capture()
        };
        if trace.status() == BacktraceStatus::Captured {
            tracing::error!("thread '{name}' {info}\n{trace}");
        } else {
            tracing::error!("thread '{name}' {info}");
        }
    }));
}

/// Whether any thread of the process panicked.
#[must_use]
pub fn has_panicked() -> bool {
    PANICKED.load(Ordering::Relaxed)
}
