//! Reading files, and what can go wrong with that.

use std::path::{Path, PathBuf};

/// Why the sources cannot be judged.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ReadError {
    /// A file cannot be read.
    #[error("{}: {error}", path.display())]
    File {
        path: PathBuf,
        error: std::io::Error,
    },
    /// A file is no Rust.
    #[error("{}: {error}", path.display())]
    Rust { path: PathBuf, error: syn::Error },
    /// A manifest is no TOML, or lacks what is needed.
    #[error("{}: {what}", path.display())]
    Manifest { path: PathBuf, what: String },
}

/// Reads a file as text.
///
/// # Errors
/// [`ReadError::File`].
pub(crate) fn read(path: &Path) -> Result<String, ReadError> {
    std::fs::read_to_string(path).map_err(|error| ReadError::File {
        path: path.to_owned(),
        error,
    })
}
