//! What a thread asks of an activity beyond its event loop.

use coordination::activity::Activity;

/// An activity as a thread runs it.
pub trait RobotActivity: Activity {
    /// Time that the last event loop spent waiting for its device, to be left out of the execution time.
    fn waited_ns(&self) -> u64 {
        0
    }

    /// One step of what must still be done after a panic in this thread; returns whether that is finished.
    fn after_panic(&mut self, _now_ns: u64) -> bool {
        true
    }
}
