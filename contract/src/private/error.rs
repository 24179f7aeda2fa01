//! Why something is not private.

use std::io;
use std::path::{Path, PathBuf};

use rustix::fs::FileType;
use rustix::io::Errno;

/// Why a folder, a file or a socket cannot be used, or not as a private one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum PrivateError {
    /// The operating system's reason.
    #[error("cannot {doing} {}: {source}", path.display())]
    System {
        doing: &'static str,
        path: PathBuf,
        source: io::Error,
    },
    /// The last name of the path is a link, which anybody may have put there.
    #[error(
        "{} is a symbolic link, expected a {expected}: remove it, or name what it points to",
        path.display()
    )]
    Link {
        path: PathBuf,
        expected: &'static str,
    },
    /// Something else has the name.
    #[error("{} is a {found}, expected a {expected}: name another place", path.display())]
    Kind {
        path: PathBuf,
        found: &'static str,
        expected: &'static str,
    },
    /// It belongs to somebody else, who can change it at any time.
    #[error(
        "{} belongs to user {found}, expected user {expected}: name another place, or run `chown {expected} {}`",
        path.display(), path.display()
    )]
    Owner {
        path: PathBuf,
        found: u32,
        expected: u32,
    },
    /// Others may read or change it.
    #[error(
        "{} has mode {found:04o}, expected {expected:04o}, so that others cannot reach it: name another place, or run `chmod {expected:04o} {}`",
        path.display(), path.display()
    )]
    TooOpen {
        path: PathBuf,
        found: u32,
        expected: u32,
    },
    /// A folder above it in which everybody may rename everything.
    #[error(
        "{} has mode {found:04o}, so that anybody can put something else in the place of {}: name another place, or run `chmod +t {}`",
        above.display(), path.display(), above.display()
    )]
    Above {
        above: PathBuf,
        path: PathBuf,
        found: u32,
    },
    /// Another folder has its name by now.
    #[error("{} is in another folder than a moment ago: see who moves it", path.display())]
    Moved { path: PathBuf },
    /// Another user at the other end of a socket.
    #[error("user {found} may not ask, only user {expected} and root")]
    Peer { found: u32, expected: u32 },
}

impl PrivateError {
    /// Whether there is nothing of this name.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        self.kind() == io::ErrorKind::NotFound
    }

    fn kind(&self) -> io::ErrorKind {
        match self {
            Self::System { source, .. } => source.kind(),
            _ => io::ErrorKind::PermissionDenied,
        }
    }

    /// What the system answered while it was doing this to that.
    pub(super) fn system<E: Into<io::Error>>(
        doing: &'static str,
        path: &Path,
    ) -> impl FnOnce(E) -> Self {
        let path = path.to_owned();
        move |error| Self::System {
            doing,
            path,
            source: error.into(),
        }
    }

    /// Why this could not be opened as what was expected: something else has its name, or the system says why.
    pub(super) fn opening(path: &Path, expected: FileType, error: Errno) -> Self {
        rustix::fs::lstat(path)
            .ok()
            .and_then(|found| Self::other(path, expected, FileType::from_raw_mode(found.st_mode)))
            .unwrap_or_else(|| Self::system("open", path)(error))
    }

    /// What is wrong with the kind of it, if something is.
    pub(super) fn other(path: &Path, expected: FileType, found: FileType) -> Option<Self> {
        let path = path.to_owned();
        let name = |kind| match kind {
            FileType::Directory => "folder",
            FileType::RegularFile => "file",
            FileType::Socket => "socket",
            FileType::Fifo => "pipe",
            _ => "device",
        };
        let expected_name = name(expected);
        match found {
            found if found == expected => None,
            FileType::Symlink => Some(Self::Link {
                path,
                expected: expected_name,
            }),
            found => Some(Self::Kind {
                path,
                found: name(found),
                expected: expected_name,
            }),
        }
    }
}

impl From<PrivateError> for io::Error {
    fn from(error: PrivateError) -> Self {
        Self::new(error.kind(), error)
    }
}
