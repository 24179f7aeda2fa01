//! Files.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::fs::{AtFlags, FileType, Mode, OFlags, Stat};
use rustix::io::Errno;

use super::PrivateError;
use super::folder::{
    check_mode, check_owner, check_place, folder_of, own_folder_of, private_folder_of,
};

/// What only the owner may do with a file.
const PRIVATE: u32 = 0o600;

/// Reads a secret: a file of this user that nobody else can read or write.
///
/// # Errors
/// [`PrivateError`] when there is none ([`is_missing`](PrivateError::is_missing)), or it is a symbolic link, no file, another
/// user's or open to others.
pub fn read(path: &Path) -> Result<Vec<u8>, PrivateError> {
    let (mut file, stat) = opened(path, OFlags::RDONLY)?;
    check_mode(path, &stat, PRIVATE)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)
        .map_err(PrivateError::system("read", path))?;
    Ok(bytes)
}

/// Opens a file of this user for reading, whoever else may read it: what an earlier version left in a private folder.
///
/// # Errors
/// [`PrivateError`] when there is none ([`is_missing`](PrivateError::is_missing)), or it is a symbolic link, no file or
/// another user's.
pub fn open(path: &Path) -> Result<File, PrivateError> {
    opened(path, OFlags::RDONLY).map(|(file, _)| file)
}

/// Opens a file of this user for reading and writing, in a folder of any mode; it is made with mode 0600 if it is missing.
///
/// # Errors
/// [`PrivateError`] when it cannot be made, is a symbolic link, no file or another user's, or when others can exchange it,
/// since a folder above it is everybody's and not sticky.
pub fn open_or_make(path: &Path) -> Result<File, PrivateError> {
    let (file, stat) = opened(path, OFlags::RDWR | OFlags::CREATE)?;
    let (folder, _) = folder_of(path)?;
    check_place(&folder, path, &stat)?;
    Ok(file)
}

/// Puts a file into a private folder, with mode 0600, in place of the one of its name. It is there as a whole or not at all,
/// and on the disk when this returns. A symbolic link of that name is replaced, not followed.
///
/// # Errors
/// [`PrivateError`] when the folder is not private, or the file cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), PrivateError> {
    put(path, private_folder_of(path)?, bytes, true)
}

/// As [`write()`], without waiting for the disk: for what a loss of power may take.
///
/// # Errors
/// As [`write()`].
pub fn write_unsynced(path: &Path, bytes: &[u8]) -> Result<(), PrivateError> {
    put(path, private_folder_of(path)?, bytes, false)
}

/// As [`write()`], into a folder of this user that others may look into, and may not change.
///
/// # Errors
/// [`PrivateError`] when others can change the folder, or the file cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), PrivateError> {
    put(path, own_folder_of(path)?, bytes, true)
}

fn put(
    path: &Path,
    (folder, name): (OwnedFd, &OsStr),
    bytes: &[u8],
    synced: bool,
) -> Result<(), PrivateError> {
    let [mut new, end] = [".", ".new"].map(OsString::from);
    new.push(name);
    new.push(end);
    let written = || -> Result<(), std::io::Error> {
        // Left by a process that was killed.
        match rustix::fs::unlinkat(&folder, &new, AtFlags::empty()) {
            Ok(()) | Err(Errno::NOENT) => {}
            Err(error) => return Err(error.into()),
        }
        let flags = OFlags::RDWR | OFlags::CREATE | OFlags::EXCL | OFlags::CLOEXEC;
        let mode = Mode::from_raw_mode(PRIVATE);
        let mut file = File::from(rustix::fs::openat(&folder, &new, flags, mode)?);
        file.write_all(bytes)?;
        if synced {
            file.sync_all()?;
        }
        rustix::fs::renameat(&folder, &new, &folder, name)?;
        if synced {
            // The descriptor of the folder is one that names it, and no more.
            let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
            File::from(rustix::fs::openat(&folder, ".", flags, Mode::empty())?).sync_all()?;
        }
        Ok(())
    };
    written().map_err(|error| {
        // It is of no use; that it cannot be removed is not what is to be said.
        let _ = rustix::fs::unlinkat(&folder, &new, AtFlags::empty());
        PrivateError::system("write", path)(error)
    })
}

/// A file of this user, and what the system knows of it. A pipe in its place holds up nobody.
fn opened(path: &Path, flags: OFlags) -> Result<(File, Stat), PrivateError> {
    let flags = flags | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    let file = rustix::fs::open(path, flags, Mode::from_raw_mode(PRIVATE))
        .map_err(|error| PrivateError::opening(path, FileType::RegularFile, error))?;
    let stat = rustix::fs::fstat(&file).map_err(PrivateError::system("look at", path))?;
    let found = FileType::from_raw_mode(stat.st_mode);
    if let Some(error) = PrivateError::other(path, FileType::RegularFile, found) {
        return Err(error);
    }
    check_owner(path, &stat)?;
    Ok((File::from(file), stat))
}
