//! A file is about one thing, and rarely longer than 400 lines; a longer one says why in its header.

use std::path::Path;

use crate::files::{ReadError, read};

/// Lines that a file may have without giving a reason.
const MOST_LINES: usize = 400;
/// How the line of a header begins that gives the reason.
const REASON: &str = "//! Longer than 400 lines:";

/// Files of a crate's `src` that are too long, without a reason.
///
/// # Errors
/// [`ReadError::File`].
pub fn findings(root: &Path, folder: &Path) -> Result<Vec<String>, ReadError> {
    let mut findings = Vec::new();
    let mut folders = vec![folder.join("src")];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder).map_err(|error| ReadError::File {
            path: folder.clone(),
            error,
        })?;
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = read(&path)?;
                let lines = text.lines().count();
                let has_reason = text.lines().any(|line| line.starts_with(REASON));
                if lines > MOST_LINES && !has_reason {
                    let shown = path.strip_prefix(root).unwrap_or(&path).display();
                    findings.push(format!(
                        "{shown}: {lines} lines; split it, or say why in its header: `{REASON} …`"
                    ));
                }
            }
        }
    }
    findings.sort();
    Ok(findings)
}
