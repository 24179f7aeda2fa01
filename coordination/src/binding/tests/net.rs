//! What a bound net does.

use std::sync::Arc;

use crate::binding::NetBinding;
use crate::event::EventTable;
use crate::petri::{Binding, Budget, Net, NetModel, OfferError};
use crate::protocol::{
    AbortError, Change, End, Position, Protocol, ProtocolModel, SetError, Side, channel,
};

use super::area;

/// Grants requests while it is open; counts who has left in an event. An event closes it.
pub(super) fn gate_model() -> NetModel {
    let mut gate = NetModel::new("gate");
    gate.source("asked", Binding::flag("robot", "request"));
    gate.sink("granted", Binding::flag("robot", "granted"));
    gate.source("left", Binding::flag("robot", "released"));
    gate.sink("counted", Binding::event("count"));
    gate.source("close", Binding::event("close"));
    gate.place("open")
        .mark("open")
        .place("inside")
        .place("closed");
    gate.transition("enter", &["asked", "open"], &["inside", "granted"]);
    gate.transition("leave", &["left", "inside"], &["open", "counted"]);
    gate.transition("shut", &["close", "open"], &["closed"]);
    gate.end("shut", &["closed"]);
    gate
}

pub(super) fn compile(model: &NetModel) -> (Net, EventTable) {
    let mut events = EventTable::new();
    let net = model.compile(&mut events).unwrap();
    (net, events)
}

fn bind(model: &NetModel, protocol: &Arc<Protocol>) -> (End, NetBinding<End>, EventTable) {
    let (robot, mediator) = channel(protocol);
    let (net, events) = compile(model);
    let binding = NetBinding::unproved(&net, [("robot", mediator)]).unwrap();
    (robot, binding, events)
}

#[test]
fn flags_become_tokens_and_tokens_become_flags() {
    let protocol = area("mediator");
    let flag = |name| protocol.flag(name).unwrap();
    let (mut robot, mut gate, events) = bind(&gate_model(), &protocol);
    let count = events.id("count").unwrap();
    let quiet = gate.step(Budget::default(), |_| panic!("nothing happened"));
    assert_eq!((quiet.read, quiet.evaluation.fired, quiet.set), (0, 0, 0));
    for _ in 0..3 {
        robot.set(flag("request")).unwrap();
        let progress = gate.step(Budget::default(), |_| panic!("no event is due"));
        assert_eq!(
            (progress.read, progress.evaluation.fired, progress.set),
            (1, 1, 1)
        );
        assert!(!progress.remaining);
        assert_eq!(robot.poll(), Some(Change::Flag(flag("granted"))));
        robot.set(flag("released")).unwrap();
        let mut sent = Vec::new();
        gate.step(Budget::default(), |event| {
            sent.push(event);
            true
        });
        assert_eq!(sent, [count]);
    }
    gate.offer(events.id("close").unwrap()).unwrap();
    robot.set(flag("request")).unwrap();
    gate.step(Budget::ONE, |_| true);
    assert_eq!(gate.refused(), 0);
    assert_eq!(gate.names().collect::<Vec<_>>(), ["robot"]);
}

#[test]
fn an_event_that_is_not_taken_stays_in_its_sink() {
    let protocol = area("mediator");
    let flag = |name| protocol.flag(name).unwrap();
    let (mut robot, mut gate, _) = bind(&gate_model(), &protocol);
    let full = |gate: &NetBinding<End>| gate.executor().marked_sinks().count();
    for run in 0..2 {
        robot.set(flag("request")).unwrap();
        gate.step(Budget::default(), |_| false);
        robot.poll().unwrap();
        robot.set(flag("released")).unwrap();
        let progress = gate.step(Budget::default(), |_| false);
        // The second robot cannot be counted while the first is not.
        assert_eq!(progress.evaluation.fired, 1 - run);
        assert_eq!(full(&gate), 1);
    }
    gate.step(Budget::default(), |_| true);
    let progress = gate.step(Budget::default(), |_| true);
    assert_eq!((progress.evaluation.fired, full(&gate)), (1, 0));
}

