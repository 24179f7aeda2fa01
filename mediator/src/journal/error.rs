//! Why a journal cannot be used.

use std::path::PathBuf;

/// Why the journal cannot be used. The mediator must not go on without it.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The store itself.
    #[error(
        "journal {path}: {error}; if another mediator uses it, stop that one; if the file is damaged, move it away and start again when every robot stands still",
        path = path.display()
    )]
    Store {
        /// The file.
        path: PathBuf,
        /// What the store says.
        error: Box<redb::Error>,
    },
    /// A value that is not what its key promises.
    #[error("journal {path}, key `{key}`: expected {expected}, found `{found}`", path = path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Which key.
        key: String,
        /// What belongs there.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// The journal of somewhere else.
    #[error("journal {path} is of {what} `{found}`, expected `{expected}`: name another file", path = path.display())]
    Other {
        /// The file.
        path: PathBuf,
        /// Site or format.
        what: &'static str,
        /// As found.
        found: String,
        /// Ours.
        expected: String,
    },
}
