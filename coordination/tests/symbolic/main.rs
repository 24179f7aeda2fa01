//! Nets looked at as sets of states: the same verdicts as by one state after another, and large nets.

#[path = "../nets/mod.rs"]
mod nets;

mod agreement;
mod closed;
mod drawn;
mod explorer;
mod families;
mod large;
mod published;

use coordination::analysis::{Limits, Proof, Refusal, Use, check};
use coordination::petri::NetModel;

/// Looks at sets of states from the beginning.
fn together(net: &NetModel, uses: &[Use]) -> Result<Proof, Refusal> {
    let limits = Limits {
        states: 0,
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
