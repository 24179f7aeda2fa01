//! Folders.

use std::ffi::{OsStr, OsString};
use std::fs::DirBuilder;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::os::unix::ffi::OsStringExt;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FileType, Mode, OFlags, Stat};

use super::PrivateError;

/// What only the owner may do with a folder.
const PRIVATE: u32 = 0o700;
/// What others may do, in any way.
const OTHERS: u32 = 0o077;
/// What lets others change a folder.
const OTHERS_WRITE: u32 = 0o022;
/// Whoever is on the computer may put something into a folder, and rename and remove what is in it, unless it is sticky.
const EVERYBODYS: Mode = Mode::from_raw_mode(0o002);

/// Makes a folder that is nobody else's, with the folders above it that are missing; all have mode 0700. One that is there
/// already must be so.
///
/// # Errors
/// [`PrivateError`] when it cannot be made, is a symbolic link, belongs to another user or is open to others, or when others
/// can exchange it, since a folder above it is everybody's and not sticky.
pub fn folder(path: &Path) -> Result<(), PrivateError> {
    let path = plain(path);
    let folder = match open(&path) {
        Err(error) if error.is_missing() => {
            DirBuilder::new()
                .recursive(true)
                .mode(PRIVATE)
                .create(&path)
                .map_err(PrivateError::system("make the folder", &path))?;
            open(&path)?
        }
        opened => opened?,
    };
    let stat = check(&folder, &path)?;
    check_above(&folder, &path, &stat)
}

/// The folder of a file, which must be private, and the file's name in it.
pub(super) fn private_folder_of(path: &Path) -> Result<(OwnedFd, &OsStr), PrivateError> {
    let (folder, name) = split(path)?;
    let opened = open(&folder)?;
    check(&opened, &folder)?;
    Ok((opened, name))
}

/// The folder of a file, which others may look into and must not be able to change, and the file's name in it.
pub(super) fn own_folder_of(path: &Path) -> Result<(OwnedFd, &OsStr), PrivateError> {
    let (folder, name) = split(path)?;
    let opened = open(&folder)?;
    let stat = rustix::fs::fstat(&opened).map_err(PrivateError::system("look at", &folder))?;
    check_owner(&folder, &stat)?;
    let found = permissions(&stat);
    if found & OTHERS_WRITE != 0 {
        let expected = found & 0o777 & !OTHERS_WRITE;
        return Err(PrivateError::TooOpen {
            path: folder,
            found,
            expected,
        });
    }
    check_above(&opened, &folder, &stat)?;
    Ok((opened, name))
}

/// The folder of a file, whoever may read it, and the file's name in it.
pub(super) fn folder_of(path: &Path) -> Result<(OwnedFd, &OsStr), PrivateError> {
    let (folder, name) = split(path)?;
    let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let opened = rustix::fs::open(&folder, flags, Mode::empty())
        .map_err(PrivateError::system("open", &folder))?;
    Ok((opened, name))
}

/// Others must not be able to exchange what a folder holds, or a folder above it: the entry of this stat.
pub(super) fn check_place(folder: &OwnedFd, path: &Path, entry: &Stat) -> Result<(), PrivateError> {
    let stat = rustix::fs::fstat(folder).map_err(PrivateError::system("look at", path))?;
    check_entry(folder, path, &stat, (entry, path))?;
    check_above(folder, path, &stat)
}

/// The effective user, who is the owner of what is made.
pub(super) fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// What is wrong with the owner, if something is.
pub(super) fn check_owner(path: &Path, stat: &Stat) -> Result<(), PrivateError> {
    let (found, expected) = (stat.st_uid, user());
    if found == expected {
        return Ok(());
    }
    let path = path.to_owned();
    Err(PrivateError::Owner {
        path,
        found,
        expected,
    })
}

/// What others may do with it, if something, where only this is expected.
pub(super) fn check_mode(path: &Path, stat: &Stat, expected: u32) -> Result<(), PrivateError> {
    let found = permissions(stat);
    if found & OTHERS == 0 {
        return Ok(());
    }
    let path = path.to_owned();
    Err(PrivateError::TooOpen {
        path,
        found,
        expected,
    })
}

/// Without a slash at its end, which would follow a link.
fn plain(path: &Path) -> PathBuf {
    let plain: PathBuf = path.components().collect();
    if plain.as_os_str().is_empty() {
        PathBuf::from(".")
    } else {
        plain
    }
}

fn split(path: &Path) -> Result<(PathBuf, &OsStr), PrivateError> {
    let name = path.file_name().ok_or_else(|| PrivateError::Kind {
        path: path.to_owned(),
        found: "folder",
        expected: "file",
    })?;
    Ok((plain(path.parent().unwrap_or(Path::new(""))), name))
}

fn open(path: &Path) -> Result<OwnedFd, PrivateError> {
    let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    rustix::fs::open(path, flags, Mode::empty())
        .map_err(|error| PrivateError::opening(path, FileType::Directory, error))
}

fn check(folder: &OwnedFd, path: &Path) -> Result<Stat, PrivateError> {
    let stat = rustix::fs::fstat(folder).map_err(PrivateError::system("look at", path))?;
    check_owner(path, &stat)?;
    check_mode(path, &stat, PRIVATE)?;
    Ok(stat)
}

/// All folders above this one, up to the root.
fn check_above(folder: &OwnedFd, path: &Path, stat: &Stat) -> Result<(), PrivateError> {
    let looking = || PrivateError::system("look above", path);
    let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let up = |from: BorrowedFd| rustix::fs::openat(from, "..", flags, Mode::empty());
    let mut above = up(folder.as_fd()).map_err(looking())?;
    let (mut below, mut name_below) = (*stat, path.to_owned());
    loop {
        let stat = rustix::fs::fstat(&above).map_err(looking())?;
        if (stat.st_dev, stat.st_ino) == (below.st_dev, below.st_ino) {
            return Ok(());
        }
        check_entry(&above, path, &stat, (&below, &name_below))?;
        name_below = name(&above).unwrap_or_else(|| name_below.join(".."));
        below = stat;
        above = up(above.as_fd()).map_err(looking())?;
    }
}

/// In a folder that is everybody's, only the owner of an entry may rename it, and that is this user or root.
fn check_entry(
    folder: &OwnedFd,
    path: &Path,
    stat: &Stat,
    (entry, entry_name): (&Stat, &Path),
) -> Result<(), PrivateError> {
    let mode = Mode::from_raw_mode(stat.st_mode);
    if !mode.contains(EVERYBODYS) {
        return Ok(());
    }
    if !mode.contains(Mode::SVTX) {
        return Err(PrivateError::Above {
            above: name(folder).unwrap_or_else(|| entry_name.join("..")),
            path: path.to_owned(),
            found: permissions(stat),
        });
    }
    if entry.st_uid == 0 {
        return Ok(());
    }
    check_owner(entry_name, entry)
}

fn permissions(stat: &Stat) -> u32 {
    Mode::from_raw_mode(stat.st_mode).as_raw_mode()
}

/// Where an open folder is, for people.
fn name(folder: &OwnedFd) -> Option<PathBuf> {
    let link = format!("/proc/self/fd/{}", folder.as_raw_fd());
    let name = rustix::fs::readlink(link, Vec::new()).ok()?;
    Some(OsString::from_vec(name.into_bytes()).into())
}
