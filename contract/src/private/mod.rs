//! What is nobody else's: folders, files and sockets that only the user who runs the program can reach, and root.
//!
//! * [`folder()`]: makes a folder with mode 0700, or refuses the one that is there;
//! * [`write()`], [`write_unsynced`]: put a file with mode 0600 into such a folder, whole or not at all; [`replace`]: into one that
//!   others may look into;
//! * [`read`]: reads a secret, such as a key, that nobody else can have read or written;
//! * [`open`], [`open_or_make`]: a file of this user, whoever may read it, such as a journal of an earlier version;
//! * [`listen`], [`peer`]: a socket in such a folder, and who is at its other end;
//! * [`by_default`]: what the process makes elsewhere is nobody else's either.
//!
//! No symbolic link is followed at the last name of a path. What is checked is what was opened, by its descriptor; another
//! folder in its place meanwhile makes the call fail. A folder that is too open is refused, not mended: with `--runtime /run`,
//! root would take `/run` away from all others.
//!
//! It lies in this crate since it is the lowest one that robot, mediator and the network between them share. Everything makes
//! system calls and allocates: not for real-time threads.
//!
//! ```
//! use contract::private;
//!
//! # let place = tempfile::tempdir()?;
//! # let place = place.path();
//! let keys = place.join("keys");
//! private::folder(&keys)?;
//! private::write(&keys.join("amr-1.key"), b"secret")?;
//! assert_eq!(private::read(&keys.join("amr-1.key"))?, b"secret");
//! # Ok::<(), std::io::Error>(())
//! ```

mod error;
mod file;
mod folder;
mod socket;
#[cfg(test)]
mod tests;

pub use error::PrivateError;
pub use file::{open, open_or_make, read, replace, write, write_unsynced};
pub use folder::folder;
pub use socket::{listen, peer};

use rustix::fs::Mode;

/// What this process makes from now on is nobody else's, whichever library makes it: umask 077. For the beginning of a program,
/// before it has threads. It does not hold for what sets a mode itself afterwards.
pub fn by_default() {
    rustix::process::umask(Mode::RWXG | Mode::RWXO);
}
