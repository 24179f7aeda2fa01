//! Where a table's shared memory and files live, and the names below.

use std::fs::DirBuilder;
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use super::SymbolError;

/// Longest robot id, in bytes.
const ROBOT_LIMIT: usize = 32;
/// Longest prefix, in bytes.
const PREFIX_LIMIT: usize = 16;
/// Longest path of the root folder: iceoryx2's paths have 255 bytes, of which the longest below
/// the root takes 174.
const ROOT_LIMIT: usize = 80;

const WORD: &str = "ASCII letters, digits, `_` and `-`";

/// Where the shared memory lives: one folder per runtime folder, so that several fleets, and tests
/// in parallel, do not meet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Namespace {
    /// The folder for what belongs to the shared memory; it is created with mode 0700 if it is missing. One that is there
    /// already, and those above it, must be such that nobody else can exchange it: this is not looked at.
    pub root: PathBuf,
    /// What the names of the shared memory begin with, in a folder that all programs share.
    pub prefix: String,
}

impl Namespace {
    /// A namespace with this root folder and this prefix.
    pub fn new(root: impl Into<PathBuf>, prefix: impl Into<String>) -> Self {
        Self {
            root: root.into(),
            prefix: prefix.into(),
        }
    }

    /// Checks the names, which become parts of paths.
    pub(super) fn check(&self, robot: &str) -> Result<(), SymbolError> {
        check_name("the robot id", robot, ROBOT_LIMIT)?;
        if self.prefix.is_empty() {
            return Ok(());
        }
        check_name("the shared memory prefix", &self.prefix, PREFIX_LIMIT)
    }

    /// The root folder as an absolute path without links, or `None` if it does not exist.
    pub(super) fn existing_root(&self) -> Result<Option<PathBuf>, SymbolError> {
        let root = match self.root.canonicalize() {
            Ok(root) => root,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(file_error("use the folder", &self.root)(error)),
        };
        if !root.is_dir() {
            let error = io::Error::from(io::ErrorKind::NotADirectory);
            return Err(file_error("use the folder", &root)(error));
        }
        let length = root.to_str().map_or(usize::MAX, str::len);
        if length > ROOT_LIMIT {
            return Err(SymbolError::BadRoot {
                root,
                limit: ROOT_LIMIT,
            });
        }
        Ok(Some(root))
    }

    /// As [`existing_root`](Self::existing_root), after creating the folder if it is missing.
    pub(super) fn create_root(&self) -> Result<PathBuf, SymbolError> {
        private_folder()
            .recursive(true)
            .create(&self.root)
            .map_err(file_error("create the folder", &self.root))?;
        self.existing_root()?.ok_or_else(|| {
            let error = io::Error::from(io::ErrorKind::NotFound);
            file_error("use the folder", &self.root)(error)
        })
    }
}

/// Makes folders that only their owner can use.
pub(super) fn private_folder() -> DirBuilder {
    let mut builder = DirBuilder::new();
    builder.mode(0o700);
    builder
}

/// A name out of letters, digits, `_` and `-`.
pub(super) fn check_name(what: &'static str, name: &str, limit: usize) -> Result<(), SymbolError> {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"_-".contains(&byte);
    if (1..=limit).contains(&name.len()) && name.bytes().all(plain) {
        return Ok(());
    }
    Err(SymbolError::BadName {
        what,
        name: name.into(),
        limit,
        allowed: WORD,
    })
}

pub(super) fn file_error(
    doing: &'static str,
    path: &Path,
) -> impl FnOnce(io::Error) -> SymbolError {
    let path = path.to_owned();
    move |source| SymbolError::File {
        doing,
        path,
        source,
    }
}
