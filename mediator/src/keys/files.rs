//! The files of a site's keys. Nobody but their owner reads them.

use std::fs::File;
use std::path::Path;

use contract::private;

pub(super) const AUTHORITY_KEY: &str = "authority.key";
pub(super) const AUTHORITY_CERTIFICATE: &str = "authority.crt";
pub(super) const REGISTRY: &str = "identities.toml";

pub(super) fn make_folder(path: &Path) -> Result<(), String> {
    private::folder(path).map_err(|error| error.to_string())
}

pub(super) fn read(path: &Path) -> Result<String, String> {
    let bytes = private::read(path).map_err(|error| error.to_string())?;
    String::from_utf8(bytes).map_err(|_| format!("{}: expected UTF-8 text", path.display()))
}

pub(super) fn write(path: &Path, text: &str) -> Result<(), String> {
    private::write(path, text.as_bytes()).map_err(|error| error.to_string())
}

/// One process at a time changes them.
pub(super) struct Guard {
    _file: File,
}

impl Guard {
    pub(super) fn of(folder: &Path) -> Result<Self, String> {
        let path = folder.join(AUTHORITY_CERTIFICATE);
        let file = private::open(&path).map_err(|error| error.to_string())?;
        file.lock().map_err(|error| {
            format!(
                "{} cannot be locked: {error}; does the site have keys?",
                path.display()
            )
        })?;
        Ok(Self { _file: file })
    }
}
