//! Many rules applied in one sweep through a diagram: each only to the parts that begin with the first
//! variable that it touches, so that what is above need not be gone through for each rule.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use oxidd::util::FxHasher;

use super::super::closed::Move;
use super::super::closed::rule::{Literal, Rule};
use super::diagram::{Grown, Set};
use super::space::Space;

/// Where rules are followed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// To the states after them.
    Forwards,
    /// To the states before them.
    Backwards,
    /// Nowhere: to the states in which they apply.
    Stays,
}

/// A rule, or tests alone.
#[derive(Clone, Copy)]
enum Part<'r> {
    Rule(&'r Rule),
    Tests(&'r [Literal]),
}

/// What was found already.
type Known<K> = HashMap<K, Set, BuildHasherDefault<FxHasher>>;

/// How many parts of a diagram are gone through before the clock is looked at.
const BREATH: u32 = 64;

/// Rules by the first variable that they touch.
pub(super) struct Sweep<'s> {
    space: &'s Space<'s>,
    way: Way,
    parts: Vec<Vec<Part<'s>>>,
    /// By variable, the first from there on that rules touch although it is false.
    open: Vec<u32>,
    once: Known<Set>,
    closed: Known<(Set, Option<Set>, u32)>,
    /// How many parts were gone through.
    visited: u32,
}

impl<'s> Sweep<'s> {
    pub(super) fn of_rules(
        space: &'s Space<'s>,
        way: Way,
        rules: impl Iterator<Item = &'s Rule>,
    ) -> Self {
        let variables = space.rules.meanings.len();
        let mut parts = vec![Vec::new(); variables];
        let mut may_be_false = vec![false; variables];
        for rule in rules {
            let touched = rule.literals().map(|literal| literal.variable);
            let Some(first) = touched.min() else { continue };
            let asks = |literal: &&Literal| literal.variable == first;
            let guard = rule.guard.iter().find(asks).map(|literal| match way {
                Way::Backwards => Some(literal.after),
                _ => literal.before,
            });
            // A later stage may change what the guard has left.
            let mut later = rule.stages.iter().flatten().flatten();
            let is_staged = way == Way::Backwards && later.any(|l| l.variable == first);
            may_be_false[first as usize] |= is_staged || guard != Some(Some(true));
            parts[first as usize].push(Part::Rule(rule));
        }
        Self::new(space, way, parts, &may_be_false)
    }

    pub(super) fn of_tests(
        space: &'s Space<'s>,
        tests: impl Iterator<Item = &'s [Literal]>,
    ) -> Self {
        let variables = space.rules.meanings.len();
        let mut parts = vec![Vec::new(); variables];
        let mut may_be_false = vec![false; variables];
        for tests in tests {
            let Some(first) = tests.iter().min_by_key(|test| test.variable) else {
                continue;
            };
            may_be_false[first.variable as usize] |= first.before != Some(true);
            parts[first.variable as usize].push(Part::Tests(tests));
        }
        Self::new(space, Way::Stays, parts, &may_be_false)
    }

    fn new(
        space: &'s Space<'s>,
        way: Way,
        parts: Vec<Vec<Part<'s>>>,
        may_be_false: &[bool],
    ) -> Self {
        let mut open = vec![u32::MAX; parts.len() + 1];
        for variable in (0..parts.len()).rev() {
            open[variable] = match may_be_false[variable] {
                true => variable as u32,
                false => open[variable + 1],
            };
        }
        Self {
            space,
            way,
            parts,
            open,
            once: Known::default(),
            closed: Known::default(),
            visited: 0,
        }
    }

    fn breathe(&mut self) -> Grown<()> {
        self.visited = self.visited.wrapping_add(1);
        if self.visited.is_multiple_of(BREATH) {
            return self.space.breathe();
        }
        Ok(())
    }

    fn led(&self, part: Part<'_>, set: &Set) -> Grown<Set> {
        match (part, self.way) {
            (Part::Tests(tests), _) => self.space.that(set, tests),
            (Part::Rule(rule), Way::Forwards) => self.space.after(set, rule),
            (Part::Rule(rule), Way::Backwards) => self.space.before(set, rule),
            (Part::Rule(rule), Way::Stays) => self.space.applies(set, rule),
        }
    }

