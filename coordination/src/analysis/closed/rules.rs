//! A closed net as rules over variables.

use super::net::{Bound, Closed, Move};
use super::rule::{Literal, Meaning, Numbers, Rule, Rules, Trap, TrapKind};
use crate::protocol::Position;

impl Closed<'_> {
    /// The net's rules when at most `waiting` events may wait for a source; none if what its transitions must not find would take more
    /// than `most` literals.
    pub(in crate::analysis) fn rules(&self, waiting: u8, most: usize) -> Option<Rules> {
        let mut meanings: Vec<Meaning> = Vec::new();
        let mut positions: Vec<Vec<Meaning>> = Vec::new();
        for (bound, protocol) in self.bound.iter().zip(0..) {
            let all = 0..bound.positions.len() as u32;
            positions.push(
                all.map(|position| Meaning::At(protocol, position))
                    .collect(),
            );
        }
        // A protocol just before the first place that hangs on it.
        for (place, outside) in self.outside.iter().enumerate() {
            if let super::super::flags::Outside::Flag(protocol, _)
            | super::super::flags::Outside::Abort(protocol) = outside
            {
                meanings.append(&mut positions[usize::from(*protocol)]);
            }
            meanings.push(Meaning::Marked(place as u32));
            if let Some(counter) = self.counters[place] {
                meanings.extend((1..=waiting).map(|c| Meaning::Waiting(counter as u32, c)));
            }
        }
        meanings.extend(positions.into_iter().flatten());
        let mut rules = Rules {
            rules: Vec::new(),
            traps: Vec::new(),
            numbers: Numbers::of(&meanings, self),
            meanings,
            waiting,
        };
        let mut left = most;
        for transition in 0..self.transitions.len() as u32 {
            left = left.checked_sub(self.trap_literals(transition))?;
            self.firing(transition, &mut rules);
        }
        for protocol in 0..self.uses.len() {
            self.protocol_rules(protocol, &mut rules);
        }
        let simple = |(&place, before): (&u32, bool), step| Rule {
            step,
            guard: vec![Literal::turns(
                rules.numbers.places[place as usize],
                before,
                !before,
            )],
            stages: Vec::new(),
        };
        let fills = self
            .event_sources
            .iter()
            .map(|s| simple((s, false), Move::Fill(*s)));
        let empties = self
            .event_sinks
            .iter()
            .map(|s| simple((s, true), Move::Empty(*s)));
        let more: Vec<Rule> = fills.chain(empties).collect();
        rules.rules.extend(more);
        Some(rules)
    }

    /// The places that a transition fills, and of which no invariant says that they are empty then.
    fn unsure(&self, transition: u32) -> impl Iterator<Item = u32> {
        let internal = self.transitions[transition as usize].1.internal.iter();
        internal
            .copied()
            .filter(|&place| !self.safe[place as usize])
    }

    /// How many literals there are in the traps of a transition: each has the whole guard.
    fn trap_literals(&self, transition: u32) -> usize {
        let arcs = &self.transitions[transition as usize].1;
        self.unsure(transition).count() * (arcs.inputs.len() + arcs.sinks.len() + 1)
    }

    fn firing(&self, transition: u32, rules: &mut Rules) {
        let arcs = &self.transitions[transition as usize].1;
        let (mut guard, mut stages) = (Vec::new(), Vec::new());
        let variable = |place: u32| rules.numbers.places[place as usize];
        for &place in &arcs.inputs {
            let is_taken = arcs.taken.contains(&place);
            let counter = self.counters[place as usize].filter(|_| rules.waiting > 0 && is_taken);
            guard.push(match counter {
                None => Literal::turns(variable(place), true, !is_taken),
                Some(counter) => {
                    stages.push(refill(variable(place), &rules.numbers.waiting[counter]));
                    Literal::is(variable(place), true)
                }
            });
        }
        let new = |&place: &u32| Literal::turns(variable(place), false, true);
        guard.extend(arcs.sinks.iter().map(new));
        for place in self.unsure(transition) {
            let mut tests = guard.clone();
            tests.push(Literal::is(variable(place), true));
            let kind = TrapKind::Unsafe { transition, place };
            rules.traps.push(Trap { kind, tests });
        }
        guard.extend(arcs.internal.iter().map(new));
        let step = Move::Fire(transition);
        rules.rules.push(Rule {
            step,
            guard,
            stages,
        });
    }

    fn protocol_rules(&self, number: usize, rules: &mut Rules) {
        let (used, bound) = (&self.uses[number], &self.bound[number]);
        let numbers = rules.numbers.clone();
        let place = |place: u32| numbers.places[place as usize];
        let moves = |from: Position, to: Position| -> Vec<Literal> {
            let at = |position: Position| numbers.positions[number][position.index()];
            if from == to {
                return vec![Literal::is(at(from), true)];
            }
            vec![
                Literal::turns(at(from), true, false),
                Literal::turns(at(to), false, true),
            ]
        };
        let heard = || {
            bound
                .aborts
                .iter()
                .map(|&(source, _)| Literal::is(place(source), false))
        };
        let protocol = number as u16;
        for &from in bound
            .positions
            .iter()
            .filter(|&&p| p == Position::START || !used.protocol.is_end(p))
        {
            for (flag, to) in used.protocol.next(from) {
                let to = used.after(to);
                if used.protocol.owner(flag) == Some(used.net_party.other()) {
                    let mut guard = moves(from, to);
                    guard.extend(heard());
                    let step = Move::Set(protocol, flag);
                    offer(step, guard, Vec::new(), &bound.sources[flag.index()], rules);
                }
                for &(sink, _) in bound.sinks.iter().filter(|sink| sink.1 == flag) {
                    let mut guard = moves(from, to);
                    guard.push(Literal::turns(place(sink), true, false));
                    let (step, stages) = (Move::Empty(sink), Vec::new());
                    rules.rules.push(Rule {
                        step,
                        guard,
                        stages,
                    });
                }
            }
            if !bound.aborts.is_empty() && from != Position::START {
                let mut guard = moves(from, Position::START);
                guard.extend(heard());
                let stages = vec![vec![void(bound, rules)]];
                offer(Move::Abort(protocol), guard, stages, &bound.aborts, rules);
            }
        }
    }
}

