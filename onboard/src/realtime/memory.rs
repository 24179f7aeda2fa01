//! Memory of a real-time process: locked on fault, stacks prefaulted.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, getrlimit};

/// Stack that a real-time thread touches before it is promoted.
const PREFAULTED_STACK: usize = 128 * 1024;
/// Locked memory that the process needs; half the limit on its resident size.
const NEEDED_LOCKED_BYTES: u64 = 64 << 20;

/// Whether pages stay in memory once touched, and if not, what to grant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MemoryLock {
    /// Pages that were touched stay.
    Locked,
    /// They may be swapped out: the reason, and what to grant.
    NotLocked(String),
}

/// Locks present and future pages on fault, after checking the limit, because a lock under a low limit makes
/// later allocations fail.
#[must_use]
pub fn lock_memory() -> MemoryLock {
    let limit = getrlimit(Resource::Memlock).current;
    let enough = limit.is_none_or(|bytes| bytes >= NEEDED_LOCKED_BYTES);
    if !enough && !rustix::process::geteuid().is_root() {
        return MemoryLock::NotLocked(format!(
            "memory is not locked: the limit is {} KiB, {} KiB are needed; grant it with `ulimit -l unlimited` or \
             `@realtime - memlock unlimited` in /etc/security/limits.conf",
            limit.unwrap_or(0) / 1024,
            NEEDED_LOCKED_BYTES / 1024
        ));
    }
    match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT) {
        Ok(()) => MemoryLock::Locked,
        Err(error) => MemoryLock::NotLocked(format!(
            "memory is not locked ({error}); grant CAP_IPC_LOCK or raise `ulimit -l`"
        )),
    }
}

/// Touches the stack that a real-time loop will use, so that it faults now and not there.
#[inline(never)]
pub fn prefault_stack() {
    let mut stack = [0_u8; PREFAULTED_STACK];
    for page in stack.chunks_mut(4096) {
        page[0] = 1;
    }
    std::hint::black_box(&stack);
}
