//! How a mediator takes part in its fleet's network: with certificates, or on this computer only, unless it is told otherwise.

use std::path::PathBuf;

use clap::Args;
use contract::network::NetworkSettings;

use super::failure::Failure;
use crate::keys::Keys;
use crate::runtime::{Folder, Settings};

/// What can be done about a network without certificates.
const HELP: &str = "make certificates with `mediator keys site` and listen at `tls/...`, or stay on this computer with \
                    `--listen tcp/127.0.0.1:7447`, or add --insecure: then whoever is on the network can hear, speak for and \
                    move every robot";

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// First part of every key on the fleet's network
    #[arg(long, value_name = "PREFIX", default_value = "fleet")]
    key_prefix: String,
    /// Endpoint to listen on; may be repeated [default: tls/[::]:7447]
    #[arg(long, value_name = "ENDPOINT")]
    listen: Vec<String>,
    /// Endpoint to connect to; may be repeated
    #[arg(long, value_name = "ENDPOINT")]
    connect: Vec<String>,
    /// Look for robots by multicast
    #[arg(long)]
    scouting: bool,
    /// Interface for multicast
    #[arg(long, value_name = "NAME")]
    interface: Option<String>,
    /// Folder of the site's keys [default: $XDG_STATE_HOME/mediator/keys/SITE]
    #[arg(long, value_name = "DIR")]
    keys: Option<PathBuf>,
    /// Use no certificates: whoever is on the network can hear, speak for and move every robot [default endpoint: tcp/[::]:7447]
    #[arg(long, conflicts_with = "keys")]
    insecure: bool,
}

impl Arguments {
    /// The settings of the mediator of `site`.
    pub(super) fn settings(self, site: &str) -> Result<Settings, Failure> {
        let named = self.keys.is_some();
        let keys = Keys::new(self.keys.unwrap_or_else(|| Folder::default_keys(site)));
        let default = if self.insecure {
            "tcp/[::]:7447"
        } else {
            "tls/[::]:7447"
        };
        let listen = match self.listen[..] {
            [] => vec![default.to_owned()],
            _ => self.listen,
        };
        let mut network = NetworkSettings {
            listen,
            connect: self.connect,
            scouting: self.scouting,
            interface: self.interface,
            ..NetworkSettings::default()
        };
        let wants_tls = { network.listen.iter().chain(&network.connect) }
            .any(|endpoint| endpoint.starts_with("tls/"));
        // Those that are named must be there: that is found when they are read.
        let secure = !self.insecure && (named || wants_tls && keys.exist());
        if self.insecure {
            tracing::warn!(
                "--insecure: no certificates, whoever is on the network can hear, speak for and move every robot"
            );
        } else {
            if secure {
                let snapshot = keys.snapshot().map_err(Failure::Refused)?;
                let security = snapshot.security(&self.key_prefix);
                network.security = Some(security.map_err(Failure::Refused)?);
            }
            network
                .check()
                .map_err(|error| Failure::Refused(format!("{error}: {HELP}")))?;
            // Made anew whenever the network is opened.
            network.security = None;
        }
        Ok(Settings {
            key_prefix: self.key_prefix,
            network,
            keys: secure.then_some(keys),
        })
    }
}
