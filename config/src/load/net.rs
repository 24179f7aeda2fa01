//! From a net file to a checked net.

use std::collections::BTreeMap;
use std::path::Path;

use super::{document, read};
use crate::check;
use crate::diagnostic::ConfigError;
use crate::net::{NetConfig, NetFile};
use crate::reader;
use crate::report::Report;
use description::keys::Section as _;

/// Reads and checks a net file. The net is not analysed yet: see
/// [`NetConfig::analyse`](crate::NetConfig::analyse).
///
/// # Errors
/// Everything wrong with the file, at once.
pub fn load_net(path: impl AsRef<Path>) -> Result<NetConfig, ConfigError> {
    let path = path.as_ref();
    parse_net(&path.display().to_string(), &read(path, "net")?)
}

/// Like [`load_net`], from text; `file` is the name that errors show.
///
/// # Errors
/// As [`load_net`].
pub fn parse_net(file: &str, text: &str) -> Result<NetConfig, ConfigError> {
    let (origin, entries) = document(file, text, &[], &[])?;
    let report = Report::new(origin);
    let mut net = NetConfig {
        file: reader::Section::root(&report, &entries, NetFile::read),
        origin: report.origin.clone(),
        compiled: BTreeMap::new(),
    };
    check::net(&mut net, &report);
    report.finish(net)
}
