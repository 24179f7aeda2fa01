//! The search through all states at once, and what it proves.

use super::super::closed::rule::{Meaning, Rule};
use super::super::closed::{Closed, Move};
use super::super::explored::Fault;
use super::super::kept::Kept;
use super::super::never::{EXPLAINED, Found};
use super::super::refusal::{Dead, Reason, Trace};
use super::super::report::Warning;
use super::super::usage::Limits;
use super::deep::{Looked, deep, in_spaces};
use super::diagram::{Counts, Grown, Set};
use super::layers::Ways;
use super::space::Space;
use super::sweep::{Sweep, Way};

/// All states of a net that has no fault, without their diagram.
pub(in crate::analysis) struct Symbolic<'a> {
    pub(in crate::analysis) closed: Closed<'a>,
    pub(in crate::analysis) all: All,
}

/// What is known of all states.
pub(in crate::analysis) struct All {
    pub(in crate::analysis) kept: Kept,
    pub(in crate::analysis) meanings: Vec<Meaning>,
    pub(in crate::analysis) states: u128,
    pub(in crate::analysis) steps: u128,
    pub(in crate::analysis) ends: Vec<String>,
    pub(in crate::analysis) warnings: Vec<Warning>,
    fired: Vec<bool>,
    /// Why transitions did not fire, by transition.
    dead: Vec<(usize, Dead)>,
}

impl<'a> Symbolic<'a> {
    /// Looks at all states; they must not be less than the limits say, but their diagram.
    pub(in crate::analysis) fn new(closed: Closed<'a>, limits: &Limits) -> Result<Self, Fault> {
        let all = deep(limits, || in_spaces(&closed, limits, search))?;
        Ok(Self { closed, all: *all })
    }
}

impl Found for Symbolic<'_> {
    fn closed(&self) -> &Closed<'_> {
        &self.closed
    }

    fn fired(&self) -> &[bool] {
        &self.all.fired
    }

    fn explain(&self, transition: usize) -> Dead {
        let known = self
            .all
            .dead
            .iter()
            .find(|(number, _)| *number == transition);
        known.map_or_else(
            || Dead {
                transition: self.closed.transition_name(transition).to_owned(),
                lacks: Vec::new(),
                nearest: Trace::default(),
            },
            |(_, dead)| dead.clone(),
        )
    }
}

/// A search of one space.
struct Search<'s, 'a> {
    space: &'s Space<'a>,
    ways: Ways,
}

fn search(space: &Space<'_>) -> Grown<Looked<Box<All>>> {
    let all = space.reach(&space.initial()?)?;
    let ways = Ways::new(all.clone(), space)?;
    let mut search = Search { space, ways };
    let faulty = space.faulty(&all)?;
    if faulty.waits {
        return Ok(Looked::Waits);
    }
    match search.ways.nearest(&faulty.kinds, space)? {
        None => search.prove(&all),
        Some((state, trace)) => Ok(Looked::Fault((space.reason(&state)?, Some(trace)))),
    }
}

impl Search<'_, '_> {
    /// One of the nearest of these states, as the search of each state has them.
    fn nearest(&mut self, targets: Set) -> Grown<Option<(Vec<u64>, Trace)>> {
        if targets.is_empty() {
            return Ok(None);
        }
        let found = self.ways.nearest(&[targets], self.space)?;
        Ok(found.map(|(state, trace)| (self.space.state(&state), trace)))
    }

