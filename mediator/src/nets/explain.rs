//! What an instance waits for, in sentences.

use super::instance::{Instance, Phase};
use super::participant::Participant;
use coordination::binding::NetBinding;
use coordination::petri::{Obstacle, PlaceId, TransitionId};
use coordination::protocol::{FlagId, Party, Side};

impl Instance {
    /// What the robot of a role waits for in this coordination, by `name`s of robots.
    pub(crate) fn why(&self, role: usize, name: impl Fn(usize) -> String) -> String {
        let participant = &self.participants()[role];
        let protocol = participant.protocol();
        let next: Vec<FlagId> = { protocol.next(participant.read_to()) }
            .map(|(flag, _)| flag)
            .collect();
        let names: Vec<&str> = next.iter().map(|&flag| protocol.flag_name(flag)).collect();
        let names = names.join("` or `");
        if { next.first() }.is_some_and(|&flag| protocol.owner(flag) == Some(Party::First)) {
            let script = self.script(role);
            let outputs: Vec<&str> = { next.iter() }
                .map(|flag| script.flags[flag.index()].on_output.as_str())
                .filter(|output| !output.is_empty())
                .collect();
            let when = if outputs.is_empty() {
                String::new()
            } else {
                let outputs = outputs.join("` or `");
                format!(", when its state machine fires `{outputs}`")
            };
            return format!("it is to set the flag `{names}` itself{when}");
        }
        match &self.phase {
            Phase::Yielding(_) => self.why_yielding(role, name),
            Phase::Running { net, .. } => {
                let why = { next.iter() }
                    .filter_map(|&flag| self.why_not(net, role, flag, &name))
                    .min_by_key(|(missing, _)| *missing);
                match why {
                    Some((_, why)) => why,
                    None => format!("no transition of net {} sets `{names}`", self.plan.net),
                }
            }
        }
    }

    fn why_yielding(&self, role: usize, name: impl Fn(usize) -> String) -> String {
        let open: Vec<String> = { self.participants().iter().enumerate() }
            .filter(|(other, _)| !self.has_read_halt(*other))
            .map(|(_, participant)| name(participant.robot))
            .collect();
        let states = { self.plan.preempt.as_ref() }
            .map(|preempt| preempt.yields[role].states.join(", "))
            .unwrap_or_default();
        if open.is_empty() {
            format!("all robots get out of the way first, this one to one of the states {states}")
        } else {
            let open = open.join(", ");
            format!("all robots are told to get out of the way, and {open} has not heard it yet")
        }
    }

    /// The transition that lacks least for setting a flag, and how much it lacks.
    fn why_not(
        &self,
        running: &NetBinding<Participant>,
        role: usize,
        flag: FlagId,
        name: &impl Fn(usize) -> String,
    ) -> Option<(usize, String)> {
        let executor = running.executor();
        let net = executor.net();
        let structure = net.structure();
        let sinks: Vec<PlaceId> = { net.sinks().iter() }
            .map(|&(place, _)| place)
            .filter(|&place| running.flag_of(place) == Some((role, flag)))
            .collect();
        let sets = |transition: &TransitionId| {
            let outputs = structure.outputs(*transition);
            sinks.iter().any(|sink| outputs.contains(sink))
        };
        let (transition, lacks) = net
            .transitions()
            .filter(sets)
            .map(|transition| (transition, executor.why_not(transition).collect::<Vec<_>>()))
            .min_by_key(|(_, obstacles)| obstacles.len())?;
        let transition = format!("transition `{}`", net.transition_name(transition));
        let net_name = &self.plan.net;
        if lacks.is_empty() {
            return Some((
                0,
                format!("{transition} of net {net_name} is about to fire"),
            ));
        }
        let lacks_names: Vec<String> = { lacks.iter() }
            .map(|&obstacle| match obstacle {
                Obstacle::Empty(place) => {
                    let place_name = net.place_name(place);
                    let meaning = self.meaning(running, place, place_name, name);
                    format!("lacks a token in `{place_name}` ({meaning})")
                }
                other => format!("waits, since {}", other.describe(net)),
            })
            .collect();
        let why = format!(
            "{transition} of net {net_name} {}",
            lacks_names.join(" and ")
        );
        Some((lacks.len(), why))
    }

    fn meaning(
        &self,
        running: &NetBinding<Participant>,
        place: PlaceId,
        place_name: &str,
        name: &impl Fn(usize) -> String,
    ) -> String {
        if let Some((role, flag)) = running.flag_of(place) {
            let participant = &running.sides()[role];
            let flag = participant.protocol().flag_name(flag);
            return format!("{} has not set `{flag}`", name(participant.robot));
        }
        { self.plan.meanings.get(place_name) }
            .filter(|meaning| !meaning.is_empty())
            .cloned()
            .unwrap_or_else(|| "a place of its own".to_owned())
    }
}
