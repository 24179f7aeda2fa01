//! Why a journal cannot be used.

use std::path::PathBuf;

/// Why the journal cannot be used. The mediator must not go on without it.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum StoreError {
    /// The store itself.
    #[error(
        "journal {path}: {error}; if another mediator uses it, stop that one; if the file is damaged, move it away and start again when every robot stands still",
        path = path.display()
    )]
    Store {
        path: PathBuf,
        error: Box<redb::Error>,
    },
    /// The disk does not take it. It may again: nothing is lost, and nothing has left.
    #[error(
        "journal {path} cannot be written: {error}; nothing is granted, ordered or answered until it can be: free space on its disk, or mend it",
        path = path.display()
    )]
    Disk {
        path: PathBuf,
        error: Box<redb::Error>,
    },
    /// Somebody has put another file in its place.
    #[error(
        "journal {path} is another file than before: somebody has moved it, or put another one there; start the mediator again when every robot stands still",
        path = path.display()
    )]
    Replaced { path: PathBuf },
    /// A value that is not what its key promises.
    #[error("journal {path}, key `{key}`: expected {expected}, found `{found}`", path = path.display())]
    Value {
        path: PathBuf,
        key: String,
        expected: &'static str,
        found: String,
    },
    /// The journal of somewhere else.
    #[error("journal {path} is of {what} `{found}`, expected `{expected}`: name another file", path = path.display())]
    Other {
        path: PathBuf,
        /// Site or format.
        what: &'static str,
        found: String,
        expected: String,
    },
}
