//! Random nets: whatever the analysis refuses goes wrong in just the way that it says, when its
//! steps are repeated by a second, deliberately simple reading of the rules.

use std::collections::{BTreeMap, BTreeSet};

use crate::nets::protocol;
use coordination::analysis::{Limits, Reason, Step, Use, check};
use coordination::petri::{Binding, NetModel, PlaceKind};
use proptest::prelude::*;

const PLACES: &[&str] = &["a", "b", "c", "d", "e"];
const FLAGS: &[(&str, &str)] = &[
    ("ask", "robot"),
    ("go", "mediator"),
    ("done", "robot"),
    ("bye", "mediator"),
];

/// A net with one robot: its protocol takes the first `flags` of [`FLAGS`].
#[derive(Clone, Debug)]
struct Drawn {
    flags: usize,
    marked: Vec<usize>,
    transitions: Vec<(Vec<usize>, Vec<usize>)>,
    end: Option<Vec<usize>>,
    exclusion: Option<Vec<usize>>,
}

fn some(least: usize, most: usize) -> impl Strategy<Value = Vec<usize>> {
    prop::collection::btree_set(0..PLACES.len() + 4, least..=most)
        .prop_map(|set| set.into_iter().collect())
}

fn drawn() -> impl Strategy<Value = Drawn> {
    (
        1..=4_usize,
        some(0, 3),
        prop::collection::vec((some(1, 3), some(0, 3)), 1..6),
        prop::option::of(some(0, 2)),
        prop::option::of(some(2, 3)),
    )
        .prop_map(|(flags, marked, transitions, end, exclusion)| Drawn {
            flags,
            marked,
            transitions,
            end,
            exclusion,
        })
}