/// What a run that is given up leaves: nothing.
fn void(bound: &Bound, rules: &Rules) -> Vec<Literal> {
    let numbers = &rules.numbers;
    let mut gone = Vec::new();
    for &(source, counter) in bound.sources.iter().flatten() {
        gone.push(numbers.places[source as usize]);
        gone.extend(numbers.waiting[counter].iter().copied());
    }
    gone.extend(
        bound
            .sinks
            .iter()
            .map(|&(sink, _)| numbers.places[sink as usize]),
    );
    gone.into_iter()
        .map(|variable| Literal::becomes(variable, false))
        .collect()
}

/// A rule that fills sources, or lets an event wait for them, and what happens where too many wait.
fn offer(
    step: Move,
    guard: Vec<Literal>,
    mut stages: Vec<Vec<Vec<Literal>>>,
    sources: &[(u32, usize)],
    rules: &mut Rules,
) {
    for &(source, counter) in sources {
        let variable = rules.numbers.places[source as usize];
        let waiting = &rules.numbers.waiting[counter];
        let mut tests: Vec<Literal> = guard.clone();
        // A source of aborts is tested for being empty, and so never overflows.
        if !guard.iter().any(|literal| literal.variable == variable) {
            tests.push(Literal::is(variable, true));
            tests.extend(waiting.last().map(|&full| Literal::is(full, true)));
            let kind = TrapKind::Overflow { source };
            rules.traps.push(Trap { kind, tests });
        }
        stages.push(arrive(variable, waiting));
    }
    rules.rules.push(Rule {
        step,
        guard,
        stages,
    });
}

/// An event fills an empty source, or waits for a full one.
fn arrive(source: u32, waiting: &[u32]) -> Vec<Vec<Literal>> {
    let mut ways = vec![vec![Literal::turns(source, false, true)]];
    for (count, &next) in waiting.iter().enumerate() {
        let mut way = vec![Literal::is(source, true), Literal::turns(next, false, true)];
        way.extend(
            count
                .checked_sub(1)
                .map(|last| Literal::is(waiting[last], true)),
        );
        ways.push(way);
    }
    ways
}

/// A source is emptied, or filled again by an event that waits.
fn refill(source: u32, waiting: &[u32]) -> Vec<Vec<Literal>> {
    let mut empty = vec![Literal::turns(source, true, false)];
    empty.extend(waiting.first().map(|&one| Literal::is(one, false)));
    let mut ways = vec![empty];
    for (count, &last) in waiting.iter().enumerate() {
        let mut way = vec![Literal::is(source, true), Literal::turns(last, true, false)];
        way.extend(waiting.get(count + 1).map(|&more| Literal::is(more, false)));
        ways.push(way);
    }
    ways
}
