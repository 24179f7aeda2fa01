//! The files that a robot is made of, as the command line names them.

use std::path::PathBuf;

use clap::Args;
use config::Override;

use super::failure::Failure;

/// The files of a robot and what the command line changes in them.
#[derive(Clone, Debug, Args)]
pub struct Files {
    /// Robot file, such as config/robots/amr-1.toml
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// Site file, such as config/sites/corridor.toml
    #[arg(long, value_name = "FILE")]
    pub site: PathBuf,
    /// Change one value of either file, such as drive.max_speed_m_s=0.3
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// The `--set` arguments, parsed.
///
/// # Errors
/// [`Failure::Refused`] naming the argument.
pub fn overrides(set: &[String]) -> Result<Vec<Override>, Failure> {
    set.iter()
        .map(|text| {
            Override::parse(text).map_err(|error| Failure::Refused(miette::Report::new(error)))
        })
        .collect()
}