    fn prove(mut self, all: &Set) -> Grown<Looked<Box<All>>> {
        let (space, closed) = (self.space, self.space.closed);
        let (mut ends, mut warnings) = (Vec::new(), Vec::new());
        if closed.end_names().next().is_none() {
            warnings.push(Warning::NoEnds);
            if let Some(fault) = self.unfinished(all)? {
                return Ok(Looked::Fault(fault));
            }
        } else {
            let mut targets = space.empty();
            for (name, end) in closed.end_names().zip(space.ends()?) {
                let own = end.and(all)?.minus(&targets)?;
                if !own.is_empty() {
                    ends.push(name.to_owned());
                }
                targets = targets.union(&own)?;
            }
            let can = space.can_reach(all, &targets, |_| true)?;
            if let Some((state, trace)) = self.nearest(all.minus(&can)?)? {
                let marked = closed.marked(&state);
                let fault = (Box::new(Reason::Livelock { marked }), Some(trace));
                return Ok(Looked::Fault(fault));
            }
        }
        let mut counts = Counts::default();
        let (mut fired, mut steps) = (vec![false; closed.transitions()], 0_u128);
        let mut set = std::collections::BTreeSet::new();
        for rule in &space.rules.rules {
            let applies = space.applies(all, rule)?;
            steps = steps.saturating_add(applies.count(&mut counts));
            match rule.step {
                _ if applies.is_empty() => {}
                Move::Fire(transition) => fired[transition as usize] = true,
                Move::Set(protocol, flag) => drop(set.insert((protocol, flag))),
                _ => {}
            }
            space.breathe()?;
        }
        for (protocol, flag) in set
            .iter()
            .filter_map(|&(number, flag)| closed.unread(number, flag))
        {
            let (protocol, flag) = (protocol.to_owned(), flag.to_owned());
            warnings.push(Warning::Unread { protocol, flag });
        }
        if let Some(trace) = self.endless(all)? {
            if !closed.allows_endless() {
                return Ok(Looked::Fault((Box::new(Reason::Endless), Some(trace))));
            }
            warnings.push(Warning::NeverRests { trace });
        }
        let dead = self.dead(all, &fired)?;
        Ok(Looked::All(Box::new(All {
            kept: all.keep(),
            meanings: space.rules.meanings.clone(),
            states: all.count(&mut counts),
            steps,
            ends,
            warnings,
            fired,
            dead,
        })))
    }

    fn unfinished(&mut self, all: &Set) -> Grown<Option<Fault>> {
        let (space, closed) = (self.space, self.space.closed);
        for (number, used) in closed.protocols().iter().enumerate() {
            let Some(&start) = space.rules.numbers.positions[number].first() else {
                continue;
            };
            let can = space.can_reach(all, &all.with(start)?, |_| true)?;
            if let Some((state, trace)) = self.nearest(all.minus(&can)?)? {
                let reason = Reason::Unfinished {
                    protocol: used.name.clone(),
                    missed: closed.missing(&state, number),
                    marked: closed.marked(&state),
                };
                return Ok(Some((Box::new(reason), Some(trace))));
            }
        }
        Ok(None)
    }

    /// How it gets to where it can go on for ever by itself, if it can.
    fn endless(&mut self, all: &Set) -> Grown<Option<Trace>> {
        let space = self.space;
        let recurring = space.closed.recurring();
        let again = |rule: &&Rule| recurring.contains(&rule.step);
        let again: Vec<&Rule> = space.rules.rules.iter().filter(again).collect();
        if again.is_empty() {
            return Ok(None);
        }
        let mut circling = all.clone();
        loop {
            let rules = again.iter().copied();
            let before = Sweep::of_rules(space, Way::Backwards, rules).once(&circling)?;
            let can = before.and(&circling)?;
            if can == circling {
                break;
            }
            circling = can;
        }
        let leads = space.can_reach(all, &circling, Move::is_own)?;
        let nearest = self.nearest(leads)?;
        Ok(nearest.map(|(_, trace)| trace))
    }

    /// Why transitions did not fire: where they come nearest.
    fn dead(&mut self, all: &Set, fired: &[bool]) -> Grown<Vec<(usize, Dead)>> {
        let (space, closed) = (self.space, self.space.closed);
        let mut dead = Vec::new();
        for rule in &space.rules.rules {
            let Move::Fire(transition) = rule.step else {
                continue;
            };
            let transition = transition as usize;
            if fired[transition] || dead.len() == EXPLAINED {
                continue;
            }
            let asked = closed.asked(transition);
            let asked = |variable: &u32| match space.rules.meanings[*variable as usize] {
                Meaning::Marked(place) => asked.contains(&place),
                _ => false,
            };
            let tests: Vec<_> = { rule.guard.iter() }
                .filter(|test| asked(&test.variable))
                .copied()
                .collect();
            let near = space.nearest_to(all, &tests)?;
            if let Some((state, nearest)) = self.nearest(near)? {
                let lacks = closed.lacking(&state, transition).map(str::to_owned);
                dead.push((
                    transition,
                    Dead {
                        transition: closed.transition_name(transition).to_owned(),
                        lacks: lacks.collect(),
                        nearest,
                    },
                ));
            }
        }
        Ok(dead)
    }
}