    /// The states that one rule leads to.
    pub(super) fn once(&mut self, set: &Set) -> Grown<Set> {
        self.once.clear();
        let found = self.once_from(set, 0);
        self.once.clear();
        found
    }

    fn once_from(&mut self, set: &Set, from: u32) -> Grown<Set> {
        let top = set.top();
        if top.is_none() && set.is_empty() {
            return Ok(set.clone());
        }
        let below = top.unwrap_or(self.parts.len() as u32);
        let mut found = self.space.empty();
        let mut open = self.open[from as usize];
        while open < below {
            for &part in &self.parts[open as usize] {
                found = found.union(&self.led(part, set)?)?;
            }
            open = self.open[open as usize + 1];
        }
        let Some(top) = top else {
            return Ok(found);
        };
        let led = self.once_at(set, top)?;
        if found.is_empty() {
            return Ok(led);
        }
        found.union(&led)
    }

    fn once_at(&mut self, set: &Set, top: u32) -> Grown<Set> {
        if let Some(known) = self.once.get(set) {
            return Ok(known.clone());
        }
        self.breathe()?;
        let (with, without) = set.split();
        let with = self.once_from(&with, top + 1)?;
        let without = self.once_from(&without, top + 1)?;
        let mut found = with.on_top(top, &without)?;
        for &part in &self.parts[top as usize] {
            found = found.union(&self.led(part, set)?)?;
        }
        self.once.insert(set.clone(), found.clone());
        Ok(found)
    }

    /// The states that rules lead to, one after another, without leaving those `within`.
    pub(super) fn all(&mut self, set: &Set, within: Option<&Set>) -> Grown<Set> {
        self.closed.clear();
        let found = self.all_from(set, within.cloned(), 0);
        self.closed.clear();
        found
    }

    /// By rules that touch no variable before `from`.
    fn all_from(&mut self, set: &Set, within: Option<Set>, from: u32) -> Grown<Set> {
        let last = self.parts.len() as u32;
        if set.is_empty() || within.as_ref().is_some_and(|within| within == set) {
            return Ok(set.clone());
        }
        let at = self.open[from as usize].min(set.top().unwrap_or(last));
        if at >= last {
            return Ok(set.clone());
        }
        // Whatever else is within has these variables false, too.
        let mut within = within;
        if let Some(limit) = &mut within {
            while let Some(top) = limit.top().filter(|&top| top < at) {
                debug_assert!(top < at);
                *limit = limit.split().1;
            }
        }
        let key = (set.clone(), within.clone(), at);
        if let Some(known) = self.closed.get(&key) {
            return Ok(known.clone());
        }
        self.breathe()?;
        let limits = within.as_ref().map(|limit| limit.split_at(at, self.space));
        let (limit_with, limit_without) = limits.clone().unzip();
        let mut found = set.clone();
        loop {
            let (with, without) = found.split_at(at, self.space);
            let with = self.all_from(&with, limit_with.clone(), at + 1)?;
            let without = self.all_from(&without, limit_without.clone(), at + 1)?;
            found = with.on_top(at, &without)?;
            if within.as_ref() == Some(&found) {
                break;
            }
            let mut more = found.clone();
            for &part in &self.parts[at as usize] {
                let led = self.led(part, &more)?;
                let led = match &within {
                    Some(limit) => led.and(limit)?,
                    None => led,
                };
                more = more.union(&led)?;
            }
            if more == found {
                break;
            }
            found = more;
        }
        self.closed.insert(key, found.clone());
        Ok(found)
    }
}

impl Space<'_> {
    /// All states that rules lead to from `from`.
    pub(super) fn reach(&self, from: &Set) -> Grown<Set> {
        Sweep::of_rules(self, Way::Forwards, self.rules.rules.iter()).all(from, None)
    }

    /// Those of the states `within` from which steps `along` which one may go lead to `targets` without
    /// leaving them.
    pub(super) fn can_reach(
        &self,
        within: &Set,
        targets: &Set,
        along: impl Fn(Move) -> bool,
    ) -> Grown<Set> {
        let rules = self.rules.rules.iter().filter(|rule| along(rule.step));
        Sweep::of_rules(self, Way::Backwards, rules).all(targets, Some(within))
    }
}
