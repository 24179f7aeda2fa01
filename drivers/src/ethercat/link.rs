//! What carries Ethernet frames between MainDevice and segment.

use super::clock::left_until;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::{RecvFlags, SendFlags};
use std::io;
use std::os::fd::{AsFd, OwnedFd};

/// Carries Ethernet frames to an EtherCAT segment and back.
///
/// # Real-time contract
/// Implementations do not allocate, lock or log in [`send`](Link::send) and [`receive`](Link::receive), and make no
/// system call but those of their own device.
pub trait Link: Send {
    /// Sends one Ethernet frame (destination, source, ethertype `0x88A4`, EtherCAT frame) without waiting.
    fn send(&mut self, ethernet_frame: &[u8]) -> io::Result<()>;

    /// Waits for one Ethernet frame until `deadline_ns` (`CLOCK_MONOTONIC`) and returns its length, or `None` at the
    /// deadline. What has already arrived is returned even when the deadline has passed.
    ///
    /// A frame that comes from the segment has the locally-administered bit of its source address set.
    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>>;

    /// What this link is, for messages: "interface eth0", "UDP 127.0.0.1:34980".
    fn describe(&self) -> String;
}

/// Why a link cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The interface does not exist.
    #[error("no network interface {interface:?}; this machine has: {available}")]
    NoSuchInterface {
        /// As asked for.
        interface: String,
        /// What exists, separated by commas.
        available: String,
    },
    /// The interface exists but is down.
    #[error(
        "network interface {interface:?} is down; bring it up with `ip link set {interface} up`"
    )]
    InterfaceDown {
        /// As asked for.
        interface: String,
    },
    /// The process may not open raw sockets.
    #[error(
        "not allowed to send raw Ethernet frames on {interface:?}: CAP_NET_RAW is missing; grant it to the program \
         with `sudo setcap cap_net_raw+ep <path of the program>`, or start it as root"
    )]
    NotPermitted {
        /// As asked for.
        interface: String,
    },
    /// The system refused something else.
    #[error("cannot open {link}: {step}: {source}")]
    System {
        /// The link, as [`Link::describe`] names it.
        link: String,
        /// What was tried.
        step: &'static str,
        /// What the system answered.
        source: io::Error,
    },
}

/// A non-blocking datagram socket with receive deadlines.
pub(super) struct Socket(pub(super) OwnedFd);

impl Socket {
    pub(super) fn send(&self, data: &[u8]) -> io::Result<()> {
        loop {
            match rustix::net::send(&self.0, data, SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
                Ok(sent) if sent == data.len() => return Ok(()),
                Ok(_) => return Err(io::ErrorKind::WriteZero.into()),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    pub(super) fn receive(&self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>> {
        loop {
            // `MSG_TRUNC` is not set: a datagram longer than the buffer arrives cut and fails the checks behind.
            match rustix::net::recv(&self.0, &mut *buffer, RecvFlags::DONTWAIT) {
                Ok((received, _)) => return Ok(Some(received)),
                Err(Errno::WOULDBLOCK) => {}
                Err(Errno::INTR) => continue,
                Err(error) => return Err(error.into()),
            }
            let Some(left) = left_until(deadline_ns) else {
                return Ok(None);
            };
            let mut wanted = [PollFd::from_borrowed_fd(self.0.as_fd(), PollFlags::IN)];
            match poll(&mut wanted, Some(&left)) {
                // The deadline, or data, or an error that `recv` reports.
                Ok(_) | Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}
