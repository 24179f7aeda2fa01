//! The allocation guard: proof, in the running program, that real-time threads do not allocate.
//!
//! Every binary that links this crate uses [`GuardedAllocator`]. It forwards to the system's allocator; when the
//! environment variable [`ENVIRONMENT_VARIABLE`] was set at start, an allocation or release inside
//! [`real_time`] aborts the process with a backtrace.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, Ordering};

/// Set to anything but `0` to arm the guard.
pub const ENVIRONMENT_VARIABLE: &str = "ONBOARD_ALLOC_GUARD";

static ARMED: AtomicBool = AtomicBool::new(false);

thread_local! {
    // Const-initialised and without a destructor, so that reading it never allocates. Atomic for who looks while this thread
    // waits in a system call.
    static FORBIDDEN: AtomicBool = const { AtomicBool::new(false) };
}

#[global_allocator]
static ALLOCATOR: GuardedAllocator = GuardedAllocator;

/// The system's allocator behind the guard.
#[derive(Debug)]
pub struct GuardedAllocator;

// SAFETY: every call is forwarded unchanged to the system's allocator; the check before it touches no memory of theirs.
unsafe impl GlobalAlloc for GuardedAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        check("allocated", layout.size());
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        check("allocated", layout.size());
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        check("released", layout.size());
        // SAFETY: the caller's promises about `pointer` and `layout` are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        check("reallocated", new_size);
        // SAFETY: the caller's promises about `pointer` and `layout` are passed on.
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

fn check(what: &str, bytes: usize) {
    // The fast path of a program without the guard is one relaxed load.
    if ARMED.load(Ordering::Relaxed) && holds() {
        set(false);
        eprintln!(
            "allocation guard: a real-time thread {what} {bytes} bytes in state running\n{}",
            std::backtrace::Backtrace::force_capture()
        );
        std::process::abort();
    }
}

/// Whether the rules hold on this thread.
#[must_use]
pub fn holds() -> bool {
    FORBIDDEN.with(|forbidden| forbidden.load(Ordering::Relaxed))
}

/// Returns whether they held before.
fn set(hold: bool) -> bool {
    FORBIDDEN.with(|forbidden| {
        let before = forbidden.load(Ordering::Relaxed);
        forbidden.store(hold, Ordering::Relaxed);
        before
    })
}

/// Where a thread says whether the rules hold on it.
#[derive(Clone, Copy)]
pub(super) struct Mark(*const AtomicBool);

// SAFETY: whoever reads it promises that its thread exists.
unsafe impl Send for Mark {}

impl Mark {
    /// Whether the rules hold there.
    ///
    /// # Safety
    /// The thread that the mark came from has not ended, and does not before this returns.
    pub(super) unsafe fn holds(self) -> bool {
        // SAFETY: the caller's promise: a thread's mark exists as long as the thread.
        unsafe { &*self.0 }.load(Ordering::Relaxed)
    }
}

/// The mark of this thread.
pub(super) fn mark() -> Mark {
    FORBIDDEN.with(|forbidden| Mark(forbidden))
}

/// Arms the guard when the environment asks for it. Returns whether it is armed.
pub fn arm_from_environment() -> bool {
    let armed = std::env::var_os(ENVIRONMENT_VARIABLE).is_some_and(|value| value != "0");
    ARMED.store(armed, Ordering::Relaxed);
    armed
}

/// Runs `step` under the real-time rules if it is `running`, else as any code.
pub fn real_time_if<R>(running: bool, step: impl FnOnce() -> R) -> R {
    if running { real_time(step) } else { step() }
}

/// Runs `step` under the real-time rules: with a guard armed, an allocation in it, or a system call that is not its own, aborts
/// the process.
pub fn real_time<R>(step: impl FnOnce() -> R) -> R {
    let before = set(true);
    let _restore = Restore(before);
    step()
}

/// Runs `step` outside the real-time rules, for the state *configuring*.
pub fn relaxed<R>(step: impl FnOnce() -> R) -> R {
    let before = set(false);
    let _restore = Restore(before);
    step()
}

/// Restores the mark also when a panic unwinds.
struct Restore(bool);

impl Drop for Restore {
    fn drop(&mut self) {
        set(self.0);
    }
}

/// Lifts the rules on this thread for good: a panic is being reported, and the report allocates. Returns whether they held.
#[must_use]
pub fn lift_for_panic() -> bool {
    set(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_nests_and_is_restored() {
        real_time(|| {
            assert!(holds());
            relaxed(|| assert!(!holds()));
            assert!(holds());
        });
        assert!(!holds());
    }
}
