//! The files that commands read: a site, and the nets beside it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use config::{NetConfig, SiteConfig};
use coordination::analysis::Limits;

use super::failure::Failure;
use crate::nets::{self, Plan};
use crate::setup::Setup;

/// Reads a site file; every problem in it is named.
pub(super) fn load_site(path: &Path) -> Result<SiteConfig, Failure> {
    config::load_site(path, &[])
        .map_err(|error| Failure::Refused(format!("{:?}", miette::Report::new(error))))
}

/// The coordinations of a site, each with its net.
pub(super) fn plans(
    path: &Path,
    site: &SiteConfig,
    setup: &Setup,
) -> Result<Vec<Arc<Plan>>, Failure> {
    if site.coordinations.is_empty() {
        return Ok(Vec::new());
    }
    nets::plans(site, setup, &nets(path)?, &Limits::default()).map_err(|errors| {
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        Failure::Refused(lines.join("\n"))
    })
}

/// All nets in the folder `nets` beside the folder of the site file, by name.
pub(super) fn nets(site: &Path) -> Result<Vec<NetConfig>, Failure> {
    let folder = site
        .parent()
        .map(|folder| folder.join("../nets"))
        .unwrap_or_else(|| PathBuf::from("../nets"));
    let Ok(entries) = std::fs::read_dir(&folder) else {
        return Ok(Vec::new());
    };
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    paths.sort();
    let load = |path: &PathBuf| {
        config::load_net(path)
            .map_err(|error| Failure::Refused(format!("{:?}", miette::Report::new(error))))
    };
    paths.iter().map(load).collect()
}
