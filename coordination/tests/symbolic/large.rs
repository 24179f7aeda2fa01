//! Searches in decision diagrams: their limits, and one after another.

use std::time::{Duration, Instant};

use coordination::analysis::{Limits, Reason, check, properties};
use coordination::petri::NetModel;

use super::families::referendum;
use super::{each, nets::gate};

/// As much as there is of everything.
#[test]
fn limits_may_be_as_large_as_they_can() {
    let (net, uses) = gate(8);
    let all = Limits {
        states: 0,
        steps: usize::MAX,
        looks: u64::MAX,
        nodes: usize::MAX,
        time: Duration::MAX,
        waiting: u8::MAX,
    };
    let proof = check(&net, &uses, &all).unwrap_or_else(|refusal| panic!("{refusal}"));
    assert_eq!(
        proof.report().states,
        each(&net, &uses).unwrap().report().states
    );
}

#[test]
fn two_hundred_searches_follow_each_other() {
    let limits = Limits {
        states: 0,
        nodes: 10_000,
        ..Limits::default()
    };
    let (net, uses) = gate(8);
    let states = each(&net, &uses).unwrap().report().states;
    for _ in 0..200 {
        let proof = check(&net, &uses, &limits).unwrap_or_else(|refusal| panic!("{refusal}"));
        assert_eq!(proof.report().states, states);
    }
}

#[test]
fn a_search_that_needs_more_than_it_may_says_so() {
    let (net, uses) = gate(30);
    let few = Limits {
        states: 0,
        nodes: 700,
        ..Limits::default()
    };
    let short = Limits {
        states: 0,
        time: Duration::ZERO,
        ..Limits::default()
    };
    for (limits, what) in [
        (few, "nodes of decision diagrams"),
        (short, "seconds of looking"),
    ] {
        let refusal = check(&net, &uses, &limits).unwrap_err();
        let Reason::TooLarge { what: found, .. } = *refusal.reason else {
            panic!("{refusal}");
        };
        assert_eq!(found, what);
        assert_eq!(refusal.trace, None);
    }
}

/// Each of its outputs might be marked already, which is asked of each with all that the transition needs.
#[test]
fn a_transition_with_very_many_places_on_both_sides_takes_no_more_than_it_may() {
    const WIDE: usize = 16_000;
    let mut net = NetModel::new("wide");
    let [inputs, outputs] = ["in", "out"].map(|side| {
        let name = |number| format!("{side} {number}");
        (0..WIDE).map(name).collect::<Vec<_>>()
    });
    for place in inputs.iter().chain(&outputs) {
        net.place(place);
    }
    inputs.iter().for_each(|place| {
        net.mark(place);
    });
    let [from, to] =
        [&inputs, &outputs].map(|all| all.iter().map(String::as_str).collect::<Vec<_>>());
    net.transition("goes", &from, &to);
    let limits = Limits {
        states: 0,
        ..Limits::default()
    };
    let refusal = properties(&net, &[], &limits, &[]).expect_err("it would take gigabytes");
    let Reason::TooLarge { what, .. } = *refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(what, "nodes of decision diagrams");
}

/// What comes before the search is no work for minutes.
#[test]
fn a_search_for_which_there_is_no_time_is_over_soon_in_a_large_net_too() {
    let limits = Limits {
        states: 0,
        time: Duration::from_secs(1),
        ..Limits::default()
    };
    let (net, begun) = (referendum(20_000).model(), Instant::now());
    let refusal = properties(&net, &[], &limits, &[]).expect_err("there is no time");
    let Reason::TooLarge { what, .. } = *refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(what, "seconds of looking");
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(60), "{took:?}");
}