/// What the net takes late waits in the binding, and the protocol goes on meanwhile.
#[test]
fn a_flag_for_a_full_source_waits() {
    let mut model = ProtocolModel::new("ticks", "robot", "mediator");
    model.array("all", &[("tick", "robot")]);
    let protocol = Arc::new(model.compile().unwrap());
    let tick = protocol.flag("tick").unwrap();
    let mut net = NetModel::new("ticks");
    net.source("tick", Binding::flag("robot", "tick"));
    net.source("go", Binding::event("go"));
    net.sink("tock", Binding::event("tock"));
    net.transition("pass", &["tick", "go"], &["tock"]);
    let (mut robot, mut binding, events) = bind(&net, &protocol);
    let mut ticks = 0;
    loop {
        match robot.set(tick) {
            Ok(()) => ticks += 1,
            Err(error) => {
                assert_eq!(error, SetError::Complete);
                break;
            }
        }
        let progress = binding.step(Budget::default(), |_| true);
        assert!(!progress.remaining);
        assert!(ticks < 1000, "what waits is bounded");
    }
    // One fills the source, one is not read.
    let held = u32::from(NetBinding::<End>::MAX_HELD);
    assert_eq!((ticks, binding.held("robot")), (held + 2, held));
    let mut tocks = 0;
    for _ in 0..ticks {
        binding.offer(events.id("go").unwrap()).unwrap();
        for _ in 0..2 {
            binding.step(Budget::default(), |_| {
                tocks += 1;
                true
            });
        }
    }
    assert_eq!((tocks, binding.held("robot")), (ticks, 0));
    robot.set(tick).unwrap();
}

/// Two sinks that fill at once are set in the order of the protocol, not of the net.
#[test]
fn flags_that_come_together_are_set_in_order() {
    let mut model = ProtocolModel::new("steps", "robot", "mediator");
    model.array(
        "all",
        &[("go", "robot"), ("one", "mediator"), ("two", "mediator")],
    );
    let protocol = Arc::new(model.compile().unwrap());
    let mut net = NetModel::new("steps");
    net.sink("two", Binding::flag("robot", "two"));
    net.sink("one", Binding::flag("robot", "one"));
    net.source("go", Binding::flag("robot", "go"));
    net.transition("both", &["go"], &["two", "one"]);
    let (mut robot, mut binding, _) = bind(&net, &protocol);
    robot.set(protocol.flag("go").unwrap()).unwrap();
    assert_eq!(binding.step(Budget::default(), |_| true).set, 2);
    let read: Vec<_> = std::iter::from_fn(|| robot.poll()).collect();
    let expected = ["one", "two"].map(|flag| Change::Flag(protocol.flag(flag).unwrap()));
    assert_eq!(read, expected);
}

#[test]
fn a_flag_out_of_order_stays_and_is_reported_once() {
    let protocol = area("mediator");
    let mut net = NetModel::new("hasty");
    net.source("hurry", Binding::event("hurry"));
    net.sink("granted", Binding::flag("robot", "granted"));
    net.transition("grant", &["hurry"], &["granted"]);
    let (mut robot, mut binding, events) = bind(&net, &protocol);
    binding.offer(events.id("hurry").unwrap()).unwrap();
    for _ in 0..3 {
        assert_eq!(binding.step(Budget::default(), |_| true).set, 0);
    }
    let granted = protocol.flag("granted").unwrap();
    let error = SetError::OutOfOrder {
        flag: granted,
        at: Position::START,
    };
    assert_eq!(
        binding.refusals().collect::<Vec<_>>(),
        [("robot", granted, error)]
    );
    assert_eq!(binding.refused(), 1);
    robot.set(protocol.flag("request").unwrap()).unwrap();
    assert_eq!(binding.step(Budget::default(), |_| true).set, 1);
    assert_eq!(binding.refusals().count(), 0);
}

