//! The executor against an independent, deliberately simple one: on random nets, with random
//! events, budgets, consumers and markings, both fire the same transitions in the same order.

mod nets;
mod reference;

use std::collections::BTreeSet;

use coordination::event::EventTable;
use coordination::petri::{
    Binding, Budget, Executor, NetModel, Obstacle, OfferError, PlaceId, TransitionId,
};
use nets::{EVENTS, Random, Recipe};
use proptest::prelude::*;
use reference::{Outcome, Reference};

/// Both executors of one net.
struct Pair {
    model: NetModel,
    events: EventTable,
    ours: Executor,
    simple: Reference,
}

impl Pair {
    fn new(model: NetModel) -> Self {
        let mut events = EventTable::new();
        for event in 0..EVENTS {
            events.intern(&format!("i{event}")).unwrap();
        }
        let net = match model.compile(&mut events) {
            Ok(net) => net,
            Err(errors) => panic!("{errors:?}"),
        };
        Self {
            ours: net.executor(),
            simple: Reference::new(&model),
            model,
            events,
        }
    }

    fn places(&self) -> usize {
        self.model.places().len()
    }

    fn offer(&mut self, event: usize) {
        let name = format!("i{event}");
        let id = self.events.id(&name).unwrap();
        let known = self.simple.offer(&name);
        let expected = known.then_some(()).ok_or(OfferError::UnknownEvent(id));
        assert_eq!(self.ours.offer(id), expected);
    }

    /// Returns how many fired.
    fn evaluate(&mut self, budget: Budget, trace: usize) -> usize {
        let firings = trace.min(budget.firings as usize);
        let expected = self.simple.evaluate(firings, budget.rounds);
        let mut fired = vec![TransitionId(0); trace];
        let evaluation = self.ours.evaluate_traced(budget, &mut fired);
        fired.truncate(evaluation.fired as usize);
        let found = Outcome {
            fired: fired.iter().map(|transition| transition.index()).collect(),
            remaining: evaluation.remaining,
        };
        assert_eq!(found, expected);
        found.fired.len()
    }

    /// Consumes the sinks that `mask` has a bit for, by their order of filling.
    fn drain(&mut self, mask: u64) {
        let mut expected = Vec::new();
        self.simple.drain(|_, event| {
            expected.push(event.to_owned());
            mask >> (expected.len() % 64) & 1 == 1
        });
        let mut found = Vec::new();
        let events = &self.events;
        self.ours.drain_sinks(|event| {
            found.push(events.name(event).unwrap().to_owned());
            mask >> (found.len() % 64) & 1 == 1
        });
        assert_eq!(found, expected);
    }

    /// Consumes the sink that filled as the `index`-th.
    fn take(&mut self, index: usize) {
        if self.simple.full.is_empty() {
            return;
        }
        let sink = self.simple.full[index % self.simple.full.len()];
        self.simple.drain(|place, _| place == sink);
        let sink = PlaceId(sink as u16);
        assert!(self.ours.take(sink));
        assert!(!self.ours.take(sink));
    }

    fn set_marking(&mut self, random: &mut Random, percent: usize) {
        let places = 0..self.places();
        let marking: BTreeSet<_> = places.filter(|_| random.chance(percent)).collect();
        let ids: Vec<_> = marking.iter().map(|&place| PlaceId(place as u16)).collect();
        self.simple.set_marking(marking);
        self.ours.set_marking(&ids).unwrap();
    }

    /// Fires the `index`-th of those that are enabled, and one that is not.
    fn fire(&mut self, index: usize) -> usize {
        let enabled = self.simple.enabled_next();
        let id = |transition: usize| TransitionId(transition as u16);
        let found: Vec<_> = self.ours.enabled().map(TransitionId::index).collect();
        assert_eq!(found, enabled);
        let all = self.model.transitions().len();
        let other = index % all;
        if !enabled.contains(&other) {
            let obstacle = self.ours.why_not(id(other)).next().unwrap();
            assert_eq!(self.ours.fire(id(other)), Err(obstacle));
            assert!(!self.simple.fire_by_hand(other));
        }
        assert_eq!(
            self.ours.fire(id(all)),
            Err(Obstacle::Unknown(id(all))),
            "there is no such transition"
        );
        if enabled.is_empty() {
            return 0;
        }
        let transition = enabled[index % enabled.len()];
        assert_eq!(self.ours.fire(id(transition)), Ok(()));
        assert!(self.simple.fire_by_hand(transition));
        1
    }

    fn compare(&self) {
        let marking: BTreeSet<_> = self.ours.marking().map(PlaceId::index).collect();
        assert_eq!(marking, self.simple.marking);
        for (&source, &waiting) in &self.simple.waiting {
            assert_eq!(self.ours.waiting(PlaceId(source as u16)), waiting);
        }
        let full: Vec<_> = self.ours.marked_sinks().map(|(p, _)| p.index()).collect();
        assert_eq!(full, self.simple.full);
    }
}

