//! Which names have certificates, and of which generation they must be.

use std::collections::BTreeMap;
use std::path::Path;

use contract::network::{Name, Party};
use serde::{Deserialize, Serialize};

use super::files;

/// The longest that a certificate may hold, days.
pub(super) const MOST_DAYS: f64 = 3650.0;

/// The list, as `identities.toml` has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Registry {
    /// How long certificates hold.
    pub days: f64,
    /// By id.
    #[serde(default)]
    pub robots: BTreeMap<String, Registered>,
    /// By name.
    #[serde(default)]
    pub operators: BTreeMap<String, Registered>,
}

/// A party that has got a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Registered {
    /// Of which its certificates are.
    pub generation: u32,
    /// Those of this generation mean nothing any more.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub revoked: bool,
}

impl Registry {
    pub(super) fn new(days: f64) -> Self {
        Self {
            days,
            robots: BTreeMap::new(),
            operators: BTreeMap::new(),
        }
    }

    pub(super) fn read(folder: &Path) -> Result<Self, String> {
        let path = folder.join(files::REGISTRY);
        let registry: Self = toml::from_str(&files::read(&path)?)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        if registry.days > 0.0 && registry.days <= MOST_DAYS {
            Ok(registry)
        } else {
            Err(format!(
                "{}: `days`: expected a number above 0 and at most {MOST_DAYS}, found {}",
                path.display(),
                registry.days
            ))
        }
    }

    pub(super) fn write(&self, folder: &Path) -> Result<(), String> {
        let text = toml::to_string(self).map_err(|error| error.to_string())?;
        files::write(&folder.join(files::REGISTRY), &text)
    }

    /// The names that count.
    #[must_use]
    pub fn names(&self) -> Vec<Name> {
        let robots = { self.robots.keys() }.map(|id| Party::Robot(id.clone()));
        let operators = { self.operators.keys() }.map(|name| Party::Operator(name.clone()));
        robots
            .chain(operators)
            .filter_map(|party| self.name(&party))
            .collect()
    }

    /// The name of a party whose certificates count.
    #[must_use]
    pub fn name(&self, party: &Party) -> Option<Name> {
        let registered = match party {
            Party::Mediator => None,
            Party::Robot(id) => self.robots.get(id),
            Party::Operator(name) => self.operators.get(name),
        };
        { registered.filter(|own| !own.revoked) }.map(|own| Name {
            party: party.clone(),
            generation: own.generation,
        })
    }

    /// The name for another certificate of this party.
    pub(super) fn admit(&mut self, party: Party) -> Name {
        let first = Registered {
            generation: 1,
            revoked: false,
        };
        let own = match &party {
            Party::Mediator => {
                return Name {
                    party,
                    generation: 1,
                };
            }
            Party::Robot(id) => self.robots.entry(id.clone()).or_insert(first),
            Party::Operator(name) => self.operators.entry(name.clone()).or_insert(first),
        };
        if own.revoked {
            *own = Registered {
                generation: own.generation.saturating_add(1),
                revoked: false,
            };
        }
        let generation = own.generation;
        Name { party, generation }
    }

    pub(super) fn revoke(&mut self, party: &Party) -> Result<Name, String> {
        let (what, id, own) = match party {
            Party::Mediator => {
                return Err("the mediator's certificate is made at each start".to_owned());
            }
            Party::Robot(id) => ("robot", id, self.robots.get_mut(id)),
            Party::Operator(name) => ("operator", name, self.operators.get_mut(name)),
        };
        let own = own
            .filter(|own| !own.revoked)
            .ok_or_else(|| format!("{what} `{id}` has no certificate that counts"))?;
        own.revoked = true;
        Ok(Name {
            party: party.clone(),
            generation: own.generation,
        })
    }
}
