//! Settings of robots, and files made for one run.

use std::fs;
use std::path::{Path, PathBuf};

use onboard::cli::Failure;

use crate::testbed::Devices;

/// `--set` values that lead a robot to its devices, and to its fleet at these endpoints.
///
/// # Errors
/// [`Failure::Refused`] when the bus is not reached over UDP.
pub fn settings(
    devices: &Devices,
    lidar_link: &Path,
    peers: &[&str],
    key_prefix: &str,
) -> Result<[String; 5], Failure> {
    let bus =
        { devices.bus.local_addr() }.ok_or_else(|| Failure::refused("the bus has no address"))?;
    Ok([
        format!("ethercat.udp={:?}", bus.to_string()),
        format!("lidar.device={:?}", lidar_link.display().to_string()),
        format!("fleet.connect={peers:?}"),
        "fleet.scouting=false".to_owned(),
        format!("fleet.key_prefix={key_prefix:?}"),
    ])
}

/// Copies the site file into this folder, without its coordinations.
pub(super) fn without_nets(site_file: &Path, folder: &Path) -> Result<PathBuf, Failure> {
    let cannot = |what: String| {
        Failure::refused(format_args!(
            "the site file cannot be copied without its coordinations: {what}"
        ))
    };
    let text = fs::read_to_string(site_file).map_err(|error| cannot(error.to_string()))?;
    let mut table: toml::Table = text
        .parse()
        .map_err(|error: toml::de::Error| cannot(error.to_string()))?;
    table.remove("coordinations");
    let text = toml::to_string(&table).map_err(|error| cannot(error.to_string()))?;
    let copy = folder.join("site.toml");
    fs::write(&copy, text).map_err(|error| cannot(error.to_string()))?;
    Ok(copy)
}
