//! From one marking to where a net comes to rest, in every order in which its transitions can fire.

use alloc::boxed::Box;
use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;

use crate::petri::{Net, PlaceId, TransitionId};

/// Which places are marked, one bit each.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Marking(Box<[u64]>);

impl Marking {
    pub(super) fn initial(net: &Net) -> Self {
        let mut marking = Self(vec![0; net.places().len().div_ceil(64)].into());
        for place in net.initial_marking() {
            marking.flip(place);
        }
        marking
    }

    pub(super) fn has(&self, place: PlaceId) -> bool {
        self.0[place.index() / 64] & (1 << (place.index() % 64)) != 0
    }

    pub(super) fn flip(&mut self, place: PlaceId) {
        self.0[place.index() / 64] ^= 1 << (place.index() % 64);
    }
}

/// Where a net rests, and what it fired on the way.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    /// Sinks are empty; sources may hold what nothing uses.
    pub(super) at: Marking,
    /// Sinks that were emptied, in the order of one way among several.
    pub(super) outputs: Vec<PlaceId>,
    /// Whether a transition fired.
    pub(super) fired: bool,
}

impl Settled {
    /// Whether both are the same but for the order of outputs, which a net does not know.
    fn is_same(&self, other: &Self, event_of: impl Fn(PlaceId) -> u16) -> bool {
        let events = |settled: &Self| {
            let mut events: Vec<u16> = settled.outputs.iter().map(|&sink| event_of(sink)).collect();
            events.sort_unstable();
            events
        };
        self.at == other.at && events(self) == events(other)
    }
}

/// Why a net does not come to rest in one way.
#[derive(Debug)]
pub(super) enum Failure {
    /// The same marking again, without an event in between.
    Endless,
    /// Two ends, depending on which transitions fire first.
    Undetermined(Box<[Settled; 2]>),
    /// More markings than the limit.
    TooMany,
}

/// Knows what it found before: markings come again from other states.
pub(super) struct Settling<'a> {
    net: &'a Net,
    limit: usize,
    /// `None` while the ways from there are still looked at.
    known: BTreeMap<Marking, Option<Settled>>,
}

/// A marking whose ways are being looked at.
struct Visit {
    at: Marking,
    /// What is emptied on the way to all that follows: sinks, if nothing was enabled.
    drained: Vec<PlaceId>,
    fires: bool,
    next: Vec<Marking>,
    result: Option<Settled>,
}

impl<'a> Settling<'a> {
    pub(super) fn new(net: &'a Net, limit: usize) -> Self {
        Self {
            net,
            limit,
            known: BTreeMap::new(),
        }
    }

    /// Follows all orders of firing, depth first without recursion. The markings are finite, so the net goes on for ever in some
    /// order exactly if a marking comes again on one way.
    pub(super) fn settle(&mut self, from: Marking) -> Result<Settled, Failure> {
        if let Some(Some(settled)) = self.known.get(&from) {
            return Ok(settled.clone());
        }
        let mut visits = vec![self.begin(from)?];
        loop {
            let visit = visits.last_mut().expect("one is there until it returns");
            if let Some(next) = visit.next.pop() {
                match self.known.get(&next) {
                    Some(Some(settled)) => {
                        let settled = settled.clone();
                        self.add(visit, settled)?;
                    }
                    Some(None) => return Err(Failure::Endless),
                    None => visits.push(self.begin(next)?),
                }
                continue;
            }
            let Visit { at, result, .. } = visits.pop().expect("it is the last one");
            let result = result.unwrap_or_else(|| Settled {
                at: at.clone(),
                outputs: Vec::new(),
                fired: false,
            });
            self.known.insert(at, Some(result.clone()));
            match visits.last_mut() {
                Some(before) => self.add(before, result)?,
                None => return Ok(result),
            }
        }
    }

    fn begin(&mut self, at: Marking) -> Result<Visit, Failure> {
        if self.known.len() >= self.limit {
            return Err(Failure::TooMany);
        }
        self.known.insert(at.clone(), None);
        let enabled = self
            .net
            .transitions()
            .filter(|&each| self.is_enabled(&at, each));
        // The last is taken first.
        let mut next: Vec<Marking> = enabled.map(|each| self.fired(&at, each)).collect();
        next.reverse();
        let fires = !next.is_empty();
        let mut drained = Vec::new();
        if !fires {
            let full = self.net.sinks().iter().map(|&(sink, _)| sink);
            drained.extend(full.filter(|&sink| at.has(sink)));
            if !drained.is_empty() {
                let mut emptied = at.clone();
                drained.iter().for_each(|&sink| emptied.flip(sink));
                next.push(emptied);
            }
        }
        Ok(Visit {
            at,
            drained,
            fires,
            next,
            result: None,
        })
    }

    /// What one of the ways from `visit` leads to; it must be what the others lead to.
    fn add(&self, visit: &mut Visit, behind: Settled) -> Result<(), Failure> {
        let mut outputs = visit.drained.clone();
        outputs.extend(behind.outputs);
        let found = Settled {
            at: behind.at,
            outputs,
            fired: visit.fires || behind.fired,
        };
        let event_of = |sink: PlaceId| {
            let sinks = self.net.sinks();
            let index = sinks.iter().position(|&(place, _)| place == sink);
            index.map_or(u16::MAX, |index| sinks[index].1.0)
        };
        match visit.result.take() {
            Some(first) if !first.is_same(&found, event_of) => {
                Err(Failure::Undetermined(Box::new([first, found])))
            }
            first => {
                visit.result = Some(first.unwrap_or(found));
                Ok(())
            }
        }
    }

    fn is_enabled(&self, at: &Marking, transition: TransitionId) -> bool {
        let structure = self.net.structure();
        let inputs = structure.inputs(transition);
        let outputs = structure.outputs(transition);
        inputs.iter().all(|&place| at.has(place))
            && outputs
                .iter()
                .all(|place| inputs.contains(place) || !at.has(*place))
    }

    fn fired(&self, at: &Marking, transition: TransitionId) -> Marking {
        let structure = self.net.structure();
        let mut after = at.clone();
        for &place in structure
            .inputs(transition)
            .iter()
            .chain(structure.outputs(transition))
        {
            // A place that is both is flipped twice.
            after.flip(place);
        }
        after
    }
}
