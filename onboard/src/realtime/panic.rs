//! A panic anywhere stops the robot: it raises a flag that the drive activity obeys.
//!
//! The flag is one robot's: a process may step several robots on a simulated clock.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::realtime::guard;

/// Whether a part of one robot's program has panicked. Its clones are one flag; once raised it stays.
#[derive(Clone, Debug, Default)]
pub struct Panicked(Arc<AtomicBool>);

impl Panicked {
    /// A part has panicked. Takes no lock, and does not allocate.
    pub fn raise(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether any has.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Installs the hook of a process that is one robot: whatever thread panics raises the flag, before it says anything. What the hook has
/// to say goes to the log: printing it here could hold up the thread that has to stop the robot.
pub fn install_hook(panicked: &Panicked) {
    let panicked = panicked.clone();
    std::panic::set_hook(Box::new(move |info| {
        panicked.raise();
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
