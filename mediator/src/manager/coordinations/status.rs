//! How a coordination stands, for people.

use serde::{Deserialize, Serialize};

use crate::manager::names::Names;
use crate::nets::{Instance, Phase};

/// A coordination, for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CoordinationStatus {
    /// Its number.
    pub number: u64,
    /// Its id in the site file.
    pub id: String,
    /// The net.
    pub net: String,
    /// In which situation it began; empty: its robots are told to get out of the way.
    pub situation: String,
    /// Roles of the net and the robots that play them.
    pub robots: Vec<(String, String)>,
    /// The marked places.
    pub marking: Vec<String>,
    /// The last transitions that fired, each with the milliseconds since its start.
    pub firings: Vec<(String, u64)>,
    /// How many have fired.
    pub fired: u64,
    /// By role: what its robot waits for.
    pub waits: Vec<String>,
    /// Milliseconds from its start, or since the mediator's, to now or to its end.
    pub age_ms: u64,
    /// Milliseconds since a flag was set.
    pub still_ms: u64,
    /// It is over.
    pub over: bool,
}

impl CoordinationStatus {
    pub(crate) fn of(instance: &Instance, names: &Names, now_ns: u64) -> Self {
        let name = |robot: usize| names.robot_id(robot);
        let ms = |from_ns: u64, to_ns: u64| to_ns.saturating_sub(from_ns) / 1_000_000;
        let roles = instance.plan.roles.iter().zip(instance.participants());
        Self {
            number: instance.number,
            id: instance.plan.id.clone(),
            net: instance.plan.net.clone(),
            situation: match instance.phase {
                Phase::Running { situation, .. } => {
                    instance.plan.situations[situation].name.clone()
                }
                Phase::Yielding(_) => String::new(),
            },
            robots: roles
                .map(|(role, participant)| (role.name.clone(), name(participant.robot)))
                .collect(),
            marking: instance.marking(),
            firings: { instance.firings.iter() }
                .map(|firing| {
                    let at_ms = ms(instance.since_ns, firing.at_ns);
                    (firing.transition.clone(), at_ms)
                })
                .collect(),
            fired: instance.fired,
            waits: (0..instance.participants().len())
                .map(|role| instance.why(role, name))
                .collect(),
            age_ms: ms(instance.since_ns, now_ns),
            still_ms: ms(instance.progress_ns, now_ns),
            over: false,
        }
    }
}
