//! The desk's thread: between the socket and the desk. It has normal priority, and nobody waits for it.

use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::mpsc::Receiver;
use std::thread::{Builder, JoinHandle};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::desk::Desk;
use crate::process::ctl::Guest;
use crate::realtime::clock::{MILLISECOND_NS, now_ns};
use crate::realtime::memory::STACK_BYTES;

/// The desk says that it lives at least this often.
pub const BEAT_NS: u64 = 20 * MILLISECOND_NS;
/// The same, for who waits for the other end.
const BEAT: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: BEAT_NS as i64,
};
/// How often it says what the robot does.
const STATUS_NS: u64 = 100 * MILLISECOND_NS;
/// The longest line that is read.
const LONGEST_LINE: usize = 256;

/// Starts the thread. It ends when nobody can send guests any more.
///
/// # Errors
/// The system starts no thread.
pub fn spawn(mut desk: Desk, guests: Receiver<Guest>) -> io::Result<JoinHandle<()>> {
    let thread = Builder::new().name("teleop".to_owned());
    thread.stack_size(STACK_BYTES).spawn(move || {
        for guest in guests {
            desk.open(guest.session, guest.teleop, now_ns());
            let over = Wire::of(guest.stream).and_then(|mut wire| serve(&mut desk, &mut wire));
            desk.close(now_ns());
            if let Err(error) = over {
                tracing::debug!("teleop: the connection is gone: {error}");
            }
        }
    })
}

/// Serves one session until it is over, or the connection is.
fn serve(desk: &mut Desk, wire: &mut Wire) -> io::Result<()> {
    let mut status_ns = 0;
    loop {
        let open = wire.receive()?;
        let now_ns = now_ns();
        // Only the newest wish counts, and each of them must be one.
        let heard = wire
            .lines()
            .try_for_each(|line| desk.hear_line(&line, now_ns));
        let looked = heard.and_then(|()| desk.look(now_ns));
        match looked {
            Ok(status) if now_ns.saturating_sub(status_ns) >= STATUS_NS => {
                status_ns = now_ns;
                wire.say(&status)?;
            }
            Ok(_) => {}
            Err(over) => return wire.say(&over),
        }
        if !open {
            return Ok(());
        }
    }
}

/// The connection, without blocking.
struct Wire {
    stream: UnixStream,
    read: Vec<u8>,
    unsent: Vec<u8>,
}

impl Wire {
    fn of(stream: UnixStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self {
            stream,
            read: Vec::new(),
            unsent: Vec::new(),
        })
    }

    /// Takes in what has come, after waiting for at most [`BEAT`]; `false` when the other end has closed.
    fn receive(&mut self) -> io::Result<bool> {
        let mut ready = [PollFd::new(&self.stream, PollFlags::IN)];
        match poll(&mut ready, Some(&BEAT)) {
            Ok(0) | Err(rustix::io::Errno::INTR) => return Ok(true),
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let mut bytes = [0; 4096];
        match self.stream.read(&mut bytes) {
            Ok(0) => Ok(false),
            Ok(count) => {
                self.read.extend_from_slice(&bytes[..count]);
                if self.read.len() > bytes.len() + LONGEST_LINE {
                    return Err(ErrorKind::InvalidData.into());
                }
                Ok(true)
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(true),
            Err(error) => Err(error),
        }
    }

    /// Whole lines that have come.
    fn lines(&mut self) -> impl Iterator<Item = String> + use<> {
        let whole = self.read.iter().rposition(|&byte| byte == b'\n');
        let rest = self.read.split_off(whole.map_or(0, |end| end + 1));
        let lines = std::mem::replace(&mut self.read, rest);
        let text = String::from_utf8_lossy(&lines).into_owned();
        text.lines()
            .map(str::to_owned)
            .collect::<Vec<_>>()
            .into_iter()
    }

    /// Says something, unless the other end has not read what was said before: then that is left out.
    fn say(&mut self, what: &impl serde::Serialize) -> io::Result<()> {
        self.flush()?;
        if self.unsent.is_empty() {
            serde_json::to_writer(&mut self.unsent, what)?;
            self.unsent.push(b'\n');
        }
        self.flush()
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.stream.write(&self.unsent) {
            Ok(count) => {
                self.unsent.drain(..count);
                Ok(())
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(()),
            Err(error) => Err(error),
        }
    }
}
