//! Sockets.

use std::os::fd::AsFd;
use std::os::unix::net::UnixListener;
use std::path::Path;

use rustix::fs::{AtFlags, FileType, Mode};
use rustix::io::Errno;

use super::PrivateError;
use super::folder::{check_owner, private_folder_of, user};

/// Listens on a socket in a private folder, with mode 0600. A socket that is already there is replaced: it is left over, or the
/// caller knows better.
///
/// # Errors
/// [`PrivateError`] when the folder is not private, something else than a socket has the name, or it cannot be bound.
pub fn listen(path: &Path) -> Result<UnixListener, PrivateError> {
    let (folder, name) = private_folder_of(path)?;
    let look = || rustix::fs::statat(&folder, name, AtFlags::SYMLINK_NOFOLLOW);
    let kind = |mode| PrivateError::other(path, FileType::Socket, FileType::from_raw_mode(mode));
    match look() {
        Err(Errno::NOENT) => {}
        Err(error) => return Err(PrivateError::system("look at", path)(error)),
        Ok(found) => {
            if let Some(error) = kind(found.st_mode) {
                return Err(error);
            }
            rustix::fs::unlinkat(&folder, name, AtFlags::empty())
                .map_err(PrivateError::system("remove", path))?;
        }
    }
    // Until its mode is set, the folder keeps others out.
    let listener = UnixListener::bind(path).map_err(PrivateError::system("bind", path))?;
    let moved = || PrivateError::Moved {
        path: path.to_owned(),
    };
    // It was bound by its path, which may lead elsewhere by now.
    let bound = look().map_err(|_| moved())?;
    if kind(bound.st_mode).is_some() {
        return Err(moved());
    }
    check_owner(path, &bound)?;
    let mode = Mode::RUSR | Mode::WUSR;
    rustix::fs::chmodat(&folder, name, mode, AtFlags::empty())
        .map_err(PrivateError::system("set the mode of", path))?;
    Ok(listener)
}

/// Whether the other end of a socket is this user's, or root's, as it was when it connected.
///
/// # Errors
/// [`PrivateError::Peer`] with whose it is.
pub fn peer(stream: impl AsFd) -> Result<(), PrivateError> {
    let credentials = rustix::net::sockopt::socket_peercred(stream).map_err(
        PrivateError::system("see who is at", Path::new("the other end")),
    )?;
    let (found, expected) = (credentials.uid.as_raw(), user());
    if found == expected || found == 0 {
        return Ok(());
    }
    Err(PrivateError::Peer { found, expected })
}
