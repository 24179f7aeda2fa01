//! The same verdicts on random nets, however they are looked at.

use std::collections::BTreeMap;

use coordination::analysis::{Reason, Refusal, Report, Warning};

use super::drawn::{Random, draw};
use super::{each, together};

/// The kind of a reason, and what of it does not hang on which of several states is named.
fn kind(refusal: &Refusal) -> String {
    match &*refusal.reason {
        Reason::DeadTransitions { transitions, sinks } => {
            let lacks = transitions.iter().map(|dead| {
                let (name, steps) = (&dead.transition, dead.nearest.steps.len());
                format!("{name}: {} after {steps}", dead.lacks.len())
            });
            format!("DeadTransitions {:?} {sinks:?}", lacks.collect::<Vec<_>>())
        }
        Reason::EndUnreached { end } => format!("EndUnreached {end}"),
        Reason::Unfinished { protocol, .. } => format!("Unfinished {protocol}"),
        reason => {
            let text = format!("{reason:?}");
            text.split([' ', '(']).next().unwrap_or_default().to_owned()
        }
    }
}

fn length(refusal: &Refusal) -> Option<usize> {
    refusal.trace.as_ref().map(|trace| trace.steps.len())
}

/// Warnings, with traces of equal length for equal ones.
fn warnings(report: &Report) -> Vec<String> {
    let text = |warning: &Warning| match warning {
        Warning::NeverRests { trace } => format!("never rests after {}", trace.steps.len()),
        warning => warning.to_string(),
    };
    report.warnings.iter().map(text).collect()
}

#[test]
fn verdicts_and_lengths_of_traces_are_the_same_on_random_nets() {
    let mut random = Random(0x9876_5432_1abc_def1);
    let mut met: BTreeMap<String, usize> = BTreeMap::new();
    for number in 0..4000 {
        let (net, uses) = draw(&mut random);
        let verdict = match (each(&net, &uses), together(&net, &uses)) {
            (Ok(one), Ok(all)) => {
                let (one, all) = (one.report(), all.report());
                assert_eq!(
                    (all.states, all.steps),
                    (one.states, one.steps),
                    "net {number}"
                );
                assert_eq!(all.ends, one.ends, "net {number}");
                assert_eq!(warnings(all), warnings(one), "net {number}");
                "passes".to_owned()
            }
            (Err(one), Err(all)) => {
                assert_eq!(
                    kind(&all),
                    kind(&one),
                    "net {number}: {all}\n{one}\n{net:?}"
                );
                assert_eq!(length(&all), length(&one), "net {number}: {all}\n{one}");
                kind(&one).split(' ').next().unwrap_or_default().to_owned()
            }
            (one, all) => panic!("net {number}: {one:?} {all:?}"),
        };
        *met.entry(verdict).or_default() += 1;
    }
    println!("{met:?}");
    for (verdict, least) in [
        ("passes", 400),
        ("Deadlock", 100),
        ("Unsafe", 100),
        ("OutOfOrder", 20),
        ("Overflow", 5),
        ("Exclusion", 20),
        ("Livelock", 20),
        ("Unfinished", 5),
        ("Endless", 20),
        ("DeadTransitions", 20),
    ] {
        let count = met.get(verdict).copied().unwrap_or(0);
        assert!(count >= least, "{verdict}: {count} times, of {met:?}");
    }
}