/// The robot gives up: a grant on its way and a request not yet granted must not reach its next run.
#[test]
fn an_abort_voids_what_belongs_to_the_run() {
    let protocol = area("robot");
    let flag = |name| protocol.flag(name).unwrap();
    let mut net = NetModel::new("gate");
    net.source("asked", Binding::flag("robot", "request"));
    net.sink("note", Binding::event("note"));
    net.sink("granted", Binding::flag("robot", "granted"));
    net.source("gone", Binding::flag("robot", "aborted"));
    net.source("left", Binding::flag("robot", "released"));
    net.source("open", Binding::event("open"));
    net.place("outside").mark("outside").place("inside");
    net.transition(
        "enter",
        &["asked", "open", "outside"],
        &["note", "inside", "granted"],
    );
    net.transition("leave", &["left", "inside"], &["outside"]);
    net.transition("give up", &["gone", "inside"], &["outside"]);
    net.transition("gave up before", &["gone", "outside"], &["outside"]);
    let (mut robot, mut binding, events) = bind(&net, &protocol);
    let open = events.id("open").unwrap();
    let marked = |binding: &NetBinding<End>| {
        let executor = binding.executor();
        let names = executor
            .marking()
            .map(|place| executor.net().place_name(place).to_owned());
        names.collect::<Vec<_>>()
    };

    // A token in a source.
    robot.set(flag("request")).unwrap();
    binding.step(Budget::default(), |_| true);
    assert_eq!(marked(&binding), ["asked", "outside"]);
    robot.abort().unwrap();
    binding.step(Budget::default(), |_| true);
    assert_eq!(
        (marked(&binding), binding.aborts("robot")),
        (vec!["outside".to_owned()], 1)
    );

    // A token in a sink: the robot gives up after the net has decided, before the flag is set.
    binding.offer(open).unwrap();
    robot.set(flag("request")).unwrap();
    binding.step(Budget::default(), |_| robot.abort().is_ok());
    assert_eq!(marked(&binding), ["granted", "inside"]);
    assert_eq!(binding.refused(), 1);
    robot.set(flag("request")).unwrap();
    // First the abort, then what follows it.
    for marks in [&["outside"][..], &["asked", "outside"]] {
        binding.step(Budget::default(), |_| true);
        assert_eq!(marked(&binding), marks);
    }
    assert_eq!(
        robot.poll(),
        None,
        "the new request is not granted by the old token"
    );
    binding.offer(open).unwrap();
    binding.step(Budget::default(), |_| true);
    assert_eq!(robot.poll(), Some(Change::Flag(flag("granted"))));
}

#[test]
fn a_keeper_starts_over() {
    let (mut robot, mut gate, _) = bind(&gate_model(), &area("robot"));
    assert_eq!(gate.abort(), Err(AbortError::NotKeeper));
    let request = robot.protocol().flag("request").unwrap();
    robot.set(request).unwrap();
    gate.step(Budget::default(), |_| true);
    assert_eq!(gate.side("robot").unwrap().run(), 0);

    let (mut robot, mut gate, _) = bind(&gate_model(), &area("mediator"));
    robot.set(request).unwrap();
    gate.step(Budget::default(), |_| true);
    gate.abort().unwrap();
    let initial: Vec<_> = gate.executor().net().initial_marking().collect();
    assert_eq!(gate.executor().marking().collect::<Vec<_>>(), initial);
    assert_eq!(robot.poll(), Some(Change::Aborted));
    robot.set(request).unwrap();
    assert_eq!(gate.step(Budget::default(), |_| true).set, 1);
    assert_eq!(gate.side("robot").unwrap().run(), 1);
}

/// Two events for one sink: the second has to wait until the first is taken, and then goes on.
#[test]
fn a_sink_that_is_emptied_leaves_something_to_do() {
    let mut net = NetModel::new("notes");
    net.source("a", Binding::event("a"));
    net.source("b", Binding::event("b"));
    net.sink("note", Binding::event("note"));
    net.transition("t1", &["a"], &["note"]);
    net.transition("t2", &["b"], &["note"]);
    let (_robot, mut binding, events) = bind(&net, &area("mediator"));
    for event in ["a", "b"] {
        binding.offer(events.id(event).unwrap()).unwrap();
    }
    // Nobody takes it, so there is nothing to do.
    let progress = binding.step(Budget::default(), |_| false);
    assert_eq!((progress.evaluation.fired, progress.remaining), (1, false));
    let progress = binding.step(Budget::default(), |_| true);
    assert_eq!((progress.evaluation.fired, progress.remaining), (0, true));
    let progress = binding.step(Budget::default(), |_| true);
    assert_eq!((progress.evaluation.fired, progress.remaining), (1, false));
}

