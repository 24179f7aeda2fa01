//! What is said of a net as such: invariants, liveness, markings.

use crate::nets::gate;
use coordination::analysis::{
    Limits, Liveness, Marking, Reason, Trace, check, place_invariants, properties,
};
use coordination::petri::NetModel;

#[test]
fn invariants_come_first_and_are_known_of_large_nets() {
    let (mut net, uses) = gate(3);
    net.exclusion("one inside", &["r0 in", "r1 in", "r2 in"]);
    let proof = check(&net, &uses, &Limits::default()).unwrap();
    let by_invariants = &proof.report().by_invariants;
    assert!(by_invariants.is_safe);
    assert_eq!(by_invariants.exclusions, ["one inside"]);
    let few = Limits {
        states: 5,
        nodes: 0,
        ..Limits::default()
    };
    let refusal = check(&net, &uses, &few).unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "net `gate`: it is too large to analyse: more than 5 states; place invariants prove \
         that it is safe, and exclusion `one inside`, and nothing else is known about the rest"
    );
    // One of them need not give the road back, and then two can be on it: nothing is proved of that.
    net.place("spare").mark("spare");
    net.transition("slips in", &["spare"], &["r1 in"]);
    net.transition("is mended", &["r1 in"], &["spare"]);
    let invariants = place_invariants(&net);
    assert!(!invariants.excludes(&["r0 in", "r1 in"]) && !invariants.is_safe("r1 in"));
    let refusal = check(&net, &uses, &Limits::default()).unwrap_err();
    assert!(matches!(
        *refusal.reason,
        Reason::Unsafe { .. } | Reason::Exclusion { .. }
    ));
}

#[test]
fn questions_about_unknown_places_and_broken_nets_are_refused() {
    let (net, uses) = gate(1);
    let asked = [Marking::new(&["free"], &[]), Marking::new(&[], &["freeze"])];
    let refusal = properties(&net, &uses, &Limits::default(), &asked).unwrap_err();
    assert_eq!(refusal.to_string(), "net `gate`: it has no place `freeze`");
    let found = properties(&net, &uses, &Limits::default(), &asked[..1]).unwrap();
    assert_eq!(found.reached, [Some(Trace::default())]);
    assert!(found.is_live() && found.deadlock.is_none());
    let refusal = properties(&NetModel::new("none"), &[], &Limits::default(), &[]).unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "net `none`: net `none` has no transitions"
    );
}

#[test]
fn a_transition_may_fire_and_die_without_a_deadlock() {
    let mut net = NetModel::new("start-up");
    net.place("cold").mark("cold").place("warm").place("hot");
    net.place("never");
    net.transition("start", &["cold"], &["warm"]);
    net.transition("heat", &["warm"], &["hot"]);
    net.transition("cool", &["hot"], &["warm"]);
    net.transition("break", &["never", "hot"], &["cold", "never"]);
    let found = properties(&net, &[], &Limits::default(), &[]).unwrap();
    let liveness: Vec<String> = { found.transitions.iter().enumerate() }
        .map(
            |(number, (name, liveness))| match (liveness, found.dies_after(number)) {
                (Liveness::Dead, None) => format!("{name} is dead"),
                (Liveness::Dies, Some(trace)) => format!("{name} dies after {trace}"),
                (Liveness::Live, None) => format!("{name} lives"),
                other => panic!("{name}: {other:?}"),
            },
        )
        .collect();
    let expected = [
        "start dies after start",
        "heat lives",
        "cool lives",
        "break is dead",
    ];
    assert_eq!(liveness, expected);
    assert!(!found.is_live() && !found.is_quasi_live());
}

/// A way of so many places in a row, and at its end a circle, or nothing.
fn one_way(long: usize, goes_on: bool) -> NetModel {
    let mut net = NetModel::new("one way");
    let place = |number: usize| format!("p{number}");
    net.place(place(0)).mark(&place(0));
    for number in 1..=long {
        net.place(place(number));
        net.transition(
            format!("t{number}"),
            &[&place(number - 1)],
            &[&place(number)],
        );
    }
    if goes_on {
        net.place("off");
        net.transition("to off", &[&place(long)], &["off"]);
        net.transition("from off", &["off"], &[&place(long)]);
    }
    net
}

/// A copy for each would take gigabytes.
#[test]
fn thousands_of_transitions_that_die_in_one_deadlock_share_the_way_there() {
    let net = one_way(5_000, false);
    let found = properties(&net, &[], &Limits::default(), &[]).unwrap();
    let deadlock = found.deadlock.as_ref().unwrap();
    assert_eq!(deadlock.steps.len(), 5_000);
    for number in 0..5_000 {
        let way = found.dies_after(number).unwrap();
        assert!(std::ptr::eq(way, deadlock));
    }
    assert_eq!(found.dies_after(5_000), None);
}

#[test]
fn ways_to_where_transitions_die_are_named_within_the_limits() {
    let net = one_way(500, true);
    let found = properties(&net, &[], &Limits::default(), &[]).unwrap();
    for number in 0..500 {
        assert_eq!(found.transitions[number].1, Liveness::Dies);
        let way = found.dies_after(number).unwrap();
        assert_eq!(way.steps.len(), number + 1);
    }
    assert_eq!(found.transitions[500].1, Liveness::Live);
    let named = |limits: &Limits| {
        let less = properties(&net, &[], limits, &[]).unwrap();
        assert_eq!(less.transitions, found.transitions, "all are judged");
        let named = (0..500).filter(|&number| less.dies_after(number).is_some());
        named.count()
    };
    let few_steps = Limits {
        steps: 600,
        ..Limits::default()
    };
    // 1 + 2 + … + 34 = 595.
    assert_eq!(named(&few_steps), 34);
    // As much as 64 of them take together, and not as 128.
    let few_looks = Limits {
        looks: 502 * 67 + 502,
        ..Limits::default()
    };
    assert_eq!(named(&few_looks), 64);
}

/// Each way through the layers of this net is an invariant: too many to find them all.
#[test]
fn a_search_for_invariants_ends() {
    let mut net = NetModel::new("layers");
    let place = |layer: usize, number: usize| format!("p{layer}/{number}");
    let all = |layer| (0..60).map(move |number| place(layer, number));
    for layer in 0..40 {
        for place in all(layer) {
            net.place(place);
        }
    }
    net.place("alone").mark("alone");
    for layer in 0..40 {
        let (from, to): (Vec<_>, Vec<_>) = (all(layer).collect(), all((layer + 1) % 40).collect());
        for part in 0..30 {
            let [from, to] = [&from, &to].map(|of| [&*of[part], &*of[59 - part]]);
            net.transition(format!("t{layer}/{part}"), &from, &to);
        }
    }
    net.transition("stays", &["alone"], &["alone"]);
    let invariants = place_invariants(&net);
    assert!(!invariants.is_complete);
    assert!(invariants.is_safe("alone"));
}
