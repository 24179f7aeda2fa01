//! Nets looked at as sets of states: the same verdicts as by one state after another, and large nets.

#[path = "../it/nets/mod.rs"]
mod nets;

mod agreement;
mod closed;
mod drawn;
mod explorer;
mod families;
mod large;
mod published;

use std::collections::BTreeMap;

use coordination::analysis::{Limits, Proof, Reason, Refusal, Use, check};
use coordination::petri::NetModel;

/// More than the small nets here need, whose diagrams are made by the thousand: a cache grows with it, and is written whole at first.
const NODES: usize = 50_000;

/// Looks at sets of states from the beginning.
fn together(net: &NetModel, uses: &[Use]) -> Result<Proof, Refusal> {
    let limits = Limits {
        states: 0,
        nodes: NODES,
        ..Limits::default()
    };
    check(net, uses, &limits)
}

/// Looks at one state after another.
fn each(net: &NetModel, uses: &[Use]) -> Result<Proof, Refusal> {
    let limits = Limits {
        nodes: 0,
        ..Limits::default()
    };
    check(net, uses, &limits)
}

/// The name of a reason, without what it says.
fn name(reason: &Reason) -> String {
    let text = format!("{reason:?}");
    text.split([' ', '(']).next().unwrap_or_default().to_owned()
}

/// Random nets were met with each of these verdicts, at least so often.
#[track_caller]
fn each_is_met(met: &BTreeMap<String, usize>, expected: &[(&str, usize)]) {
    for &(verdict, least) in expected {
        let count = met.get(verdict).copied().unwrap_or(0);
        assert!(count >= least, "{verdict}: {count} times, of {met:?}");
    }
}
