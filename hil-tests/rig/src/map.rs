//! `rig map`: draws a site file.

use std::path::{Path, PathBuf};

use onboard::cli::Failure;

use crate::output::write_file;
use crate::report::site_svg;

/// Where the sites that ship are.
const SITES: &str = "config/sites";
/// Where drawings go unless told otherwise.
const OUT: &str = "target/rig/map";

/// Draws a site, a file or the name of one that ships, into a file.
///
/// # Errors
/// [`Failure::Refused`] when the site is not good, [`Failure::Failed`] when the drawing cannot be written.
pub fn map(site: &Path, out: Option<PathBuf>) -> Result<(), Failure> {
    let file = site_file(site);
    let site = config::load_site(&file, &[])
        .map_err(|error| Failure::Refused(miette::Report::new(error)))?;
    let out = out.unwrap_or_else(|| Path::new(OUT).join(format!("{}.svg", site.name)));
    write_file(&out, &site_svg(&site))?;
    onboard::say!("wrote {}", out.display());
    Ok(())
}

/// A site's file: the path itself, or the name of one that ships.
#[must_use]
pub fn site_file(site: &Path) -> PathBuf {
    let shipped = Path::new(SITES).join(site).with_extension("toml");
    let is_name = site.components().count() == 1 && site.extension().is_none();
    if is_name && !site.exists() && shipped.exists() {
        shipped
    } else {
        site.to_owned()
    }
}
