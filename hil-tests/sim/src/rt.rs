//! Real-time priority and clock for the simulators' own threads.
//!
//! Simulated devices must run above the programs they are tested with, so that a starved simulator is not mistaken for
//! a faulty device. Without the privilege they run at normal priority and say so.

use std::fmt;
use std::io;

use rustix::time::{ClockId, clock_gettime};

/// Now, on the clock that robots have: `CLOCK_BOOTTIME`.
#[must_use]
pub fn monotonic_ns() -> u64 {
    let now = clock_gettime(ClockId::Boottime);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// How a thread is scheduled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Policy {
    /// SCHED_FIFO with its priority.
    Fifo(u8),
    /// Anything that is not real-time.
    Normal,
}

/// What a thread asked for and what the kernel says it has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Granted {
    /// Read back from the kernel after asking.
    pub policy: Policy,
    /// Why the wish was not granted.
    pub refused: Option<String>,
}

impl fmt::Display for Granted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.policy {
            Policy::Fifo(priority) => write!(f, "SCHED_FIFO {priority}")?,
            Policy::Normal => f.write_str("normal scheduling")?,
        }
        match &self.refused {
            Some(reason) => write!(f, " ({reason})"),
            None => Ok(()),
        }
    }
}

/// Gives the calling thread SCHED_FIFO with this priority (1 to 99) if permitted; threads it starts do not
/// inherit it.
#[must_use]
pub fn promote(priority: u8) -> Granted {
    let refused = set_fifo(priority).err().map(|error| {
        format!(
            "SCHED_FIFO {priority} refused: {error}; grant CAP_SYS_NICE or raise the rtprio limit"
        )
    });
    Granted {
        policy: current_policy(),
        refused,
    }
}

// The system call, not the C library's wrapper: it acts on the calling thread under every libc.
fn set_fifo(priority: u8) -> io::Result<()> {
    // SAFETY: all-zero bytes are a valid value of every field, also of those that some targets add.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    parameters.sched_priority = i32::from(priority);
    let policy = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
    // SAFETY: thread 0 is the caller, and the pointer outlives the call.
    let result = unsafe {
        libc::syscall(
            libc::SYS_sched_setscheduler,
            0,
            policy,
            &raw const parameters,
        )
    };
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

fn current_policy() -> Policy {
    // SAFETY: takes no pointer; thread 0 is the caller.
    let policy = unsafe { libc::syscall(libc::SYS_sched_getscheduler, 0) };
    // SAFETY: all-zero bytes are a valid value.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    // SAFETY: the pointer is valid for writes for the time of the call.
    let read = unsafe { libc::syscall(libc::SYS_sched_getparam, 0, &raw mut parameters) };
    let fifo = libc::c_long::from(libc::SCHED_FIFO);
    if read == 0 && policy & !libc::c_long::from(libc::SCHED_RESET_ON_FORK) == fifo {
        Policy::Fifo(parameters.sched_priority.clamp(0, 99) as u8)
    } else {
        Policy::Normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_what_was_granted() {
        let granted = std::thread::spawn(|| promote(3)).join().unwrap();
        match granted.policy {
            Policy::Fifo(priority) => assert_eq!((priority, granted.refused), (3, None)),
            Policy::Normal => assert!(granted.refused.is_some()),
        }
    }

    #[test]
    fn impossible_priority_is_refused() {
        let granted = std::thread::spawn(|| promote(200)).join().unwrap();
        assert_eq!(granted.policy, Policy::Normal);
        assert!(granted.to_string().contains("refused"), "{granted}");
    }

    #[test]
    fn clock_advances() {
        let before = monotonic_ns();
        assert!(before > 0 && monotonic_ns() >= before);
    }
}
