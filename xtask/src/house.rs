//! All checks of the workspace.

use std::path::Path;

use crate::files::ReadError;
use crate::{arrows, circles, lengths, source, wide};

/// Every finding in the workspace at `root`, as a sentence each; empty when the house stands.
///
/// # Errors
/// [`ReadError`] when a source or a manifest cannot be read.
pub fn findings(root: &Path) -> Result<Vec<String>, ReadError> {
    let mut findings = Vec::new();
    for member in arrows::members(root)? {
        findings.extend(arrows::findings(root, &member)?);
        let folder = root.join(&member);
        for entry in ["src/lib.rs", "src/main.rs"] {
            let entry = folder.join(entry);
            if entry.is_file() {
                let krate = source::Crate::read(&entry)?;
                findings.extend(circles::findings(&member, &krate));
            }
        }
        findings.extend(lengths::findings(root, &folder)?);
    }
    findings.extend(wide::findings(root)?);
    Ok(findings)
}