/// Numbers above the internal places stand for the sources, or for the sinks.
fn build(drawn: &Drawn) -> (NetModel, Vec<Use>) {
    let mut net = NetModel::new("drawn");
    let flags = &FLAGS[..drawn.flags];
    let of = |owner| -> Vec<&str> {
        let own = flags.iter().filter(move |(_, by)| *by == owner);
        own.map(|(flag, _)| *flag).collect()
    };
    let name = |number: usize, flags: &[&'static str], event: &'static str| match number {
        ..5 => PLACES[number],
        number => flags.get(number - 5).copied().unwrap_or(event),
    };
    let unique = |list: &[usize], flags: &[&'static str], event| -> Vec<&'static str> {
        let names: BTreeSet<_> = list.iter().map(|&n| name(n, flags, event)).collect();
        names.into_iter().collect()
    };
    let (sources, sinks) = (of("robot"), of("mediator"));
    for place in PLACES {
        net.place(place);
    }
    for flag in &sources {
        net.source(flag, Binding::flag("robot", *flag));
    }
    for flag in &sinks {
        net.sink(flag, Binding::flag("robot", *flag));
    }
    net.source("tick", Binding::event("tick"))
        .sink("bell", Binding::event("bell"));
    for (number, (from, to)) in drawn.transitions.iter().enumerate() {
        let (from, to) = (unique(from, &sources, "tick"), unique(to, &sinks, "bell"));
        net.transition(format!("t{number}"), &from, &to);
    }
    // So that no place is left without arcs, and the net compiles.
    let used: Vec<&str> = PLACES
        .iter()
        .chain(&sources)
        .copied()
        .chain(["tick"])
        .collect();
    let mut all = PLACES.to_vec();
    all.extend(&sinks);
    all.push("bell");
    net.place("off").transition(
        "never",
        &[&used[..], &["off"]].concat(),
        &[&all[..], &["off"]].concat(),
    );
    let internal = |list: &[usize]| -> Vec<&str> {
        let names: BTreeSet<_> = list
            .iter()
            .filter(|&&n| n < 5)
            .map(|&n| PLACES[n])
            .collect();
        names.into_iter().collect()
    };
    for place in internal(&drawn.marked) {
        net.mark(place);
    }
    if let Some(end) = &drawn.end {
        net.end("end", &internal(end));
    }
    if let Some(exclusion) = drawn
        .exclusion
        .as_deref()
        .map(internal)
        .filter(|x| x.len() > 1)
    {
        net.exclusion("exclusion", &exclusion);
    }
    (net, vec![protocol("robot", flags)])
}

/// A closed net, read word for word.
struct Replay<'a> {
    net: &'a NetModel,
    flags: usize,
    marked: BTreeSet<String>,
    waiting: BTreeMap<String, usize>,
    /// How many flags of the present run are set.
    progress: usize,
}

impl Replay<'_> {
    fn fill(&mut self) {
        for (flag, count) in &mut self.waiting {
            if *count > 0 && self.marked.insert(flag.clone()) {
                *count -= 1;
            }
        }
    }

    fn set(&mut self, flag: &str) {
        assert_eq!(FLAGS[self.progress].0, flag, "the protocol's order");
        self.progress = (self.progress + 1) % self.flags;
    }

    /// Inputs marked, outputs that are no inputs empty.
    fn blocked(&self, transition: &str) -> (bool, Vec<String>) {
        let found = self
            .net
            .transitions()
            .find(|t| t.name == transition)
            .unwrap();
        let marked = |place: &&str| self.marked.contains(*place);
        let full = found
            .outputs
            .iter()
            .filter(|p| marked(p) && !found.inputs.contains(p));
        (
            found.inputs.iter().all(marked),
            full.map(|&p| p.to_owned()).collect(),
        )
    }

    fn step(&mut self, step: &Step) {
        match step {
            Step::Fires { transition } => {
                assert_eq!(
                    self.blocked(transition),
                    (true, vec![]),
                    "`{transition}` is enabled"
                );
                let found = self
                    .net
                    .transitions()
                    .find(|t| t.name == transition)
                    .unwrap();
                for place in &found.inputs {
                    self.marked.remove(*place);
                }
                self.marked
                    .extend(found.outputs.iter().map(|&place| place.to_owned()));
            }
            Step::Sets { flag, .. } => {
                self.set(flag);
                *self.waiting.entry(flag.clone()).or_default() += 1;
            }
            Step::Raises { flag, .. } => {
                self.set(flag);
                assert!(self.marked.remove(flag));
            }
            Step::Arrives { event } => assert!(self.marked.insert(event.clone())),
            Step::Sends { event } => assert!(self.marked.remove(event)),
            other => panic!("nobody gives up: {other}"),
        }
        self.fill();
    }

    /// Whether anything at all can happen.
    fn is_stuck(&self) -> bool {
        let fires = self
            .net
            .transitions()
            .any(|t| self.blocked(t.name) == (true, vec![]));
        let (next, owner) = FLAGS[self.progress];
        let flag = owner == "robot" || self.marked.contains(next);
        let event = !self.marked.contains("tick") || self.marked.contains("bell");
        !fires && !flag && !event
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_refused_goes_wrong_as_said(drawn in drawn()) {
        let (net, uses) = build(&drawn);
        let limits = Limits { states: 5000, ..Limits::default() };
        // The transition that keeps the net together is never enabled, so nothing passes.
        let refusal = check(&net, &uses, &limits).expect_err("one transition is dead");
        let mut replay = Replay {
            net: &net,
            flags: drawn.flags,
            marked: net.places().filter(|p| p.marked).map(|p| p.name.to_owned()).collect(),
            waiting: BTreeMap::new(),
            progress: 0,
        };
        for step in refusal.trace.iter().flat_map(|trace| &trace.steps) {
            replay.step(step);
        }
        match &*refusal.reason {
            Reason::Unsafe { transition, place } => {
                let (inputs, full) = replay.blocked(transition);
                prop_assert!(inputs && full.contains(place));
                let kinds: Vec<_> = net.places().filter(|p| full.iter().any(|f| f == p.name)).map(|p| p.kind).collect();
                prop_assert!(!kinds.contains(&PlaceKind::Sink), "{}", refusal);
            }
            Reason::Exclusion { places, .. } => {
                prop_assert!(places.len() > 1 && places.iter().all(|p| replay.marked.contains(p)));
            }
            Reason::OutOfOrder { sink, flag, .. } => {
                prop_assert!(replay.marked.contains(sink));
                // Between where the run is and the flag comes one whose sink is empty.
                let mut at = replay.progress;
                let mut left: BTreeSet<_> = replay.marked.clone();
                while FLAGS[at].0 != flag && left.remove(FLAGS[at].0) && FLAGS[at].1 == "mediator" {
                    at = (at + 1) % drawn.flags;
                }
                prop_assert_ne!(FLAGS[at].0, flag, "{}", refusal);
            }
            Reason::Overflow { event, waiting, .. } => {
                let flag = event.strip_prefix("robot.").unwrap();
                prop_assert_eq!(replay.waiting[flag], usize::from(*waiting));
                prop_assert_eq!(FLAGS[replay.progress], (flag, "robot"));
            }
            Reason::Deadlock { marked, .. } => {
                prop_assert!(replay.is_stuck(), "{}", refusal);
                prop_assert_eq!(&replay.marked.iter().cloned().collect::<BTreeSet<_>>(), &marked.iter().cloned().collect());
            }
            Reason::Livelock { marked } => {
                prop_assert!(marked.iter().all(|place| replay.marked.contains(place)));
            }
            Reason::Endless => prop_assert!(refusal.trace.is_some()),
            Reason::Unfinished { .. } => prop_assert_ne!(replay.progress, 0),
            // Each dead transition is short of what the message says, where it says so.
            Reason::DeadTransitions { transitions, .. } => {
                for dead in transitions {
                    let mut replay = Replay {
                        net: &net,
                        flags: drawn.flags,
                        marked: net.places().filter(|p| p.marked).map(|p| p.name.to_owned()).collect(),
                        waiting: BTreeMap::new(),
                        progress: 0,
                    };
                    for step in &dead.nearest.steps {
                        replay.step(step);
                    }
                    let found = net.transitions().find(|t| t.name == dead.transition).unwrap();
                    for place in &dead.lacks {
                        let is_input = found.inputs.contains(&place.as_str());
                        prop_assert_eq!(replay.marked.contains(place), !is_input, "{}", place);
                    }
                    prop_assert!(!dead.lacks.is_empty());
                }
            }
            Reason::Model(_) | Reason::EndUnreached { .. } => {}
            Reason::TooLarge { .. } => prop_assert!(refusal.trace.is_none()),
            other => prop_assert!(false, "not expected here: {other}"),
        }
    }
}
