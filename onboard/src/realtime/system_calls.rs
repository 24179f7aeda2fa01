//! The guard of system calls: proof, in the running program, that real-time threads make none but their own.
//!
//! When the environment variable [`ENVIRONMENT_VARIABLE`] is set, each real-time thread gives the kernel a filter (seccomp). Calls
//! of [`ALLOWED`] pass at full speed. Every other one waits until a thread of this process has looked: inside
//! [`guard::real_time`] it aborts the process and says which thread called what; outside, while a bus is
//! brought up or a device opened, the call goes on. A call is judged by its number: what it reads or writes is not looked at.

use std::io;
use std::mem::offset_of;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::sync::mpsc;

use libc::{BPF_ABS, BPF_JEQ, BPF_JMP, BPF_K, BPF_LD, BPF_RET, BPF_W, c_long, sock_filter};

use super::guard::{self, Mark};

/// Set to anything but `0` to arm the guard.
pub const ENVIRONMENT_VARIABLE: &str = "ONBOARD_SYSTEM_CALL_GUARD";

/// What a real-time thread may call in state running, and for what.
pub const ALLOWED: &[(&str, c_long)] = &[
    // Its sleep, to an absolute time.
    ("clock_nanosleep", libc::SYS_clock_nanosleep),
    // Waking who waits for its scan, and waiting for one.
    ("futex", libc::SYS_futex),
    // Waiting for its own device, to a deadline.
    ("ppoll", libc::SYS_ppoll),
    // Its own device: frames, and bytes of the lidar.
    ("sendto", libc::SYS_sendto),
    ("recvfrom", libc::SYS_recvfrom),
    // On 32-bit ARM these have calls of their own.
    #[cfg(target_arch = "arm")]
    ("send", libc::SYS_send),
    #[cfg(target_arch = "arm")]
    ("recv", libc::SYS_recv),
    ("read", libc::SYS_read),
    ("write", libc::SYS_write),
    // The time, where the kernel has no page for it.
    ("clock_gettime", libc::SYS_clock_gettime),
    // The same with times of 64 bits, where that is another call: one number on every such processor, which the crate `libc` does not
    // know for all of them (Linux, `include/uapi/asm-generic/unistd.h`).
    #[cfg(target_pointer_width = "32")]
    ("clock_gettime64", 403),
    #[cfg(target_pointer_width = "32")]
    ("clock_nanosleep_time64", 407),
    #[cfg(target_pointer_width = "32")]
    ("ppoll_time64", 414),
    #[cfg(target_pointer_width = "32")]
    ("futex_time64", 422),
];

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
    // It begins before there is a filter, which it would inherit.
    let (sender, receiver) = mpsc::channel();
    std::thread::Builder::new()
        .name("system-calls".to_owned())
        .spawn(move || {
            if let Ok(listener) = receiver.recv() {
                let watched = Watched {
                    name,
                    running,
                    listener,
                };
                watched.watch();
            }
        })?;
    let listener = filter_this_thread()?;
    sender
        .send(listener)
        .map_err(|_| io::Error::other("the thread that looks has ended"))
}

/// `seccomp(2)` for this thread alone.
fn filter_this_thread() -> io::Result<OwnedFd> {
    let mut filter = program();
    let program = libc::sock_fprog {
        len: u16::try_from(filter.len()).expect("a few instructions for each allowed call"),
        filter: filter.as_mut_ptr(),
    };
    // SAFETY: plain numbers; it lets a thread without privileges filter itself.
    if unsafe { libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the kernel copies the program, which outlives the call.
    let listener = unsafe {
        libc::syscall(
            libc::SYS_seccomp,
            libc::SECCOMP_SET_MODE_FILTER,
            libc::SECCOMP_FILTER_FLAG_NEW_LISTENER,
            &raw const program,
        )
    };
    match i32::try_from(listener) {
        // SAFETY: a new file descriptor that nothing else knows.
        Ok(listener) if listener >= 0 => Ok(unsafe { OwnedFd::from_raw_fd(listener) }),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Allowed numbers pass, and all others ask.
fn program() -> Vec<sock_filter> {
    let instruction = |code: u32, k: u32, skip_if_not: u8| sock_filter {
        code: code as u16,
        jt: 0,
        jf: skip_if_not,
        k,
    };
    let number = offset_of!(libc::seccomp_data, nr) as u32;
    let mut program = vec![instruction(BPF_LD | BPF_W | BPF_ABS, number, 0)];
    for (_, call) in ALLOWED {
        program.push(instruction(BPF_JMP | BPF_JEQ | BPF_K, *call as u32, 1));
        program.push(instruction(BPF_RET | BPF_K, libc::SECCOMP_RET_ALLOW, 0));
    }
    program.push(instruction(
        BPF_RET | BPF_K,
        libc::SECCOMP_RET_USER_NOTIF,
        0,
    ));
    program
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
        // SAFETY: that thread waits for the answer.
        if unsafe { self.running.holds() } {
            eprintln!(
                "guard of system calls: real-time thread {} made call {} in state running; allowed are {}",
                self.name,
                asked.data.nr,
                ALLOWED
                    .iter()
                    .map(|(name, _)| *name)
                    .collect::<Vec<_>>()
                    .join(", ")
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
