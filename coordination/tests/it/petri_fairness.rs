//! What the order of choice promises to a transition that stays enabled.

use coordination::event::EventTable;
use coordination::petri::{Budget, Net, NetModel, TransitionId};
use proptest::prelude::*;

const PLACES: usize = 12;

/// Follows the marking of a net, firing by firing, and counts for each transition how often each
/// other one has fired since it was enabled without a break.
struct Watch {
    net: Net,
    marked: Vec<bool>,
    /// By transition: while it is enabled, by other transition.
    since: Vec<Option<Vec<u32>>>,
    /// The largest of these so far.
    most: u32,
}

impl Watch {
    fn new(net: &Net) -> Self {
        let structure = net.structure();
        let mut watch = Self {
            marked: net.places().map(|place| structure.marked(place)).collect(),
            since: vec![None; net.transitions().len()],
            most: 0,
            net: net.clone(),
        };
        watch.look();
        watch
    }

    fn look(&mut self) {
        let structure = self.net.structure();
        for transition in self.net.transitions() {
            let (inputs, outputs) = (structure.inputs(transition), structure.outputs(transition));
            let enabled =
                inputs.iter().all(|place| self.marked[place.index()]) && { outputs.iter() }
                    .all(|place| inputs.contains(place) || !self.marked[place.index()]);
            let since = &mut self.since[transition.index()];
            match enabled {
                false => *since = None,
                true if since.is_none() => *since = Some(vec![0; self.net.transitions().len()]),
                true => {}
            }
        }
    }

    fn fire(&mut self, fired: TransitionId) {
        assert!(self.since[fired.index()].is_some(), "it was enabled");
        self.since[fired.index()] = None;
        let structure = self.net.structure();
        for place in structure.inputs(fired) {
            self.marked[place.index()] = false;
        }
        for place in structure.outputs(fired) {
            self.marked[place.index()] = true;
        }
        for counts in self.since.iter_mut().flatten() {
            counts[fired.index()] += 1;
        }
        self.look();
        // Whoever is no longer enabled now is not in `since` any more.
        let counts = self.since.iter().flatten().flatten();
        self.most = self.most.max(counts.copied().max().unwrap_or(0));
    }
}

/// Runs a net with these budgets; the most that any other fired while one was enabled.
fn most(model: &NetModel, budgets: impl IntoIterator<Item = Budget>) -> u32 {
    let net = model.compile(&mut EventTable::new()).unwrap();
    let (mut watch, mut executor) = (Watch::new(&net), net.executor());
    let mut trace = [TransitionId::default(); 64];
    for budget in budgets {
        let fired = executor.evaluate_traced(budget, &mut trace).fired;
        for &transition in &trace[..fired as usize] {
            watch.fire(transition);
        }
    }
    watch.most
}

fn round_trips() -> impl Iterator<Item = Budget> {
    std::iter::repeat_n(Budget::ROUND, 8)
}

/// `t` has fired in the round in which it is enabled again, so that `u` fires in that round and in the
/// next before `t` does.
#[test]
fn another_can_fire_twice_meanwhile() {
    let mut net = NetModel::new("twice");
    for place in ["pu", "px", "pt", "pw"] {
        net.place(place);
    }
    net.place("src").mark("src");
    net.transition("u", &["pu"], &["px"]);
    net.transition("z", &["src"], &["pu", "pt"]);
    net.transition("t", &["pt"], &["pw"]);
    net.transition("w", &["pw"], &["pt"]);
    net.transition("x", &["px"], &["pu"]);
    assert_eq!(most(&net, round_trips()), 2);
    assert_eq!(most(&net, std::iter::repeat_n(Budget::ONE, 40)), 1);
}

/// Transitions over the places, with tokens somewhere; more than one block of 64 transitions if there
/// are `copies`.
fn build(transitions: &[(Vec<usize>, Vec<usize>)], marked: &[usize], copies: usize) -> NetModel {
    let mut net = NetModel::new("random");
    let name = |place: usize, copy: usize| match place {
        // Shared by all copies.
        0 | 1 => format!("p{place}"),
        _ => format!("p{place}.{copy}"),
    };
    let mut places = std::collections::BTreeSet::new();
    for copy in 0..copies {
        for (number, (inputs, outputs)) in transitions.iter().enumerate() {
            let [inputs, outputs] = [inputs, outputs]
                .map(|list| list.iter().map(|&p| name(p, copy)).collect::<Vec<_>>());
            places.extend(inputs.iter().chain(&outputs).cloned());
            let [inputs, outputs] =
                [&inputs, &outputs].map(|list| list.iter().map(String::as_str).collect::<Vec<_>>());
            net.transition(format!("t{number}.{copy}"), &inputs, &outputs);
        }
        for &place in marked {
            places.insert(name(place, copy));
        }
    }
    let marks: std::collections::BTreeSet<String> = { marked.iter() }
        .flat_map(|&place| (0..copies).map(move |copy| name(place, copy)))
        .collect();
    for place in &places {
        net.place(place);
        if marks.contains(place) {
            net.mark(place);
        }
    }
    // Every place is marked and emptied by something; this never fires.
    let all: Vec<&str> = places.iter().map(String::as_str).chain(["off"]).collect();
    net.place("off").transition("never", &all, &all);
    net
}

fn some(most: usize) -> impl Strategy<Value = Vec<usize>> {
    prop::collection::btree_set(0..PLACES, 1..=most).prop_map(|set| set.into_iter().collect())
}

fn transitions() -> impl Strategy<Value = Vec<(Vec<usize>, Vec<usize>)>> {
    prop::collection::vec((some(2), some(2)), 2..12)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the budgets: no other transition fires a third time before one that stays enabled.
    #[test]
    fn one_that_stays_enabled_fires_before_another_a_third_time(
        transitions in transitions(),
        marked in some(6),
        copies in prop_oneof![Just(1), Just(12)],
        budgets in prop::collection::vec((0..7_u32, 0..4_u32), 10..60),
    ) {
        let net = build(&transitions, &marked, copies);
        let budgets = budgets.into_iter().map(|(firings, rounds)| Budget { firings, rounds });
        prop_assert!(most(&net, budgets) <= 2);
    }

    /// With one firing at a time, no other fires a second time.
    #[test]
    fn one_at_a_time_no_other_fires_twice(
        transitions in transitions(),
        marked in some(6),
        copies in prop_oneof![Just(1), Just(12)],
    ) {
        let net = build(&transitions, &marked, copies);
        prop_assert!(most(&net, std::iter::repeat_n(Budget::ONE, 200)) <= 1);
    }
}
