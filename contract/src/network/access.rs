//! What each party may say and hear, as zenoh's access control holds it: by the name in its certificate. All else is denied.

use serde_json::{Value, json};

use super::identity::{Name, Party};
use crate::keys::{self, InvalidName};

/// Whom a session deals with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Access {
    /// With the mediator, whatever it says.
    MediatorOnly,
    /// With these robots and operators, each under keys of its own, and with another mediator of the site.
    Parties {
        /// First part of all keys.
        key_prefix: String,
        /// Present names of robots and operators, and the mediator's.
        names: Vec<Name>,
    },
}

impl Access {
    /// zenoh's `access_control`.
    ///
    /// # Errors
    /// [`InvalidName`] when a prefix or a name cannot be part of a key.
    pub(super) fn config(&self) -> Result<Value, InvalidName> {
        let mut table = Table::default();
        match self {
            Self::MediatorOnly => {
                let name = Name {
                    party: Party::Mediator,
                    generation: 1,
                };
                let all = [
                    "put",
                    "delete",
                    "declare_subscriber",
                    "query",
                    "reply",
                    "declare_queryable",
                    "liveliness_token",
                    "liveliness_query",
                    "declare_liveliness_subscriber",
                ];
                let both = ["ingress", "egress"];
                table.allow(&name, &[(&both, &all, vec!["**".to_owned()])]);
            }
            Self::Parties { key_prefix, names } => {
                for name in names {
                    match &name.party {
                        Party::Robot(id) => table.allow(name, &robot(key_prefix, id)?),
                        Party::Operator(own) => table.allow(name, &operator(key_prefix, own)?),
                        Party::Mediator => table.allow(name, &other_mediator(key_prefix)?),
                    }
                }
            }
        }
        Ok(table.config())
    }
}

/// Flows, messages, keys.
type Rule<'a> = (&'a [&'a str], &'a [&'a str], Vec<String>);

const IN: &[&str] = &["ingress"];
const OUT: &[&str] = &["egress"];

/// It speaks for itself, hears what is said to it, and sees that the mediator is there. The mediator's own subscriptions
/// reach it: else it would not send.
fn robot(prefix: &str, id: &str) -> Result<[Rule<'static>; 10], InvalidName> {
    let (report, state) = (keys::report(prefix, id)?, keys::state(prefix, id)?);
    let (said, alive) = (keys::to_robot(prefix, id)?, keys::alive(prefix, id)?);
    let certificate = keys::certificate(prefix, id)?;
    let (all_reports, all_states) = (keys::all_reports(prefix)?, keys::all_states(prefix)?);
    let (all_certificates, all_alive) = (keys::all_certificates(prefix)?, keys::all_alive(prefix)?);
    let mediator = keys::mediator_alive(prefix)?;
    Ok([
        (IN, &["put"], vec![report, state]),
        (IN, &["liveliness_token"], vec![alive]),
        (IN, &["declare_subscriber"], vec![said.clone()]),
        (OUT, &["put"], vec![said]),
        (IN, &["query"], vec![certificate.clone()]),
        (OUT, &["reply"], vec![certificate]),
        (
            OUT,
            &["declare_subscriber", "declare_queryable"],
            vec![all_reports, all_states, all_certificates],
        ),
        (
            OUT,
            &["liveliness_query", "declare_liveliness_subscriber"],
            vec![all_alive],
        ),
        (
            IN,
            &["liveliness_query", "declare_liveliness_subscriber"],
            vec![mediator.clone()],
        ),
        (OUT, &["liveliness_token"], vec![mediator]),
    ])
}

/// Two mediators of a site see that there are two, and nothing else of each other.
fn other_mediator(prefix: &str) -> Result<[Rule<'static>; 1], InvalidName> {
    let alive = [
        keys::mediator_alive(prefix)?,
        keys::all_mediator_instances(prefix)?,
    ];
    Ok([(
        &["ingress", "egress"],
        &[
            "liveliness_token",
            "liveliness_query",
            "declare_liveliness_subscriber",
        ],
        alive.to_vec(),
    )])
}

/// It hears everything, and asks under its own name.
fn operator(prefix: &str, name: &str) -> Result<[Rule<'static>; 4], InvalidName> {
    let question = keys::question(prefix, name)?;
    let all = format!("{prefix}/**");
    Ok([
        (IN, &["query"], vec![question.clone()]),
        (OUT, &["reply"], vec![question]),
        (
            IN,
            &[
                "declare_subscriber",
                "liveliness_query",
                "declare_liveliness_subscriber",
            ],
            vec![all.clone()],
        ),
        (OUT, &["put", "liveliness_token"], vec![all]),
    ])
}

#[derive(Default)]
struct Table {
    rules: Vec<Value>,
    subjects: Vec<Value>,
    policies: Vec<Value>,
}

impl Table {
    fn allow(&mut self, name: &Name, rules: &[Rule<'_>]) {
        let name = name.to_string();
        let mut ids = Vec::new();
        for (flows, messages, keys) in rules {
            let id = format!("{name} {}", ids.len());
            self.rules.push(json!({
                "id": id, "permission": "allow", "flows": flows, "messages": messages, "key_exprs": keys,
            }));
            ids.push(id);
        }
        self.subjects
            .push(json!({ "id": name, "cert_common_names": [name] }));
        self.policies
            .push(json!({ "rules": ids, "subjects": [name] }));
    }

    fn config(self) -> Value {
        json!({
            "enabled": true,
            "default_permission": "deny",
            "rules": self.rules,
            "subjects": self.subjects,
            "policies": self.policies,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_holds_no_token_but_its_own() {
        let rules = robot("fleet", "amr-1").expect("plain names");
        let held = { rules.into_iter() }
            .filter(|(flows, messages, _)| {
                flows.contains(&"ingress") && messages.contains(&"liveliness_token")
            })
            .flat_map(|(.., keys)| keys);
        assert_eq!(held.collect::<Vec<_>>(), ["fleet/robots/amr-1/alive"]);
    }
}