/// One thing that happens to a net.
#[derive(Clone, Debug)]
enum Happening {
    Offer(usize),
    Evaluate {
        firings: u32,
        rounds: u32,
        trace: usize,
    },
    Round,
    Ones(u32),
    Drain(u64),
    Take(usize),
    Fire(usize),
    Perturb {
        seed: u64,
        percent: usize,
    },
}

fn happening() -> impl Strategy<Value = Happening> {
    let bounded = (0..40_u32, 0..5_u32, 0..60_usize);
    prop_oneof![
        4 => (0..EVENTS).prop_map(Happening::Offer),
        6 => bounded.prop_map(|(firings, rounds, trace)| Happening::Evaluate {
            firings,
            rounds,
            trace,
        }),
        2 => Just(Happening::Round),
        2 => (1..100_u32).prop_map(Happening::Ones),
        3 => any::<u64>().prop_map(Happening::Drain),
        1 => any::<usize>().prop_map(Happening::Take),
        2 => any::<usize>().prop_map(Happening::Fire),
        1 => (1..u64::MAX, 0..100_usize)
            .prop_map(|(seed, percent)| Happening::Perturb { seed, percent }),
    ]
}

/// Returns how many fired.
fn play(recipe: &Recipe, happenings: &[Happening]) -> usize {
    let mut pair = Pair::new(nets::net(recipe));
    let mut fired = 0;
    pair.compare();
    for happening in happenings {
        match *happening {
            Happening::Offer(event) => pair.offer(event),
            Happening::Evaluate {
                firings,
                rounds,
                trace,
            } => fired += pair.evaluate(Budget { firings, rounds }, trace),
            Happening::Round => {
                let transitions = pair.model.transitions().len();
                fired += pair.evaluate(Budget::ROUND, transitions);
            }
            Happening::Ones(count) => {
                fired += (0..count)
                    .map(|_| pair.evaluate(Budget::ONE, 1))
                    .sum::<usize>();
            }
            Happening::Drain(mask) => pair.drain(mask),
            Happening::Take(index) => pair.take(index),
            Happening::Fire(index) => fired += pair.fire(index),
            Happening::Perturb { seed, percent } => {
                pair.set_marking(&mut Random(seed), percent);
            }
        }
        pair.compare();
    }
    assert_eq!(pair.ours.firings(), fired as u64);
    fired
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn small_nets_fire_alike(
        recipe in nets::recipe(8, 12),
        happenings in proptest::collection::vec(happening(), 1..40),
    ) {
        play(&recipe, &happenings);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn nets_of_several_words_fire_alike(
        recipe in nets::recipe(60, 100),
        happenings in proptest::collection::vec(happening(), 1..30),
    ) {
        play(&recipe, &happenings);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Processes one after another with a few places between them, as large nets of masks are.
    #[test]
    fn processes_in_order_fire_alike(
        recipe in nets::recipe(100, 3),
        happenings in proptest::collection::vec(happening(), 1..30),
    ) {
        let in_order = Recipe { wild: 0, shuffled: false, ..recipe };
        play(&in_order, &happenings);
    }
}

/// The random tests are worth nothing if the random nets are small or stand still.
#[test]
fn random_nets_are_large_and_alive() {
    let mut random = Random(7);
    let (mut most, mut alive) = (0, 0);
    for seed in 1..=20 {
        let recipe = Recipe {
            seed,
            processes: 60,
            resources: random.below(8),
            wild: random.below(60),
            sources: 10,
            sinks: 10,
            self_loops: 5,
            conflicts: 20,
            common: 2,
            shuffled: seed % 2 == 0,
        };
        let model = nets::net(&recipe);
        most = most
            .max(model.places().len())
            .max(model.transitions().len());
        let happenings: Vec<_> = (0..20)
            .flat_map(|step| {
                [
                    Happening::Offer(step % EVENTS),
                    Happening::Round,
                    Happening::Drain(!0),
                ]
            })
            .collect();
        alive += usize::from(play(&recipe, &happenings) > 500);
    }
    assert!(most > 256, "the largest net has only {most} places");
    assert!(alive > 10, "only {alive} of 20 nets are alive");
}

/// More blocks of 64 than one word has bits.
#[test]
fn a_very_large_net_fires_alike() {
    let recipe = Recipe {
        seed: 11,
        processes: 1_600,
        resources: 3,
        wild: 0,
        sources: 2,
        sinks: 2,
        self_loops: 1,
        conflicts: 10,
        common: 1,
        shuffled: true,
    };
    let mut pair = Pair::new(nets::net(&recipe));
    assert!(pair.model.transitions().len() > 64 * 64);
    let mut fired = 0;
    for step in 0..60 {
        pair.offer(step % EVENTS);
        let rounds = 1 + step as u32 % 3;
        fired += pair.evaluate(Budget { firings: 9, rounds }, 9);
        fired += pair.fire(step * 37);
        if step % 10 == 9 {
            pair.drain(!0);
            pair.set_marking(&mut Random(step as u64), 40);
        }
        pair.compare();
    }
    assert!(fired > 300, "only {fired} fired");
}

/// One resource for thousands of processes: who gives it back wakes those who wait, however far
/// away they are.
#[test]
fn a_shared_place_wakes_the_most_distant_transition() {
    const PROCESSES: usize = 3_000;
    let mut model = NetModel::new("distant");
    model.place("resource").mark("resource");
    for i in 0..PROCESSES {
        let [idle, using, done] = ["idle", "using", "done"].map(|name| format!("{name}{i}"));
        model.place(&idle).place(&using);
        model.source(&done, Binding::event(format!("i{}", i % EVENTS)));
        model.transition(format!("take{i}"), &[&idle, "resource"], &[&using]);
        model.transition(format!("give{i}"), &[&using, &done], &[&idle, "resource"]);
    }
    for i in [0, 1, 1_500, PROCESSES - 1] {
        model.mark(&format!("idle{i}"));
    }
    let mut pair = Pair::new(model);
    let mut fired = 0;
    for step in 0..40 {
        fired += pair.evaluate(Budget::ROUND, 10);
        pair.compare();
        pair.offer(step % EVENTS);
    }
    assert!(fired > 20, "only {fired} fired");
}

/// One source for many processes: an event wakes those who wait for it, however far away they are.
#[test]
fn a_shared_source_wakes_the_only_transition_that_can_use_it() {
    let mut model = NetModel::new("call");
    model.source("call", Binding::event("i0"));
    for i in 0..300 {
        let [idle, busy] = ["idle", "busy"].map(|name| format!("{name}{i}"));
        model.place(&idle).place(&busy);
        model.transition(format!("start{i}"), &[&idle, "call"], &[&busy]);
        model.transition(format!("end{i}"), &[&busy], &[&idle]);
    }
    model.mark("idle20").mark("idle150").mark("idle280");
    for budget in [Budget::ONE, Budget::ROUND] {
        let mut pair = Pair::new(model.clone());
        let mut fired = 0;
        for step in 0..30 {
            if step % 4 == 0 {
                pair.offer(0);
            }
            fired += pair.evaluate(budget, 10);
            pair.compare();
        }
        assert!(fired > 10, "only {fired} fired");
    }
}

/// A search that is cut short goes on in the next evaluation, fires the same in the same order, and
/// nothing that wakes blocks in between keeps it from what is far away.
#[test]
fn a_search_in_parts_finds_what_a_search_at_once_does() {
    const PROCESSES: usize = 9_000;
    let mut model = NetModel::new("apart");
    model.place("resource").mark("resource");
    model.source("tick", Binding::event("i0"));
    model.place("never").mark("never");
    for i in 0..PROCESSES {
        let [idle, using] = ["idle", "using"].map(|name| format!("{name}{i}"));
        model.place(&idle).mark(&idle).place(&using);
        model.transition(format!("take{i}"), &[&idle, "resource"], &[&using]);
        if i % 50 == 0 {
            // Woken by each tick, and never enabled.
            model.transition(format!("wake{i}"), &[&using, "tick"], &["never"]);
        }
    }
    for i in 0..PROCESSES {
        let [idle, using] = ["idle", "using"].map(|name| format!("{name}{i}"));
        model.transition(format!("give{i}"), &[&using], &[&idle, "resource"]);
    }
    model.transition("clear", &["never", "tick"], &["resource"]);
    for ticks in [false, true] {
        let mut pair = Pair::new(model.clone());
        pair.ours.limit_search(0);
        let tick = pair.events.id("i0").unwrap();
        let source = PlaceId(1);
        let (mut fired, mut in_vain, mut longest) = (0, 0, 0);
        while fired < 12 {
            if ticks {
                pair.ours.void_source(source);
                pair.ours.offer(tick).unwrap();
                pair.simple.marking.insert(source.index());
            }
            let mut trace = [TransitionId(0)];
            let evaluation = pair.ours.evaluate_traced(Budget::ONE, &mut trace);
            assert!(evaluation.remaining);
            if evaluation.fired == 0 {
                in_vain += 1;
                longest += 1;
                assert!(longest < 10, "the search does not get on");
                continue;
            }
            longest = 0;
            fired += 1;
            let expected = pair.simple.evaluate(1, 1);
            assert_eq!(expected.fired, [trace[0].index()]);
        }
        assert!(in_vain > 5, "only {in_vain} searches were cut short");
    }
}

/// The first cut has too little room for it, the second too much, and less of that is the first again.
#[test]
fn a_net_that_fits_no_cut_is_compiled_all_the_same() {
    let recipe = Recipe {
        seed: 3456,
        processes: 47,
        resources: 40,
        wild: 1,
        sources: 11,
        sinks: 14,
        self_loops: 3,
        conflicts: 13,
        common: 7,
        shuffled: false,
    };
    let happenings = [Happening::Ones(20), Happening::Round];
    assert!(play(&recipe, &happenings) > 0);
}
