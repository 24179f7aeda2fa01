//! The guard of system calls: proof, in the running program, that real-time threads make none but their own.
//!
//! When the environment variable [`ENVIRONMENT_VARIABLE`] is set, each real-time thread gives the kernel a filter (seccomp). Calls
//! of [`rules::ALLOWED`] pass at full speed, but for a write, of which only this process can see to what it goes. Every other one waits
//! until a thread of this process has looked: inside [`guard::real_time`] it aborts the process and says which thread called what;
//! outside, while a bus is brought up or a device opened, the call goes on. So a lock ends the program that another thread has just
//! then, and a line that is printed: both are calls made with other things than the [rules] say.

pub mod rules;

use std::io;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};
use std::time::Duration;

use super::guard::{self, Mark};
use rules::ALLOWED;

/// Set to anything but `0` to arm the guard.
pub const ENVIRONMENT_VARIABLE: &str = "ONBOARD_SYSTEM_CALL_GUARD";

/// Instead of a descriptor: there is none yet, or there will be none, as the system calls say it.
const NOT_YET: i32 = -2;
const NONE: i32 = -1;
/// How often a thread that is to look asks for it.
const HANDED_OVER_WITHIN: Duration = Duration::from_millis(1);

/// Whether the environment asks for the guard.
#[must_use]
pub fn wanted() -> bool {
    std::env::var_os(ENVIRONMENT_VARIABLE).is_some_and(|value| value != "0")
}

/// Guards the calling thread from now on, for good. Not for a thread that runs already: it makes a thread that looks.
///
/// # Errors
/// The kernel's, when it has no such filters (before Linux 5.5), and the operating system's, when it has no thread to give.
pub fn guard_this_thread(name: &str) -> io::Result<()> {
    let (name, running) = (name.to_owned(), guard::mark());
    let handed_over = Arc::new(AtomicI32::new(NOT_YET));
    let handed_to = Arc::clone(&handed_over);
    // It begins before there is a filter, which it would inherit.
    std::thread::Builder::new()
        .name("system-calls".to_owned())
        .spawn(move || {
            let listener = loop {
                match handed_to.load(Ordering::Acquire) {
                    NOT_YET => std::thread::sleep(HANDED_OVER_WITHIN),
                    NONE => return,
                    // SAFETY: a new file descriptor that nothing else knows.
                    listener => break unsafe { OwnedFd::from_raw_fd(listener) },
                }
            };
            let watched = Watched {
                name,
                running,
                listener,
            };
            watched.watch();
        })?;
    filter_this_thread(&handed_over)
}

/// `seccomp(2)` for this thread alone. The listener goes to who looks in `handed_over`. From the filter to there nothing may be called that
/// could be a system call, not even to allocate or release: nobody looks yet, and the thread would wait for ever.
fn filter_this_thread(handed_over: &AtomicI32) -> io::Result<()> {
    let mut filter = rules::filter();
    let program = libc::sock_fprog {
        len: u16::try_from(filter.len()).expect("a few instructions for each allowed call"),
        filter: filter.as_mut_ptr(),
    };
    // SAFETY: plain numbers; it lets a thread without privileges filter itself.
    let may = unsafe { libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) } == 0;
    // SAFETY: the kernel copies the program, which outlives the call.
    let result = may.then(|| unsafe {
        libc::syscall(
            libc::SYS_seccomp,
            libc::SECCOMP_SET_MODE_FILTER,
            libc::SECCOMP_FILTER_FLAG_NEW_LISTENER,
            &raw const program,
        )
    });
    let listener = result.and_then(|own| i32::try_from(own).ok());
    let listener = listener.unwrap_or(NONE);
    handed_over.store(listener, Ordering::Release);
    if listener == NONE {
        Err(io::Error::last_os_error())
    } else {
        Ok(())
    }
}

/// A thread whose other calls are looked at.
struct Watched {
    name: String,
    running: Mark,
    listener: OwnedFd,
}

impl Watched {
    fn watch(self) {
        let mut ready = libc::pollfd {
            fd: self.listener.as_raw_fd(),
            events: libc::POLLIN,
            revents: 0,
        };
        loop {
            // SAFETY: one entry, which outlives the call.
            let count = unsafe { libc::poll(&raw mut ready, 1, -1) };
            if count > 0 && ready.revents & libc::POLLIN != 0 {
                self.look();
            } else if count > 0 {
                return; // The thread has ended.
            }
        }
    }

    fn look(&self) {
        // SAFETY: a structure of numbers, for which zero is valid; the kernel insists on it.
        let mut asked: libc::seccomp_notif = unsafe { std::mem::zeroed() };
        let listener = self.listener.as_raw_fd();
        // SAFETY: the request's own structure, which outlives the call.
        if unsafe { libc::ioctl(listener, libc::SECCOMP_IOCTL_NOTIF_RECV, &raw mut asked) } != 0 {
            return; // A signal came first; the call will be made again.
        }
        let number = libc::c_long::from(asked.data.nr);
        let rule = ALLOWED.iter().find(|call| call.number == number);
        let is_allowed = rule.is_some_and(|call| call.when.is_met(&asked.data.args));
        // SAFETY: that thread waits for the answer.
        if !is_allowed && unsafe { self.running.holds() } {
            let all: Vec<String> = { ALLOWED.iter() }
                .map(|call| format!("{}{}", call.name, call.when))
                .collect();
            eprintln!(
                "guard of system calls: real-time thread {} made call {number} in state running; allowed are {}",
                self.name,
                all.join(", ")
            );
            std::process::abort();
        }
        let mut answer = libc::seccomp_notif_resp {
            id: asked.id,
            val: 0,
            error: 0,
            flags: libc::SECCOMP_USER_NOTIF_FLAG_CONTINUE as u32,
        };
        // SAFETY: as above. When it fails, a signal has ended the call, which will be made again.
        unsafe { libc::ioctl(listener, libc::SECCOMP_IOCTL_NOTIF_SEND, &raw mut answer) };
    }
}
