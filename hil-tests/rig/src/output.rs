//! What every command needs around its runs: folders, files, and the flag that ends it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use onboard::cli::Failure;
use serde::Serialize;

/// Makes a folder and its parents.
///
/// # Errors
/// [`Failure::Refused`] with the operating system's reason.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| {
        Failure::refused(format_args!(
            "folder {} cannot be made: {error}",
            folder.display()
        ))
    })
}

/// Writes a file of a run's folder; returns its path.
///
/// # Errors
/// [`Failure::Failed`] when it cannot be written.
pub fn write(out: &Path, name: &str, text: &str) -> Result<PathBuf, Failure> {
    let file = out.join(name);
    write_file(&file, text)?;
    Ok(file)
}

/// Writes a value as JSON into a file of a run's folder; returns its path.
///
/// # Errors
/// As [`write()`].
pub fn write_json(out: &Path, name: &str, value: &impl Serialize) -> Result<PathBuf, Failure> {
    let json = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
    write(out, name, &json)
}

/// Writes a file, and makes its folder.
///
/// # Errors
/// As [`write()`].
pub fn write_file(file: &Path, text: &str) -> Result<(), Failure> {
    { file.parent() }
        .map_or(Ok(()), std::fs::create_dir_all)
        .and_then(|()| std::fs::write(file, text))
        .map_err(|error| {
            Failure::failed(format_args!(
                "{} cannot be written: {error}",
                file.display()
            ))
        })
}

/// A flag that SIGINT and SIGTERM raise.
///
/// # Errors
/// [`Failure::Refused`] with the operating system's reason.
pub fn end_flag() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::<AtomicBool>::default();
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&flag)).map_err(Failure::refused)?;
    }
    Ok(flag)
}
