//! Proves with a counting allocator that protocols and bindings do not allocate while they run.

mod counting;

use std::sync::Arc;

use coordination::analysis::{Limits, Use, check};
use coordination::binding::NetBinding;
use coordination::event::EventTable;
use coordination::fsm::MachineModel;
use coordination::petri::{Binding, Budget, NetModel};
use coordination::protocol::{End, Party, Protocol, ProtocolModel, Replica, Side, channel};
use counting::allocations;

fn area(keeper: &str) -> Arc<Protocol> {
    let mut model = ProtocolModel::new("area", "robot", "mediator");
    model.keeper(keeper).array(
        "all",
        &[
            ("request", "robot"),
            ("granted", "mediator"),
            ("released", "robot"),
        ],
    );
    Arc::new(model.compile().unwrap())
}

/// Lets one robot in at a time; what one that gave up holds is free again.
fn gate(protocol: &Arc<Protocol>) -> (End, NetBinding<End>) {
    let mut gate = NetModel::new("gate");
    gate.source("asked", Binding::flag("r", "request"));
    gate.sink("granted", Binding::flag("r", "granted"));
    gate.source("left", Binding::flag("r", "released"));
    gate.place("free").mark("free").place("inside");
    gate.transition("enter", &["asked", "free"], &["inside", "granted"]);
    gate.transition("leave", &["left", "inside"], &["free"]);
    if protocol.keeper() == Some(Party::First) {
        gate.source("gone", Binding::flag("r", "aborted"));
        gate.transition("ignored", &["gone", "free"], &["free"]);
        gate.transition("cleared", &["gone", "inside"], &["free"]);
    }
    let uses = [Use::new("r", Arc::clone(protocol), Party::Second)];
    let proof = check(&gate, &uses, &Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    let net = gate.compile(&mut EventTable::new()).unwrap();
    let (robot, mediator) = channel(protocol);
    let gate = NetBinding::new(&proof, &net, [("r", mediator)]).unwrap();
    (robot, gate)
}

#[test]
fn a_run_through_net_machine_and_protocol_allocates_nothing() {
    let mut model = MachineModel::new("robot");
    model.state("away").state("inside").initial("away");
    model.transition("away", "near", "inside", &["request"]);
    model.transition("inside", "out", "away", &["released"]);
    let mut events = EventTable::new();
    let mut machine = model.compile(&mut events).unwrap();
    let [near, out] = ["near", "out"].map(|event| events.id(event).unwrap());
    let protocol = area("mediator");
    let (mut robot, mut gate) = gate(&protocol);
    let [request, released] = ["request", "released"].map(|flag| protocol.flag(flag).unwrap());
    let used = allocations(|| {
        for _ in 0..100 {
            assert_eq!(machine.step(near).outputs.len(), 1);
            robot.set(request).unwrap();
            gate.step(Budget::default(), |_| true);
            robot.poll().unwrap();
            assert_eq!(machine.step(out).outputs.len(), 1);
            robot.set(released).unwrap();
            gate.step(Budget::default(), |_| true);
            robot.poll();
            robot.set(request).unwrap();
            gate.step(Budget::default(), |_| true);
            gate.abort().unwrap();
            robot.poll().unwrap();
        }
    });
    assert_eq!(used, 0);
    assert_eq!(gate.executor().firings(), 300);
}

#[test]
fn an_abort_of_the_other_party_allocates_nothing() {
    let protocol = area("robot");
    let (mut robot, mut gate) = gate(&protocol);
    let request = protocol.flag("request").unwrap();
    let used = allocations(|| {
        for _ in 0..100 {
            robot.set(request).unwrap();
            gate.step(Budget::default(), |_| true);
            robot.abort().unwrap();
            gate.step(Budget::default(), |_| true);
        }
    });
    assert_eq!(used, 0);
    assert_eq!(gate.aborts("r"), 100);
}

#[test]
fn merging_levels_allocates_nothing() {
    let protocol = area("mediator");
    let [request, granted, released] =
        ["request", "granted", "released"].map(|flag| protocol.flag(flag).unwrap());
    let mut robot = Replica::new(&protocol, 0, Party::First, 0);
    let mut mediator = Replica::new(&protocol, 0, Party::Second, 0);
    let used = allocations(|| {
        for _ in 0..100 {
            robot.set(request).unwrap();
            mediator.merge(robot.level()).unwrap();
            mediator.poll().unwrap();
            assert!(robot.set(granted).is_err());
            mediator.set(granted).unwrap();
            robot.merge(mediator.level()).unwrap();
            robot.poll().unwrap();
            robot.set(released).unwrap();
            mediator.merge(robot.level()).unwrap();
            mediator.poll().unwrap();
            robot.merge(mediator.level()).unwrap();
        }
    });
    assert_eq!(used, 0);
    assert_eq!(robot.run(), 100);
}
