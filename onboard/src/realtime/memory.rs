//! Memory of a real-time process: locked, populated, stacks prefaulted, page faults counted.

use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, getrlimit};
use rustix::thread::{CapabilitySet, capabilities};

/// Stack of each thread. Of those that begin before memory is populated all of it is resident from then on; a real-time thread
/// begins later, and touches 128 KiB of it itself.
pub const STACK_BYTES: usize = 1 << 20;
/// Stack that a real-time thread touches before it is promoted.
const PREFAULTED_STACK: usize = 128 * 1024;
/// Locked memory that the process needs; half the limit on its resident size.
const NEEDED_LOCKED_BYTES: u64 = 64 << 20;
/// Pages that were touched stay.
static LOCKED: AtomicBool = AtomicBool::new(false);

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
    // For who may lock memory there is no limit (capabilities(7)).
    let may_lock =
        capabilities(None).is_ok_and(|own| own.effective.contains(CapabilitySet::IPC_LOCK));
    if !is_enough(limit, may_lock) {
        return MemoryLock::NotLocked(format!(
            "memory is not locked: the limit is {} KiB, {} KiB are needed; grant it with `ulimit -l unlimited` or \
             `@realtime - memlock unlimited` in /etc/security/limits.conf",
            limit.unwrap_or(0) / 1024,
            NEEDED_LOCKED_BYTES / 1024
        ));
    }
    match mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT) {
        Ok(()) => {
            LOCKED.store(true, Ordering::Relaxed);
            MemoryLock::Locked
        }
        Err(error) => MemoryLock::NotLocked(format!(
            "memory is not locked ({error}); grant CAP_IPC_LOCK or raise `ulimit -l`"
        )),
    }
}

fn is_enough(limit: Option<u64>, may_lock: bool) -> bool {
    may_lock || limit.is_none_or(|bytes| bytes >= NEEDED_LOCKED_BYTES)
}

/// Populates what was allocated since, where memory is locked: real-time threads get new parts, of which nobody has touched all pages.
pub fn populate_new_memory() {
    if LOCKED.load(Ordering::Relaxed)
        && let Err(why) = populate_memory()
    {
        tracing::warn!("{why}");
    }
}

/// Populates all pages that the process has by now, those too that only a fault would touch: call it when everything is composed,
/// before real-time threads begin. What is mapped later is locked when it is touched, as by [`lock_memory`].
///
/// # Errors
/// In words: those pages are not there before they are needed.
pub fn populate_memory() -> Result<(), String> {
    // Without `ONFAULT` present mappings are populated; the second call concerns those to come only.
    mlockall(MlockAllFlags::CURRENT)
        .and_then(|()| mlockall(MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT))
        .map_err(|error| {
            format!("memory is not populated ({error}); grant CAP_IPC_LOCK or raise `ulimit -l`")
        })
}

/// Page faults of the calling thread since it began, those that waited for a disk and those that did not.
#[must_use]
pub fn page_faults() -> u64 {
    // SAFETY: a structure of numbers, for which zero is valid.
    let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
    // SAFETY: `usage` outlives the call, which fills it.
    let result = unsafe { libc::getrusage(libc::RUSAGE_THREAD, &raw mut usage) };
    if result == 0 {
        (usage.ru_minflt + usage.ru_majflt) as u64
    } else {
        0
    }
}

/// The same of any thread of this machine; `None` when it has ended.
#[must_use]
pub fn page_faults_of(thread: u64) -> Option<u64> {
    /// Fields of `/proc/PID/task/TID/stat` behind the name, which may hold anything: the 10th and 12th of all (proc(5)).
    const FAULTS: [usize; 2] = [7, 9];
    let stat = fs::read_to_string(format!("/proc/{thread}/task/{thread}/stat")).ok()?;
    let (_, fields) = stat.rsplit_once(") ")?;
    let fields: Vec<&str> = fields.split(' ').collect();
    FAULTS
        .iter()
        .map(|&field| fields.get(field)?.parse::<u64>().ok())
        .sum()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_the_right_needs_no_limit() {
        let asked = [
            (Some(8 << 20), false),
            (Some(8 << 20), true),
            (Some(64 << 20), false),
            (None, false),
        ];
        let enough = asked.map(|(limit, may_lock)| is_enough(limit, may_lock));
        assert_eq!(enough, [false, true, true, true]);
    }

    #[test]
    fn page_faults_are_counted_where_they_happen() {
        let thread = rustix::thread::gettid().as_raw_nonzero().get() as u64;
        let before = page_faults();
        let bytes = 64 * 4096;
        let touched = std::hint::black_box(vec![1_u8; bytes]);
        assert_eq!(touched.len(), bytes);
        let (own, of_thread) = (page_faults(), page_faults_of(thread).expect("it runs"));
        assert!(
            own >= before && of_thread >= own,
            "{before} {own} {of_thread}"
        );
        assert_eq!(page_faults_of(u64::from(u32::MAX)), None);
    }
    #[test]
    fn pages_that_nobody_has_touched_are_there_once_memory_is_populated() {
        const PAGES: usize = 1024;
        // So much comes from the kernel, untouched.
        let mut bytes: Vec<u8> = Vec::with_capacity(PAGES * 4096);
        if populate_memory().is_err() {
            eprintln!("SKIPPED: needs CAP_IPC_LOCK or a higher `ulimit -l`");
            return;
        }
        let before = page_faults();
        bytes.resize(PAGES * 4096, 1);
        let faults = page_faults() - before;
        rustix::mm::munlockall().expect("unlocked");
        assert!(
            std::hint::black_box(bytes)[4096] == 1 && faults < 16,
            "{faults}"
        );
    }
}
