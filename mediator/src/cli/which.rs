//! Which running mediator a command talks to.

use std::path::PathBuf;

use clap::Args;

use super::failure::Failure;
use crate::runtime::Folder;

/// Which running mediator.
#[derive(Debug, Args)]
pub(super) struct Which {
    /// Name of the site; may be left out while only one mediator runs
    #[arg(long, value_name = "NAME")]
    site: Option<String>,
    /// Folder for the sockets of running mediators [default: $XDG_RUNTIME_DIR/mediator, or /tmp/mediator-UID]
    #[arg(long, value_name = "DIR", env = "MEDIATOR_RUNTIME_DIR")]
    runtime: Option<PathBuf>,
}

impl Which {
    /// The socket of the mediator that is meant.
    pub(super) fn socket(&self) -> Result<PathBuf, Failure> {
        let site = match &self.site {
            Some(site) => site.clone(),
            None => {
                let running = Folder::sites(self.runtime.clone()).map_err(Failure::Refused)?;
                match running.as_slice() {
                    [only] => only.clone(),
                    [] => return Err(Failure::Refused("no mediator runs here".to_owned())),
                    several => {
                        return Err(Failure::Refused(format!(
                            "several mediators run: {}; name one with --site",
                            several.join(", ")
                        )));
                    }
                }
            }
        };
        let folder = Folder::new(self.runtime.clone(), &site).map_err(Failure::Refused)?;
        Ok(folder.socket())
    }
}
