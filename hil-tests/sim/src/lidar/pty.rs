//! The host's end of the serial line: a pseudo-terminal, and a symbolic link to it.

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};
use rustix::io::{Errno, ioctl_fionbio, ioctl_fionread};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{
    OptionalActions, QueueSelector, ioctl_tiocnxcl, tcflush, tcgetattr, tcsetattr,
};

/// A pair of terminal ends. The host's end stays open here too, so that its settings outlive a host.
#[derive(Debug)]
pub(super) struct Pty {
    master: OwnedFd,
    slave: OwnedFd,
    path: PathBuf,
}

impl Pty {
    /// Opens a new pair, raw and at this bit rate.
    pub(super) fn open(bit_rate: u32) -> io::Result<Pty> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let path = PathBuf::from(OsStr::from_bytes(name.as_bytes()));
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(&path, flags, Mode::empty())?;
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        settings.set_speed(bit_rate)?;
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        ioctl_fionbio(&master, true)?;
        Ok(Pty {
            master,
            slave,
            path,
        })
    }

    /// Where the host finds its end.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// For polling.
    pub(super) fn fd(&self) -> BorrowedFd<'_> {
        self.master.as_fd()
    }

    /// The bit rate set on the host's end; 0 if it cannot be read.
    pub(super) fn host_bit_rate(&self) -> u32 {
        tcgetattr(&self.master).map_or(0, |settings| settings.output_speed())
    }

    /// What the host has sent; 0 if nothing.
    pub(super) fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        would_block_is_nothing(rustix::io::read(&self.master, buffer))
    }

    /// Hands bytes to the host; never waits, and says how many fitted.
    pub(super) fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        would_block_is_nothing(rustix::io::write(&self.master, bytes))
    }

    /// Bytes the host has not read yet.
    pub(super) fn unread(&self) -> u64 {
        ioctl_fionread(&self.slave).unwrap_or(0)
    }

    /// Throws away what the host has not read.
    pub(super) fn discard_unread(&self) {
        // If it fails, old data stays, which a host must cope with anyway.
        let _ = tcflush(&self.slave, QueueSelector::IFlush);
    }

    /// Ends the exclusive mode of a host that was killed: the terminal outlives it, and a real port would not keep the
    /// next host out.
    pub(super) fn release_exclusive(&self) {
        let _ = ioctl_tiocnxcl(&self.slave);
    }
}

fn would_block_is_nothing(result: Result<usize, Errno>) -> io::Result<usize> {
    match result {
        Err(Errno::AGAIN | Errno::INTR) => Ok(0),
        other => Ok(other?),
    }
}

/// A symbolic link that is removed when dropped, unless somebody else has changed it.
#[derive(Debug)]
pub(super) struct Link {
    path: PathBuf,
    target: PathBuf,
}

impl Link {
    /// Makes or replaces a link. What is not a link is left alone, with an error.
    pub(super) fn create(path: &Path, target: &Path) -> Result<Link, String> {
        let fail = |what: &str| format!("cannot link {} to the terminal: {what}", path.display());
        match fs::symlink_metadata(path) {
            Ok(found) if !found.file_type().is_symlink() => {
                let kind = if found.is_dir() { "directory" } else { "file" };
                return Err(fail(&format!(
                    "a {kind} of that name exists and is not a symbolic link; remove it or choose another name"
                )));
            }
            Ok(_) => fs::remove_file(path).map_err(|error| fail(&error.to_string()))?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(fail(&error.to_string())),
        }
        std::os::unix::fs::symlink(target, path).map_err(|error| fail(&error.to_string()))?;
        Ok(Link {
            path: path.to_owned(),
            target: target.to_owned(),
        })
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        if fs::read_link(&self.path).is_ok_and(|target| target == self.target) {
            // It may have been removed already.
            let _ = fs::remove_file(&self.path);
        }
    }
}
