//! A panic anywhere stops the robot: the hook raises a flag that the drive activity obeys.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::realtime::guard;

static PANICKED: AtomicBool = AtomicBool::new(false);

/// Installs the hook, before the one that prints the message.
pub fn install_hook() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        PANICKED.store(true, Ordering::SeqCst);
        guard::lift_for_panic();
        print(info);
    }));
}

/// Whether any thread of the process panicked.
#[must_use]
pub fn has_panicked() -> bool {
    PANICKED.load(Ordering::Relaxed)
}
