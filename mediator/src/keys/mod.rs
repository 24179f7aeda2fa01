//! Who is who on a site's network: the site's authority, the certificates that it makes, and those that it has revoked.
//!
//! A folder holds the authority's key (`authority.key`), its certificate (`authority.crt`, no secret), and which generations of
//! which names count (`identities.toml`). A running mediator looks at that list once a second; what it reads when it opens its
//! network is a [`Snapshot`], by which it makes certificates until it opens the network again.

mod authority;
mod files;
mod registry;
mod renewals;

use std::path::{Path, PathBuf};

use contract::network::{Access, Identity, LONGEST_NAME, Name, Party, Security};
use description::names::is_key_part;

use authority::Authority;
use files::Guard;
pub use registry::{Registered, Registry};
pub(crate) use renewals::Renewals;

/// The keys of one site.
#[derive(Clone, Debug)]
pub struct Keys {
    folder: PathBuf,
}

impl Keys {
    /// The keys in a folder, which need not be there.
    #[must_use]
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Where they are.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether the site has an authority.
    #[must_use]
    pub fn exist(&self) -> bool {
        self.folder.join(files::AUTHORITY_KEY).exists()
    }

    /// Makes the site's authority, whose certificates hold for so many days.
    ///
    /// # Errors
    /// A sentence: there is one already, or the files cannot be written.
    pub fn begin(&self, site: &str, days: f64) -> Result<(), String> {
        if self.exist() {
            return Err(format!(
                "{} has the keys of a site already; take the folder away to begin anew: then every robot needs another file",
                self.folder.display()
            ));
        }
        if !(days.is_finite() && days > 0.0 && days <= registry::MOST_DAYS) {
            return Err(format!(
                "days: expected a number above 0 and at most {}, found {days}",
                registry::MOST_DAYS
            ));
        }
        let made = Authority::make(site)?;
        files::make_folder(&self.folder)?;
        Registry::new(days).write(&self.folder)?;
        files::write(
            &self.folder.join(files::AUTHORITY_CERTIFICATE),
            made.certificate(),
        )?;
        // Last: without it, there is no authority.
        files::write(&self.folder.join(files::AUTHORITY_KEY), &made.key())
    }

    /// Makes an identity. One that was revoked gets its next generation.
    ///
    /// # Errors
    /// A sentence: the name cannot be used, there is no authority, or the files cannot be read or written.
    pub fn issue(&self, party: Party) -> Result<Identity, String> {
        check(&party)?;
        let _guard = Guard::of(&self.folder)?;
        let (authority, mut registry) = self.read()?;
        let name = registry.admit(party);
        let identity = authority.identity(&name, registry.days)?;
        registry.write(&self.folder)?;
        Ok(identity)
    }

    /// Makes all certificates of a party, which have been made so far, mean nothing.
    ///
    /// # Errors
    /// A sentence: it has none, or the files cannot be read or written.
    pub fn revoke(&self, party: &Party) -> Result<Name, String> {
        let _guard = Guard::of(&self.folder)?;
        let (_, mut registry) = self.read()?;
        let revoked = registry.revoke(party)?;
        registry.write(&self.folder)?;
        Ok(revoked)
    }

    /// What they say at present.
    ///
    /// # Errors
    /// A sentence: there is no authority, or the files cannot be read.
    pub fn snapshot(&self) -> Result<Snapshot, String> {
        let (authority, registry) = self.read()?;
        Ok(Snapshot {
            authority,
            registry,
        })
    }

    /// The list as it is now.
    ///
    /// # Errors
    /// A sentence: it cannot be read.
    pub fn registry(&self) -> Result<Registry, String> {
        Registry::read(&self.folder)
    }

    fn read(&self) -> Result<(Authority, Registry), String> {
        if !self.exist() {
            return Err(format!(
                "{} has no keys: make them with `mediator keys site`",
                self.folder.display()
            ));
        }
        let read = |name: &str| files::read(&self.folder.join(name));
        let (key, certificate) = (
            read(files::AUTHORITY_KEY)?,
            read(files::AUTHORITY_CERTIFICATE)?,
        );
        let authority = Authority::load(&key, certificate)
            .map_err(|error| format!("the authority in {}: {error}", self.folder.display()))?;
        Ok((authority, Registry::read(&self.folder)?))
    }
}

/// The keys of a site as they were when the network was opened.
pub struct Snapshot {
    authority: Authority,
    registry: Registry,
}

impl Snapshot {
    /// The list that it was made by.
    #[must_use]
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// How the mediator takes part: under a new key of its own, with the robots and operators of the list.
    ///
    /// # Errors
    /// A sentence: no certificate can be made.
    pub fn security(&self, key_prefix: &str) -> Result<Security, String> {
        let own = Name {
            party: Party::Mediator,
            generation: 1,
        };
        let identity = self.authority.identity(&own, self.registry.days)?;
        let mut names = self.registry.names();
        names.push(own);
        Ok(Security {
            identity,
            access: Access::Parties {
                key_prefix: key_prefix.to_owned(),
                names,
            },
        })
    }

    /// The certificate that a robot asks for, of the generation that it asks with.
    ///
    /// # Errors
    /// A sentence: the robot is not on the list, or what it sent is no request.
    pub(crate) fn certificate(&self, robot: &str, request: &str) -> Result<String, String> {
        let party = Party::Robot(robot.to_owned());
        let name = { self.registry.name(&party) }
            .ok_or_else(|| format!("robot `{robot}` has no certificate that counts"))?;
        self.authority.sign(&name, request, self.registry.days)
    }
}

fn check(party: &Party) -> Result<(), String> {
    let (what, name) = match party {
        Party::Mediator => return Err("the mediator makes its own certificate".to_owned()),
        Party::Robot(id) => ("robot", id),
        Party::Operator(name) => ("operator", name),
    };
    let longest = Name {
        party: party.clone(),
        generation: u32::MAX,
    };
    if is_key_part(name) && longest.to_string().len() <= LONGEST_NAME {
        return Ok(());
    }
    Err(format!(
        "{what} `{name}`: expected letters, digits, `-`, `_` or `.`, at most {} of them",
        LONGEST_NAME - (longest.to_string().len() - name.len())
    ))
}

#[cfg(test)]
mod tests;
