//! Searches in decision diagrams: their limits, and one after another.

use std::time::Duration;

use coordination::analysis::{Limits, Reason, check};

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
