//! Which running mediator a command talks to.

use std::path::PathBuf;

use clap::Args;
use contract::network::Identity;

use super::failure::Failure;
use crate::runtime::{Answer, Folder, Question, ask, ask_from_afar};

/// Which running mediator.
#[derive(Debug, Args)]
pub(super) struct Which {
    /// Name of the site; may be left out while only one mediator runs
    #[arg(long, value_name = "NAME")]
    site: Option<String>,
    /// Folder for the sockets of running mediators [default: $XDG_RUNTIME_DIR/mediator, or /tmp/mediator-UID]
    #[arg(long, value_name = "DIR", env = "MEDIATOR_RUNTIME_DIR")]
    runtime: Option<PathBuf>,
    /// Ask a mediator on another computer, at this endpoint, such as tls/192.168.1.2:7447
    #[arg(
        long,
        value_name = "ENDPOINT",
        requires = "identity",
        conflicts_with = "site"
    )]
    connect: Option<String>,
    /// Who asks from afar: a file that `mediator keys operator` has made
    #[arg(long, value_name = "FILE", requires = "connect")]
    identity: Option<PathBuf>,
    /// First part of every key on that mediator's network
    #[arg(
        long,
        value_name = "PREFIX",
        default_value = "fleet",
        requires = "connect"
    )]
    key_prefix: String,
}

impl Which {
    /// Asks the mediator that is meant.
    pub(super) fn ask(&self, question: &Question) -> Result<Answer, Failure> {
        let (Some(endpoint), Some(path)) = (&self.connect, &self.identity) else {
            return ask(&self.socket()?, question).map_err(Failure::Failed);
        };
        let identity = Identity::load(path).map_err(Failure::Refused)?;
        ask_from_afar(endpoint, &self.key_prefix, identity, question).map_err(Failure::Failed)
    }

    fn socket(&self) -> Result<PathBuf, Failure> {
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
