//! Which system calls a real-time thread may make, and the filter that tells the kernel.

use std::fmt;
use std::mem::{offset_of, size_of};

use libc::{
    BPF_ABS, BPF_ALU, BPF_AND, BPF_JEQ, BPF_JMP, BPF_K, BPF_LD, BPF_RET, BPF_W, c_long, sock_filter,
};
use rustix::fd::BorrowedFd;
use rustix::fs::FileType;

/// A call that a real-time thread may make.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// As in its manual page.
    pub name: &'static str,
    /// On this processor.
    pub number: c_long,
    /// With what.
    pub when: When,
}

/// What a call must be made with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// With anything.
    Always,
    /// With a time at which it is over, in the argument of this index.
    Bounded(usize),
    /// To wake others, or to wait for them until a time. Who waits for a lock that another thread has names no time.
    Futex,
    /// For a device or a socket, and not for what programs print. The kernel's filter does not see what a descriptor is, so the
    /// thread waits until somebody has looked.
    Device,
}

const fn allowed(name: &'static str, number: c_long, when: When) -> Allowed {
    Allowed { name, number, when }
}

/// What a real-time thread may call in state running, and for what.
pub const ALLOWED: &[Allowed] = &[
    // Its sleep, to an absolute time.
    allowed("clock_nanosleep", libc::SYS_clock_nanosleep, When::Always),
    // Waking who waits for its scan, and waiting for one.
    allowed("futex", libc::SYS_futex, When::Futex),
    // Waiting for its own device, to a deadline.
    allowed("ppoll", libc::SYS_ppoll, When::Bounded(2)),
    // Its own device: frames, and bytes of the lidar.
    allowed("sendto", libc::SYS_sendto, When::Always),
    allowed("recvfrom", libc::SYS_recvfrom, When::Always),
    // On 32-bit ARM these have calls of their own.
    #[cfg(target_arch = "arm")]
    allowed("send", libc::SYS_send, When::Always),
    #[cfg(target_arch = "arm")]
    allowed("recv", libc::SYS_recv, When::Always),
    allowed("read", libc::SYS_read, When::Always),
    // Seldom: what it asks of the lidar.
    allowed("write", libc::SYS_write, When::Device),
    // What it waits in goes on by this, in the kernel's own hand, when the process was stopped by a signal meanwhile.
    allowed("restart_syscall", libc::SYS_restart_syscall, When::Always),
    // The time, where the kernel has no page for it.
    allowed("clock_gettime", libc::SYS_clock_gettime, When::Always),
    // The same with times of 64 bits, where that is another call: one number on every such processor, which the crate `libc` does not
    // know for all of them (Linux, `include/uapi/asm-generic/unistd.h`).
    #[cfg(target_pointer_width = "32")]
    allowed("clock_gettime64", 403, When::Always),
    #[cfg(target_pointer_width = "32")]
    allowed("clock_nanosleep_time64", 407, When::Always),
    #[cfg(target_pointer_width = "32")]
    allowed("ppoll_time64", 414, When::Bounded(2)),
    #[cfg(target_pointer_width = "32")]
    allowed("futex_time64", 422, When::Futex),
];

impl When {
    /// Whether a call that the filter asks about is one of these after all.
    pub(super) fn is_met(self, arguments: &[u64]) -> bool {
        self == Self::Device && arguments.first().is_some_and(|&it| is_device(it))
    }
}

impl fmt::Display for When {
    /// What else it must be made with, behind the call's name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Always => "",
            Self::Bounded(_) => " with a deadline",
            Self::Futex => " to wake, or to wait to a deadline, which is none for a lock",
            Self::Device => " to its device",
        })
    }
}

/// Whether the descriptor of this number is that of a device or a socket, and not a standard stream.
fn is_device(descriptor: u64) -> bool {
    const LAST_STANDARD_STREAM: i32 = 2;
    let number = i32::try_from(descriptor).ok();
    number.is_some_and(|number| {
        // SAFETY: the thread that waits for the answer has it open, or the call fails.
        let stat = rustix::fs::fstat(unsafe { BorrowedFd::borrow_raw(number) });
        let kind = stat.map(|stat| FileType::from_raw_mode(stat.st_mode));
        let is_device = matches!(kind, Ok(FileType::CharacterDevice | FileType::Socket));
        number > LAST_STANDARD_STREAM && is_device
    })
}

const PASS: sock_filter = answer(libc::SECCOMP_RET_ALLOW);
const ASK: sock_filter = answer(libc::SECCOMP_RET_USER_NOTIF);

const fn answer(k: u32) -> sock_filter {
    instruction(BPF_RET | BPF_K, k, [0, 0])
}

/// Of jumps: how many instructions to leave out if it holds, and if not.
const fn instruction(code: u32, k: u32, [jt, jf]: [u8; 2]) -> sock_filter {
    sock_filter {
        code: code as u16,
        jt,
        jf,
        k,
    }
}

const fn load(offset: usize) -> sock_filter {
    instruction(BPF_LD | BPF_W | BPF_ABS, offset as u32, [0, 0])
}

/// The halves of an argument, which has 64 bits on every processor: what every call uses first.
const fn halves(argument: usize) -> [sock_filter; 2] {
    let start = offset_of!(libc::seccomp_data, args) + argument * size_of::<u64>();
    let half = size_of::<u32>();
    if cfg!(target_endian = "little") {
        [load(start), load(start + half)]
    } else {
        [load(start + half), load(start)]
    }
}

const fn if_equal(k: u32, then_skip: u8, else_skip: u8) -> sock_filter {
    instruction(BPF_JMP | BPF_JEQ | BPF_K, k, [then_skip, else_skip])
}

/// Calls that are allowed pass, and all others ask.
pub(super) fn filter() -> Vec<sock_filter> {
    let mut filter = vec![load(offset_of!(libc::seccomp_data, nr))];
    for call in ALLOWED {
        let verdict = verdict(call.when);
        let length = u8::try_from(verdict.len()).expect("a few instructions");
        filter.push(if_equal(call.number as u32, 0, length));
        filter.extend(verdict);
    }
    filter.push(ASK);
    filter
}

/// Of a call that has been recognised.
fn verdict(when: When) -> Vec<sock_filter> {
    match when {
        When::Always => vec![PASS],
        When::Device => vec![ASK],
        When::Bounded(argument) => {
            let [low, high] = halves(argument);
            vec![low, if_equal(0, 0, 2), high, if_equal(0, 1, 0), PASS, ASK]
        }
        When::Futex => {
            let (operation, deadline) = (1, 3);
            let flags = (libc::FUTEX_PRIVATE_FLAG | libc::FUTEX_CLOCK_REALTIME).cast_unsigned();
            let mut verdict = vec![
                halves(operation)[0],
                instruction(BPF_ALU | BPF_AND | BPF_K, !flags, [0, 0]),
                if_equal(libc::FUTEX_WAKE.cast_unsigned(), 5, 0),
                if_equal(libc::FUTEX_WAIT_BITSET.cast_unsigned(), 0, 5),
            ];
            verdict.extend(self::verdict(When::Bounded(deadline)));
            verdict
        }
    }
}