#[test]
fn a_flag_cannot_be_offered_as_an_event() {
    let (_robot, mut gate, events) = bind(&gate_model(), &area("mediator"));
    for flag in ["robot.request", "robot.granted", "robot.released"] {
        let event = events.id(flag).unwrap();
        assert_eq!(gate.offer(event), Err(OfferError::Flag(event)));
    }
    let count = events.id("count").unwrap();
    assert_eq!(gate.offer(count), Err(OfferError::UnknownEvent(count)));
    gate.step(Budget::default(), |_| panic!("nothing happened"));
    assert_eq!(gate.executor().firings(), 0);
}

/// Events belong to no run, so they outlive its abort; flags do not.
#[test]
fn an_abort_of_all_runs_keeps_events() {
    let protocol = area("mediator");
    let flag = |name| protocol.flag(name).unwrap();
    let mut net = gate_model();
    net.source("knock", Binding::event("knock"));
    net.sink("echo", Binding::event("echo"));
    net.transition("answer", &["knock"], &["echo"]);
    let (mut robot, mut gate, events) = bind(&net, &protocol);
    let knock = events.id("knock").unwrap();
    for _ in 0..4 {
        gate.offer(knock).unwrap();
    }
    robot.set(flag("request")).unwrap();
    // One knock is answered, one stands in the source, and two wait.
    for _ in 0..2 {
        gate.step(Budget::default(), |_| false);
    }
    gate.abort().unwrap();
    let names = |gate: &NetBinding<End>| {
        let executor = gate.executor();
        let names = executor.marking();
        let mut names: Vec<_> = names
            .map(|place| executor.net().place_name(place).to_owned())
            .collect();
        names.sort_unstable();
        names
    };
    assert_eq!(names(&gate), ["echo", "knock", "open"]);
    assert_eq!(robot.poll(), Some(Change::Aborted));
    let mut echoes = 0;
    for _ in 0..10 {
        gate.step(Budget::default(), |_| {
            echoes += 1;
            true
        });
    }
    assert_eq!((echoes, names(&gate)), (4, vec!["open".to_owned()]));
    robot.set(flag("request")).unwrap();
    assert_eq!(gate.step(Budget::default(), |_| true).set, 1);
}

/// What the other party's abort voids leaves the order of events to be sent as it was.
#[test]
fn an_abort_does_not_reorder_full_sinks() {
    let protocol = area("robot");
    let mut net = NetModel::new("sinks");
    net.source("asked", Binding::flag("robot", "request"));
    net.source("gone", Binding::flag("robot", "aborted"));
    net.place("never").mark("never").place("ever");
    net.transition("enter", &["asked", "ever"], &["never"]);
    net.transition("ignore", &["gone", "never"], &["never"]);
    net.transition("odd", &["never", "ever"], &["ever"]);
    for name in ["one", "two", "three"] {
        let (source, sink) = (format!("say {name}"), format!("said {name}"));
        net.sink(&sink, Binding::event(&sink));
        net.source(&source, Binding::event(&source));
        net.transition(name, &[&source], &[&sink]);
    }
    let (mut robot, mut binding, events) = bind(&net, &protocol);
    let spoken = ["three", "one", "two"];
    for name in spoken {
        let event = events.id(&format!("say {name}")).unwrap();
        binding.offer(event).unwrap();
        binding.step(Budget::default(), |_| false);
    }
    robot.set(protocol.flag("request").unwrap()).unwrap();
    binding.step(Budget::default(), |_| false);
    robot.abort().unwrap();
    let mut sent = Vec::new();
    binding.step(Budget::default(), |event| {
        sent.push(event);
        true
    });
    assert_eq!(binding.aborts("robot"), 1);
    let expected = spoken.map(|name| events.id(&format!("said {name}")).unwrap());
    assert_eq!(sent, expected);
    assert_eq!(binding.executor().marking().count(), 1);
}
