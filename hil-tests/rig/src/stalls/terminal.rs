//! How soon the kernel hands on what one end of a terminal writes to its other end, as it does with every byte of a simulated lidar.
//!
//! A worker of the kernel does it, at no real-time priority. Where autogroups (sched(7)) are on and a session keeps all cores busy, it may
//! wait for seconds, whatever the priorities of those at both ends are.

use std::io;
use std::os::fd::OwnedFd;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// A terminal, through which single bytes go.
pub(super) struct Terminal {
    near: OwnedFd,
    far: OwnedFd,
}

impl Terminal {
    pub(super) fn open() -> io::Result<Self> {
        let near = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&near)?;
        unlockpt(&near)?;
        let name = ptsname(&near, Vec::new())?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let far = rustix::fs::open(name, flags, Mode::empty())?;
        let mut settings = tcgetattr(&far)?;
        settings.make_raw();
        tcsetattr(&far, OptionalActions::Now, &settings)?;
        Ok(Self { near, far })
    }

    /// Sends a byte and waits until it has arrived, at most for so long.
    pub(super) fn pass_byte(&self, timeout: Timespec) -> io::Result<()> {
        rustix::io::write(&self.near, b".")?;
        let mut fds = [PollFd::new(&self.far, PollFlags::IN)];
        if poll(&mut fds, Some(&timeout))? == 0 {
            return Ok(());
        }
        // With those that took longer than the time for which they were waited for.
        rustix::io::read(&self.far, &mut [0; 64])?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_arrives_and_none_is_left_behind() {
        let terminal = Terminal::open().expect("a terminal");
        let timeout = Timespec {
            tv_sec: 60,
            tv_nsec: 0,
        };
        for _ in 0..100 {
            terminal.pass_byte(timeout).expect("it is open");
        }
        assert_eq!(rustix::io::ioctl_fionread(&terminal.far), Ok(0));
    }
}
