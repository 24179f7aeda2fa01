//! The socket beneath both links.

use crate::clock::left_until;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::{RecvFlags, SendFlags};
use std::io;
use std::os::fd::{AsFd, OwnedFd};

/// A non-blocking datagram socket with receive deadlines.
pub struct Socket(pub OwnedFd);

impl Socket {
    pub fn send(&self, data: &[u8]) -> io::Result<()> {
        loop {
            match rustix::net::send(&self.0, data, SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
                Ok(sent) if sent == data.len() => return Ok(()),
                Ok(_) => return Err(io::ErrorKind::WriteZero.into()),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    pub fn receive(&self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>> {
        loop {
            // `MSG_TRUNC` is not set: a datagram longer than the buffer arrives cut and fails later checks.
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
