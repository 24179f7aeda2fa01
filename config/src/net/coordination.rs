//! From a net file to models that compile, and to their analysis.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use ::coordination::analysis::{Limits, Proof, Refusal, Situation, Use, check_situations};
use ::coordination::petri::{NetModel, PlaceKind};
use ::coordination::protocol::{Party, Protocol, ProtocolModel};

use super::data::{
    MEDIATOR, NetConfig, NetFlag, NetParty, NetPlace, NetProtocol, NetSet, NetSituation,
    NetTransition,
};

impl NetConfig {
    /// The situation with this id.
    #[must_use]
    pub fn situation(&self, id: &str) -> Option<&NetSituation> {
        self.situations.iter().find(|situation| situation.id == id)
    }

    /// The place with this id.
    #[must_use]
    pub fn place(&self, id: &str) -> Option<&NetPlace> {
        self.places.iter().find(|place| place.id == id)
    }

    /// The compiled protocol of a role: the first party is the role, the second the mediator.
    #[must_use]
    pub fn protocol(&self, role: &str) -> Option<&Arc<Protocol>> {
        self.compiled.get(role)
    }

    /// What the file says about a flag of a role. A flag in several arrays of its protocol is
    /// described where it stands first.
    #[must_use]
    pub fn flag(&self, role: &str, flag: &str) -> Option<&NetFlag> {
        let role = self.roles.iter().find(|own| own.id == role)?;
        let protocol = self.protocols.iter().find(|own| own.id == role.protocol)?;
        let mut flags = protocol.arrays.iter().flat_map(|array| &array.flags);
        flags.find(|own| own.flag == flag)
    }

    /// All areas that some flag lets a robot enter.
    #[must_use]
    pub fn areas(&self) -> BTreeSet<&str> {
        self.protocols
            .iter()
            .flat_map(|protocol| &protocol.arrays)
            .flat_map(|array| &array.flags)
            .flat_map(|flag| names(&flag.command.enters))
            .collect()
    }

    /// The protocols that the net takes part in, as the analysis wants them.
    #[must_use]
    pub fn uses(&self) -> Vec<Use> {
        self.compiled
            .iter()
            .map(|(role, protocol)| Use::new(role, Arc::clone(protocol), Party::Second))
            .collect()
    }

    /// The net as it begins in a situation. Places that nothing can mark from there, and transitions
    /// that need one of them, are left out.
    #[must_use]
    pub fn model(&self, situation: &str) -> Option<NetModel> {
        let marked = &self.situation(situation)?.marked;
        let (places, transitions) = self.possible(marked);
        let has = |place: &&str| places.contains(place);
        let mut model = NetModel::new(&self.name);
        for place in self.places.iter().filter(|place| has(&place.id.as_str())) {
            match (place.kind, &place.binding) {
                (PlaceKind::Source, Some(binding)) => model.source(&place.id, binding.clone()),
                (PlaceKind::Sink, Some(binding)) => model.sink(&place.id, binding.clone()),
                _ => model.place(&place.id),
            };
        }
        for transition in transitions {
            model.transition(
                &transition.id,
                &names(&transition.from),
                &names(&transition.to),
            );
        }
        for place in marked {
            model.mark(place);
        }
        for set in &self.exclusions {
            let left: Vec<&str> = names(&set.places).into_iter().filter(has).collect();
            if left.len() > 1 {
                model.exclusion(&set.id, &left);
            }
        }
        for NetSet { id, places } in &self.ends {
            if names(places).iter().all(has) {
                model.end(id, &names(places));
            }
        }
        if self.endless {
            model.allow_endless();
        }
        Some(model)
    }

    /// The net in all its situations, with their names.
    #[must_use]
    pub fn models(&self) -> Vec<(&str, NetModel)> {
        let ids = self
            .situations
            .iter()
            .map(|situation| situation.id.as_str());
        ids.filter_map(|id| Some((id, self.model(id)?))).collect()
    }

    /// Proves that the net may run, from each of its situations, in their order.
    ///
    /// # Errors
    /// What is wrong, and the shortest way there.
    pub fn analyse(&self, limits: &Limits) -> Result<Vec<Proof>, Refusal> {
        let models = self.models();
        let situations: Vec<Situation<'_>> = models
            .iter()
            .map(|(name, model)| Situation { name, model })
            .collect();
        check_situations(&situations, &self.uses(), limits)
    }

    /// Places that a transition, a robot or an event might mark, and transitions whose inputs are all among them. It
    /// removes only what nothing feeds; it does not search reachable markings.
    fn possible<'a>(&'a self, marked: &'a [String]) -> (BTreeSet<&'a str>, Vec<&'a NetTransition>) {
        let mut feeders: BTreeMap<&str, usize> = BTreeMap::new();
        let mut users: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        let sources = self.places.iter().filter(|p| p.kind == PlaceKind::Source);
        let fed = sources.map(|place| &place.id).chain(marked);
        for place in fed.chain(self.transitions.iter().flat_map(|t| &t.to)) {
            *feeders.entry(place).or_default() += 1;
        }
        for (index, transition) in self.transitions.iter().enumerate() {
            for place in &transition.from {
                users.entry(place).or_default().push(index);
            }
        }
        let mut possible = vec![true; self.transitions.len()];
        let unfed = users.keys().filter(|place| !feeders.contains_key(*place));
        let mut dry: Vec<&str> = unfed.copied().collect();
        while let Some(place) = dry.pop() {
            for &user in users.get(place).into_iter().flatten() {
                if std::mem::replace(&mut possible[user], false) {
                    for place in &self.transitions[user].to {
                        let left = feeders.entry(place).or_default();
                        *left = left.saturating_sub(1);
                        if *left == 0 {
                            dry.push(place);
                        }
                    }
                }
            }
        }
        let numbered = self.transitions.iter().zip(possible);
        let left: Vec<_> = numbered
            .filter_map(|(t, possible)| possible.then_some(t))
            .collect();
        let touched = left.iter().flat_map(|t| t.from.iter().chain(&t.to));
        let touched = touched.chain(marked).map(String::as_str).collect();
        (touched, left)
    }
}

fn names(ids: &[String]) -> Vec<&str> {
    ids.iter().map(String::as_str).collect()
}

impl NetProtocol {
    /// The protocol as it is between a robot in this role and the mediator.
    pub(crate) fn model(&self, role: &str) -> ProtocolModel {
        let party = |by: NetParty| match by {
            NetParty::Robot => role,
            NetParty::Mediator => MEDIATOR,
        };
        let mut model = ProtocolModel::new(&self.id, role, MEDIATOR);
        if let Some(keeper) = self.keeper {
            model.keeper(party(keeper));
        }
        for start in &self.start {
            model.start(start);
        }
        for array in &self.arrays {
            let flags = array.flags.iter();
            let entries: Vec<_> = flags
                .map(|own| (own.flag.as_str(), party(own.by)))
                .collect();
            model.array(&array.id, &entries);
            for next in &array.then {
                model.follow(&array.id, next);
            }
        }
        model
    }
}
