//! How robots, mediator and the independent listener of a run find each other: over TCP on the loopback, or with certificates
//! on every link. Then robots talk with nobody but the mediator, and the listener hears them through it, as an operator.

use std::path::{Path, PathBuf};

use config::{NetConfig, SiteConfig};
use contract::network::{Identity, Party};
use contract::private;
use mediator::keys::Keys;

use crate::network::endpoint::free_endpoint;
use crate::network::listener::Listener;

/// Of one run.
pub struct Links {
    /// A name of this run's own, so that two rigs on one machine never meet.
    pub key_prefix: String,
    /// Where the mediator listens.
    pub mediator: String,
    secured: Option<Secured>,
}

struct Secured {
    keys: Keys,
    operator: Identity,
    /// For the robots' files.
    folder: PathBuf,
}

impl Links {
    /// With certificates, the site's authority and its operator are made.
    pub(super) fn new(site: &str, secure: bool, folder: &Path) -> Result<Self, String> {
        let endpoint = free_endpoint()?;
        let key_prefix = format!("rig-{}", std::process::id());
        if !secure {
            return Ok(Self {
                key_prefix,
                mediator: endpoint,
                secured: None,
            });
        }
        let keys = Keys::new(folder.join("keys"));
        keys.begin(site, 30.0)?;
        let operator = keys.issue(Party::Operator("rig".to_owned()))?;
        Ok(Self {
            key_prefix,
            mediator: endpoint.replacen("tcp/", "tls/", 1),
            secured: Some(Secured {
                keys,
                operator,
                folder: folder.to_owned(),
            }),
        })
    }

    /// Before the mediator starts, unless it is heard through that.
    pub(super) fn listener(
        &self,
        site: &SiteConfig,
        nets: &[NetConfig],
    ) -> Result<Option<Listener>, String> {
        match self.secured {
            None => Listener::open(&self.key_prefix, site, nets).map(Some),
            Some(_) => Ok(None),
        }
    }

    /// After the mediator has started.
    pub(super) fn listener_through_mediator(
        &self,
        site: &SiteConfig,
        nets: &[NetConfig],
    ) -> Result<Listener, String> {
        match &self.secured {
            None => Listener::open(&self.key_prefix, site, nets),
            Some(own) => Listener::through(
                &self.mediator,
                own.operator.clone(),
                &self.key_prefix,
                site,
                nets,
            ),
        }
    }

    /// Folder of the keys, for the mediator.
    pub(super) fn keys(&self) -> Option<PathBuf> {
        { self.secured.as_ref() }.map(|own| own.keys.folder().to_owned())
    }

    /// What the robot needs besides endpoints.
    pub(super) fn robot(&self, id: &str) -> Result<Option<String>, String> {
        let Some(own) = &self.secured else {
            return Ok(None);
        };
        let identity = own.keys.issue(Party::Robot(id.to_owned()))?;
        let path = own.folder.join(format!("{id}.pem"));
        private::replace(&path, identity.to_pem().as_bytes()).map_err(|error| error.to_string())?;
        Ok(Some(format!("fleet.keys={:?}", path.display().to_string())))
    }
}
