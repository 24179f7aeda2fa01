//! Proves with a counting allocator that protocols and bindings do not allocate while they run.

mod counting;

use std::sync::Arc;

use coordination::binding::{MachineBinding, NetBinding};
use coordination::event::EventTable;
use coordination::fsm::MachineModel;
use coordination::petri::{Binding, Budget, NetModel};
use coordination::protocol::{Party, Protocol, ProtocolModel, Replica, Side, channel};
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

fn gate(robot: &str) -> NetModel {
    let mut gate = NetModel::new("gate");
    gate.source("asked", Binding::flag(robot, "request"));
    gate.sink("granted", Binding::flag(robot, "granted"));
    gate.source("left", Binding::flag(robot, "released"));
    gate.place("free").mark("free").place("inside");
    gate.transition("enter", &["asked", "free"], &["inside", "granted"]);
    gate.transition("leave", &["left", "inside"], &["free"]);
    gate
}

fn robot() -> MachineModel {
    let mut model = MachineModel::new("robot");
    model
        .state("away")
        .state("waiting")
        .state("inside")
        .initial("away");
    model.transition("away", "near", "waiting", &["area.request"]);
    model.transition("waiting", "area.granted", "inside", &[]);
    model.transition("inside", "out", "away", &["area.released"]);
    model.transition("waiting", "area.aborted", "away", &[]);
    model
}

#[test]
fn the_allocator_is_counted() {
    assert!(allocations(|| drop(std::hint::black_box(Box::new(1)))) >= 2);
}

#[test]
fn a_run_through_net_machine_and_protocol_allocates_nothing() {
    let protocol = area("mediator");
    let (robot_end, mediator_end) = channel(&protocol);
    let mut events = EventTable::new();
    let machine = robot().compile(&mut events).unwrap();
    let [near, out] = ["near", "out"].map(|event| events.id(event).unwrap());
    let mut robot = MachineBinding::new(machine, [("area", robot_end)]).unwrap();
    let net = gate("r").compile(&mut EventTable::new()).unwrap();
    let mut gate = NetBinding::unproved(&net, [("r", mediator_end)]).unwrap();
    let used = allocations(|| {
        for _ in 0..100 {
            robot.step(near, |_| {}).unwrap();
            gate.step(Budget::default(), |_| true);
            robot.communicate(|_| {});
            robot.step(out, |_| {}).unwrap();
            robot.step(near, |_| {}).unwrap();
            gate.step(Budget::default(), |_| true);
            robot.communicate(|_| {});
            gate.step(Budget::default(), |_| true);
            gate.abort().unwrap();
            robot.communicate(|_| {});
            assert_eq!(robot.waiting("area"), 0);
        }
    });
    assert_eq!(used, 0);
    assert_eq!(robot.state_name(), "away");
    assert_eq!(gate.executor().firings(), 300);
}

#[test]
fn an_abort_of_the_other_party_allocates_nothing() {
    let protocol = area("robot");
    let (mut robot, mediator_end) = channel(&protocol);
    let net = gate("r").compile(&mut EventTable::new()).unwrap();
    let mut gate = NetBinding::unproved(&net, [("r", mediator_end)]).unwrap();
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
