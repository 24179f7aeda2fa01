//! Where the search runs: on a thread with a deep stack, in a space that is as small as possible.

use std::time::Instant;

use super::super::closed::Closed;
use super::super::explored::Fault;
use super::super::refusal::Reason;
use super::super::usage::Limits;
use super::diagram::{Exhausted, Grown};
use super::space::Space;

/// Deep enough for a call per variable.
const STACK: usize = if cfg!(target_pointer_width = "64") {
    1 << 30
} else {
    1 << 26
};

/// What oxidd reads from the environment: how many bytes of stack its own thread has, which is idle here. It panics if there is no
/// room for them, as in a process of 32 bits.
const IDLE_STACK: &str = "OXIDD_STACK_SIZE";
const IDLE_STACK_UNTOLD: usize = 1 << 30;

fn idle_stack() -> usize {
    let told = std::env::var(IDLE_STACK).ok();
    { told.and_then(|told| told.parse().ok()) }.unwrap_or(IDLE_STACK_UNTOLD)
}

/// Whether there is room for both.
fn is_room_for_idle_stack() -> bool {
    let thread = std::thread::Builder::new().stack_size(idle_stack());
    thread.spawn(|| ()).is_ok_and(|idle| idle.join().is_ok())
}

/// How a look at a space ends.
pub(super) enum Looked<T> {
    All(T),
    Fault(Fault),
    /// An event has to wait for a source for which there are no variables.
    Waits,
}

/// Runs `look` on a thread of its own. Time and memory that are used up are a fault.
pub(super) fn deep<T: Send>(
    limits: &Limits,
    look: impl FnOnce() -> Grown<Result<T, Fault>> + Send,
) -> Result<T, Fault> {
    let looked = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK);
        let running = thread.spawn_scoped(scope, || {
            if is_room_for_idle_stack() {
                look()
            } else {
                Err(Exhausted::Stack)
            }
        });
        running.map(|running| running.join())
    });
    let too_large = |what, limit| {
        let proved = String::new();
        let reason = Reason::TooLarge {
            what,
            limit,
            proved,
        };
        (Box::new(reason), None)
    };
    match looked {
        Ok(Ok(Ok(found))) => found,
        Ok(Ok(Err(Exhausted::Time))) => Err(too_large("seconds of looking", limits.time.as_secs())),
        Ok(Ok(Err(Exhausted::Nodes))) => {
            Err(too_large("nodes of decision diagrams", limits.nodes as u64))
        }
        Ok(Ok(Err(Exhausted::Stack))) => Err(too_large(
            "bytes of stack, which are not to be had: fewer, with OXIDD_STACK_SIZE in the environment, may do",
            idle_stack() as u64,
        )),
        Ok(Err(panic)) => std::panic::resume_unwind(panic),
        Err(_) => Err(too_large("bytes of stack", STACK as u64)),
    }
}

/// Looks first as if no event ever had to wait, which is true of most nets.
pub(super) fn in_spaces<T>(
    closed: &Closed<'_>,
    limits: &Limits,
    look: impl Fn(&Space<'_>) -> Grown<Looked<T>>,
) -> Grown<Result<T, Fault>> {
    let begun = Instant::now();
    for waiting in [0, closed.max_waiting()] {
        let space = Space::new(closed, waiting, limits, begun)?;
        match look(&space)? {
            Looked::All(all) => return Ok(Ok(all)),
            Looked::Fault(fault) => return Ok(Err(fault)),
            Looked::Waits => {}
        }
    }
    unreachable!("there are variables for all that may wait")
}
