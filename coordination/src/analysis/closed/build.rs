//! From a model and its protocols to a closed net.

use std::collections::HashMap;

use super::super::flags::{NamedProtocol, Outside, check_names, resolve};
use super::super::refusal::Reason;
use super::super::state::Layout;
use super::super::usage::{Limits, Use};
use super::net::{Arcs, Bound, Closed, Set};
use crate::petri::{ModelError, NetModel, PlaceKind};

impl<'a> Closed<'a> {
    /// The net must compile.
    pub(in crate::analysis) fn new(
        model: &NetModel,
        uses: &'a [Use],
        limits: &Limits,
    ) -> Result<Self, Box<Reason>> {
        Self::build(model, uses, limits, |_| true)
    }

    /// A net that is only looked at may have places that nothing fills, or nothing empties.
    pub(in crate::analysis) fn of_any(
        model: &NetModel,
        uses: &'a [Use],
        limits: &Limits,
    ) -> Result<Self, Box<Reason>> {
        Self::build(model, uses, limits, |error| {
            !matches!(
                error,
                ModelError::UnboundSource { .. }
                    | ModelError::UnboundSink { .. }
                    | ModelError::IsolatedPlace { .. }
            )
        })
    }

    fn build(
        model: &NetModel,
        uses: &'a [Use],
        limits: &Limits,
        matters: impl Fn(&ModelError) -> bool,
    ) -> Result<Self, Box<Reason>> {
        let mut errors = model.check();
        errors.retain(matters);
        if !errors.is_empty() {
            return Err(Box::new(Reason::Model(errors)));
        }
        let protocols: Vec<NamedProtocol<'_>> = uses.iter().map(Use::named).collect();
        check_names(&protocols)?;
        let mut closed = Self {
            uses,
            places: Vec::new(),
            event_names: Vec::new(),
            kinds: Vec::new(),
            outside: Vec::new(),
            counters: Vec::new(),
            transitions: Vec::new(),
            first_input: vec![Vec::new(); model.places().len()],
            bound: uses.iter().map(Bound::new).collect(),
            event_sources: Vec::new(),
            event_sinks: Vec::new(),
            exclusions: Vec::new(),
            safe: vec![false; model.places().len()],
            ends: Vec::new(),
            at_end: vec![0; model.places().len().div_ceil(64)],
            initial: Vec::new(),
            max_waiting: limits.waiting,
            endless: model.allows_endless(),
            layout: Layout::new(0, 0, 0),
        };
        let mut marked = Vec::new();
        let mut counted = 0;
        for place in model.places() {
            let number = closed.places.len() as u32;
            let outside = resolve(&protocols, &place)?;
            closed.bind(number, place.kind, outside, &mut counted);
            closed.places.push(place.name.to_owned());
            closed.event_names.push(
                place
                    .binding
                    .map_or_else(String::new, |binding| binding.event_name()),
            );
            if place.marked {
                marked.push(number);
            }
        }
        closed.check_aborts()?;
        let names: HashMap<&str, u32> = closed.places.iter().map(String::as_str).zip(0..).collect();
        let find = |places: &[&str]| -> Vec<u32> {
            places
                .iter()
                .filter_map(|place| names.get(place).copied())
                .collect()
        };
        for transition in model.transitions() {
            let (inputs, outputs) = (find(&transition.inputs), find(&transition.outputs));
            let arcs = Arcs::new(inputs, outputs, &closed.kinds);
            if let Some(&first) = arcs.inputs.first() {
                closed.first_input[first as usize].push(closed.transitions.len() as u32);
            }
            closed.transitions.push((transition.name.to_owned(), arcs));
        }
        closed.layout = Layout::new(closed.places.len(), uses.len(), counted);
        closed.initial = vec![0; closed.layout.words];
        for place in marked {
            closed.layout.mark(&mut closed.initial, place);
        }
        let words = closed.at_end.len();
        let set = |(name, places): (&str, Vec<&str>)| Set {
            name: name.to_owned(),
            words: words_of(&find(&places), words),
        };
        closed.exclusions = model
            .exclusions()
            .map(|e| set((e.name, e.places)))
            .collect();
        closed.ends = model.ends().map(|e| set((e.name, e.places))).collect();
        Ok(closed)
    }

    /// Where the other party can give up a run, the net must hear of it, and be able to take back
    /// what belongs to it.
    fn check_aborts(&self) -> Result<(), Box<Reason>> {
        for (used, bound) in self.uses.iter().zip(&self.bound) {
            if used.protocol.keeper() != Some(used.net_party.other()) {
                continue;
            }
            let protocol = used.name.clone();
            if bound.aborts.is_empty() {
                return Err(Box::new(Reason::UnreadAbort { protocol }));
            }
            let mut flags = used.protocol.flags();
            if let Some((_, flag, _)) = flags.find(|(id, ..)| bound.sources[id.index()].len() > 1) {
                let flag = flag.to_owned();
                return Err(Box::new(Reason::SeveralSources { protocol, flag }));
            }
        }
        Ok(())
    }

    fn bind(&mut self, place: u32, kind: PlaceKind, outside: Outside, counted: &mut usize) {
        let mut counter = None;
        match (kind, outside) {
            (PlaceKind::Source, Outside::Flag(protocol, flag)) => {
                counter = Some(*counted);
                let sources = &mut self.bound[usize::from(protocol)].sources;
                sources[flag.index()].push((place, *counted));
            }
            (PlaceKind::Source, Outside::Abort(protocol)) => {
                counter = Some(*counted);
                self.bound[usize::from(protocol)]
                    .aborts
                    .push((place, *counted));
            }
            (PlaceKind::Source, _) => self.event_sources.push(place),
            (PlaceKind::Sink, Outside::Flag(protocol, flag)) => {
                self.bound[usize::from(protocol)].sinks.push((place, flag));
            }
            (PlaceKind::Sink, _) => self.event_sinks.push(place),
            (PlaceKind::Internal, _) => {}
        }
        *counted += usize::from(counter.is_some());
        if (kind, outside) != (PlaceKind::Source, Outside::Event) {
            self.at_end[place as usize / 64] |= 1 << (place % 64);
        }
        self.kinds.push(kind);
        self.outside.push(outside);
        self.counters.push(counter);
    }
}

impl Bound {
    fn new(used: &Use) -> Self {
        Self {
            positions: used.protocol.positions().collect(),
            sources: vec![Vec::new(); used.protocol.flags().count()],
            aborts: Vec::new(),
            sinks: Vec::new(),
        }
    }
}

impl Arcs {
    fn new(inputs: Vec<u32>, outputs: Vec<u32>, kinds: &[PlaceKind]) -> Self {
        let mut sorted = (inputs.clone(), outputs.clone());
        sorted.0.sort_unstable();
        sorted.1.sort_unstable();
        let is_new = |place: &u32| sorted.0.binary_search(place).is_err();
        let stays = |place: &u32| sorted.1.binary_search(place).is_ok();
        let (sinks, internal) = outputs
            .into_iter()
            .filter(is_new)
            .partition(|&place| kinds[place as usize] == PlaceKind::Sink);
        Self {
            taken: inputs
                .iter()
                .copied()
                .filter(|place| !stays(place))
                .collect(),
            inputs,
            internal,
            sinks,
        }
    }
}

fn words_of(places: &[u32], words: usize) -> Vec<u64> {
    let mut set = vec![0; words];
    for place in places {
        set[*place as usize / 64] |= 1 << (place % 64);
    }
    set
}
