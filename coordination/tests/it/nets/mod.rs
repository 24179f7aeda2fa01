//! Small protocols and nets that several tests use.

#![allow(dead_code, reason = "each test file uses its own part")]

use coordination::analysis::Use;
use coordination::petri::{Binding, NetModel};
use coordination::protocol::{Party, ProtocolModel};

/// A protocol between `robot` and `mediator`, or between a robot of the protocol's own name and it.
pub fn protocol(name: &str, entries: &[(&str, &str)]) -> Use {
    let mut model = ProtocolModel::new(name, name, "mediator");
    let owner = |owner| if owner == "robot" { name } else { owner };
    let entries: Vec<_> = entries
        .iter()
        .map(|&(flag, by)| (flag, owner(by)))
        .collect();
    model.array("all", &entries);
    let protocol = model.compile().unwrap_or_else(|error| panic!("{error}"));
    Use::new(name, protocol.into(), Party::Second)
}

/// request, granted, released.
pub fn robot(name: &str) -> Use {
    let entries = [
        ("request", "robot"),
        ("granted", "mediator"),
        ("released", "robot"),
    ];
    protocol(name, &entries)
}

/// A road that one of `robots` robots, r0, r1 and so on, may be on.
pub fn gate(robots: usize) -> (NetModel, Vec<Use>) {
    let mut net = NetModel::new("gate");
    net.place("free").mark("free").end("idle", &["free"]);
    let names: Vec<String> = (0..robots).map(|number| format!("r{number}")).collect();
    for own in &names {
        let place = |what: &str| format!("{own} {what}");
        net.source(place("asks"), Binding::flag(own, "request"));
        net.sink(place("may"), Binding::flag(own, "granted"));
        net.source(place("gone"), Binding::flag(own, "released"));
        net.place(place("in"));
        net.transition(
            place("enters"),
            &[&place("asks"), "free"],
            &[&place("in"), &place("may")],
        );
        net.transition(place("leaves"), &[&place("gone"), &place("in")], &["free"]);
    }
    (net, names.iter().map(|name| robot(name)).collect())
}
