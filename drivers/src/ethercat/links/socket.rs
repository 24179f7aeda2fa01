//! The socket beneath both links.

use crate::clock::left_until;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::{RecvFlags, SendFlags};
use std::io;
use std::os::fd::{AsFd, OwnedFd};

/// A non-blocking datagram socket with receive deadlines.
pub struct Socket(pub OwnedFd);

/// The system has no room for a frame now, as when the interface's queue is full: that frame is lost, and the next one may not
/// be.
const NO_ROOM: [Errno; 3] = [Errno::NOBUFS, Errno::NOMEM, Errno::WOULDBLOCK];

/// What becomes of a frame that the system did not take: where it has no room for it now, the frame is lost as on a wire, which the
/// exchange finds out; any other error is the link's, as when the interface is gone.
///
/// # Errors
/// That error.
pub fn refused(error: io::Error) -> io::Result<()> {
    match Errno::from_io_error(&error) {
        Some(errno) if NO_ROOM.contains(&errno) => Ok(()),
        _ => Err(error),
    }
}

impl Socket {
    /// Sends the frame, or loses it.
    pub fn send(&self, data: &[u8]) -> io::Result<()> {
        loop {
            match rustix::net::send(&self.0, data, SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
                Ok(sent) if sent == data.len() => return Ok(()),
                Ok(_) => return Err(io::ErrorKind::WriteZero.into()),
                Err(Errno::INTR) => {}
                Err(error) => return refused(error.into()),
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
            if self.poll(deadline_ns)?.is_none() {
                return Ok(None);
            }
        }
    }

    /// Waits until there may be something in a ring of received frames. `false` at the deadline.
    ///
    /// # Errors
    /// The link's.
    pub fn wait(&self, deadline_ns: u64) -> io::Result<bool> {
        let Some(events) = self.poll(deadline_ns)? else {
            return Ok(false);
        };
        if events.contains(PollFlags::ERR)
            && let Err(error) = rustix::net::recv(&self.0, &mut [0; 0], RecvFlags::DONTWAIT)
            && error != Errno::WOULDBLOCK
        {
            return Err(error.into());
        }
        Ok(true)
    }

    /// Waits for data or for an error that `recv` reports. `None` when the deadline had come before.
    fn poll(&self, deadline_ns: u64) -> io::Result<Option<PollFlags>> {
        let Some(left) = left_until(deadline_ns) else {
            return Ok(None);
        };
        let mut wanted = [PollFd::from_borrowed_fd(self.0.as_fd(), PollFlags::IN)];
        match poll(&mut wanted, Some(&left)) {
            Ok(_) => Ok(Some(wanted[0].revents())),
            Err(Errno::INTR) => Ok(Some(PollFlags::empty())),
            Err(error) => Err(error.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixDatagram;

    #[test]
    fn a_frame_that_the_system_has_no_room_for_is_lost_and_no_error() {
        let (ours, theirs) = UnixDatagram::pair().expect("two sockets");
        let socket = Socket(ours.into());
        let sent = 10_000;
        for _ in 0..sent {
            socket.send(&[7; 64]).expect("sent or lost");
        }
        theirs.set_nonblocking(true).expect("a socket");
        let mut received = 0;
        while theirs.recv(&mut [0; 64]).is_ok() {
            received += 1;
        }
        assert!((1..sent).contains(&received), "{received}");
        socket.send(&[7; 64]).expect("sent");
        assert_eq!(theirs.recv(&mut [0; 64]).expect("there is room again"), 64);
    }
}
