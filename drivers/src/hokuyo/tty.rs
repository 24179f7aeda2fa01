//! A serial line on a terminal of the system: opened and set by `serialport`, waited for with `poll`, never blocking.
//!
//! Real-time after opening: `wait` and `read` make one system call each and allocate nothing.
//! (Reading through `serialport` would allocate its time-out errors.)

use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};
use std::path::Path;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::io::Errno;
use serialport::{ClearBuffer, SerialPort as _, TTYPort};

use super::error::ConnectError;
use super::serial_line::{Gone, SerialLine, Wait};
use crate::clock::left_until;

const NOW: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 0,
};

/// A serial line on a terminal of the system.
#[derive(Debug)]
pub struct TtyLine {
    tty: TTYPort,
}

impl TtyLine {
    /// Opens `path`, exclusively, with 8 data bits, no parity, 1 stop bit, no flow control.
    ///
    /// # Errors
    /// [`ConnectError::Option`], [`ConnectError::Open`], [`ConnectError::Setup`].
    pub fn open(path: &Path, bit_rate: u32) -> Result<Self, ConnectError> {
        let name = path.to_str().ok_or_else(|| ConnectError::Option {
            option: "device",
            expected: "a path in UTF-8".into(),
            found: path.display().to_string(),
        })?;
        let tty = serialport::new(name, bit_rate)
            .open_native()
            .map_err(|source| ConnectError::Open {
                path: path.into(),
                source,
            })?;
        let port = Self { tty };
        let setup = |errno: Errno| ConnectError::Setup {
            path: path.into(),
            source: errno.into(),
        };
        let flags = fcntl_getfl(port.fd()).map_err(setup)?;
        fcntl_setfl(port.fd(), flags | OFlags::NONBLOCK).map_err(setup)?;
        Ok(port)
    }

    fn fd(&self) -> BorrowedFd<'_> {
        // SAFETY: `tty` owns this descriptor and outlives the borrow.
        unsafe { BorrowedFd::borrow_raw(self.tty.as_raw_fd()) }
    }

    fn wait_for(&self, what: PollFlags, deadline_ns: u64) -> Result<Wait, Gone> {
        loop {
            let left = left_until(deadline_ns);
            let mut fds = [PollFd::from_borrowed_fd(self.fd(), what)];
            match poll(&mut fds, Some(&left.unwrap_or(NOW))) {
                Err(Errno::INTR) if left.is_some() => {}
                Err(Errno::INTR) | Ok(0) => return Ok(Wait::TimedOut),
                Err(_) => return Err(Gone),
                // Bytes that came before a hang-up are still read; the next read reports the hang-up.
                Ok(_) if fds[0].revents().intersects(what) => return Ok(Wait::Ready),
                Ok(_) => return Err(Gone),
            }
        }
    }
}

impl SerialLine for TtyLine {
    /// Non-standard rates are passed on; the terminal's driver decides.
    fn set_bit_rate(&mut self, bit_rate: u32) -> io::Result<()> {
        self.tty.set_baud_rate(bit_rate).map_err(io::Error::from)
    }

    fn clear(&mut self) {
        // If clearing fails, the next read reports the error.
        let _ = self.tty.clear(ClearBuffer::All);
    }

    fn wait(&mut self, deadline_ns: u64) -> Result<Wait, Gone> {
        self.wait_for(PollFlags::IN, deadline_ns)
    }

    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Gone> {
        match rustix::io::read(self.fd(), buffer) {
            Ok(0) => Err(Gone),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(_) => Err(Gone),
        }
    }

    fn write(&mut self, mut bytes: &[u8], deadline_ns: u64) -> Result<bool, Gone> {
        while !bytes.is_empty() {
            match rustix::io::write(self.fd(), bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => {
                    if self.wait_for(PollFlags::OUT, deadline_ns)? == Wait::TimedOut {
                        return Ok(false);
                    }
                }
                Err(_) => return Err(Gone),
            }
        }
        Ok(true)
    }

    fn unsent_bytes(&self) -> u32 {
        self.tty.bytes_to_write().unwrap_or(0)
    }
}

impl Drop for TtyLine {
    fn drop(&mut self) {
        // Closing a port waits until its output is sent, which never happens with a dead device.
        if self.unsent_bytes() > 0 {
            let _ = self.tty.clear(ClearBuffer::Output);
        }
    }
}
