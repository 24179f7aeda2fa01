//! Protocols for the tests.

use std::sync::Arc;

use coordination::protocol::{FlagId, Protocol, ProtocolModel};
use proptest::prelude::*;

/// A robot asks; the mediator, the keeper, grants or refuses.
pub fn crossing_model() -> ProtocolModel {
    let mut model = ProtocolModel::new("crossing", "robot", "mediator");
    model.keeper("mediator");
    model.array("ask", &[("request", "robot")]);
    model.array(
        "yes",
        &[
            ("granted", "mediator"),
            ("entered", "robot"),
            ("released", "robot"),
        ],
    );
    model.array("no", &[("refused", "mediator")]);
    model.follow("ask", "yes").follow("ask", "no");
    model
}

pub fn crossing() -> Arc<Protocol> {
    Arc::new(crossing_model().compile().unwrap())
}

pub fn flag(protocol: &Protocol, name: &str) -> FlagId {
    protocol.flag(name).expect("the protocol has it")
}

/// An array of entries, each of the second party or not, and what can follow it.
#[derive(Clone, Debug)]
pub struct Shape {
    entries: Vec<bool>,
    next: Vec<Shape>,
}

fn shape() -> impl Strategy<Value = Shape> {
    let entries = || proptest::collection::vec(any::<bool>(), 1..5);
    let leaf = entries().prop_map(|entries| Shape {
        entries,
        next: Vec::new(),
    });
    leaf.prop_recursive(3, 20, 3, move |inner| {
        (entries(), proptest::collection::vec(inner, 1..4))
            .prop_map(|(entries, next)| Shape { entries, next })
    })
}

/// A random protocol with branches, whose keeper is the first party, the second or nobody.
pub fn any_protocol() -> impl Strategy<Value = Arc<Protocol>> {
    let starts = proptest::collection::vec(shape(), 1..3);
    (starts, 0..3_usize).prop_map(|(starts, keeper)| {
        let mut model = ProtocolModel::new("random", "a", "b");
        if let Some(keeper) = ["a", "b"].get(keeper) {
            model.keeper(*keeper);
        }
        let chooser = starts[0].entries[0];
        let mut arrays = 0;
        for start in &starts {
            let name = add(&mut model, start, chooser, &mut arrays);
            model.start(name);
        }
        Arc::new(model.compile().expect("shapes are right"))
    })
}

fn add(model: &mut ProtocolModel, shape: &Shape, chooser: bool, arrays: &mut usize) -> String {
    let name = format!("array{arrays}");
    *arrays += 1;
    let owners = std::iter::once(chooser).chain(shape.entries[1..].iter().copied());
    let flags: Vec<(String, &str)> = owners
        .enumerate()
        .map(|(index, second)| (format!("{name}_{index}"), if second { "b" } else { "a" }))
        .collect();
    let entries: Vec<_> = flags
        .iter()
        .map(|(flag, owner)| (&**flag, *owner))
        .collect();
    model.array(name.clone(), &entries);
    let chooser = shape.next.first().is_some_and(|next| next.entries[0]);
    for next in &shape.next {
        let follower = add(model, next, chooser, arrays);
        model.follow(name.clone(), follower);
    }
    name
}
