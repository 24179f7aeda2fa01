//! The robot's half.

use std::sync::Arc;

use coordination::binding::{MachineBinding, NoRoom};
use coordination::event::{EventId, EventTable};
use coordination::fsm::MachineModel;
use coordination::protocol::{Change, End, Position, Protocol, SetError, Side, channel};

use super::common::area;

fn robot_model() -> MachineModel {
    let mut model = MachineModel::new("robot");
    for state in ["away", "waiting", "inside"] {
        model.state(state);
    }
    model.initial("away");
    model.transition("away", "near", "waiting", &["slow", "area.request"]);
    model.transition("waiting", "area.granted", "inside", &["fast"]);
    model.transition("inside", "out", "away", &["area.released"]);
    model.transition("waiting", "area.aborted", "away", &["stop"]);
    model.transition("inside", "area.aborted", "away", &["stop"]);
    model
}

struct Robot {
    binding: MachineBinding<End>,
    mediator: End,
    events: EventTable,
    protocol: Arc<Protocol>,
}

impl Robot {
    fn new(model: &MachineModel) -> Self {
        let protocol = area("mediator");
        let (robot, mediator) = channel(&protocol);
        let mut events = EventTable::new();
        let machine = model.compile(&mut events).unwrap();
        Self {
            binding: MachineBinding::new(machine, [("area", robot)]).unwrap(),
            mediator,
            events,
            protocol,
        }
    }

    fn event(&self, name: &str) -> EventId {
        self.events.id(name).unwrap()
    }

    fn set(&mut self, flag: &str) {
        self.mediator
            .set(self.protocol.flag(flag).unwrap())
            .unwrap();
    }

    /// The outputs, by name, of a step or, without an event, of communicating.
    fn outputs(&mut self, event: &str) -> Result<Vec<String>, NoRoom> {
        let mut fired = Vec::new();
        if event.is_empty() {
            self.binding.communicate(|output| fired.push(output));
        } else {
            let event = self.event(event);
            self.binding.step(event, |output| fired.push(output))?;
        }
        let name = |id| self.events.name(id).unwrap().to_owned();
        Ok(fired.into_iter().map(name).collect())
    }

    fn read(&mut self) -> Vec<Change> {
        std::iter::from_fn(|| self.mediator.poll()).collect()
    }

    fn flags(&self, names: &[&str]) -> Vec<Change> {
        let flag = |name: &&str| Change::Flag(self.protocol.flag(name).unwrap());
        names.iter().map(flag).collect()
    }
}

#[test]
fn outputs_set_flags_and_flags_are_inputs() {
    let mut robot = Robot::new(&robot_model());
    for _ in 0..3 {
        assert_eq!(robot.outputs("near").unwrap(), ["slow"]);
        assert_eq!(robot.read(), robot.flags(&["request"]));
        assert_eq!(robot.outputs("").unwrap(), [""; 0]);
        robot.set("granted");
        assert_eq!(robot.outputs("").unwrap(), ["fast"]);
        assert_eq!(robot.binding.state_name(), "inside");
        assert_eq!(robot.outputs("out").unwrap(), [""; 0]);
        assert_eq!(robot.binding.waiting("area"), 0);
        assert_eq!(robot.read(), robot.flags(&["released"]));
    }
    assert_eq!(robot.binding.machine().ignored(), 0);
}

/// The next request comes before the mediator has seen the end of the last run.
#[test]
fn a_flag_waits_until_it_is_next() {
    let mut robot = Robot::new(&robot_model());
    robot.outputs("near").unwrap();
    robot.read();
    robot.set("granted");
    robot.outputs("").unwrap();
    robot.outputs("out").unwrap();
    robot.outputs("near").unwrap();
    assert_eq!(robot.binding.waiting("area"), 1);
    assert_eq!(robot.binding.stuck().count(), 0);
    assert_eq!(robot.read(), robot.flags(&["released"]));
    robot.outputs("").unwrap();
    assert_eq!(robot.binding.waiting("area"), 0);
    assert_eq!(robot.read(), robot.flags(&["request"]));
}

#[test]
fn a_flag_that_the_state_has_no_use_for_stays_unread() {
    let mut model = robot_model();
    model.state("parked");
    model.transition("waiting", "park", "parked", &[]);
    model.transition("parked", "unpark", "waiting", &[]);
    let mut robot = Robot::new(&model);
    robot.outputs("near").unwrap();
    robot.read();
    robot.outputs("park").unwrap();
    robot.set("granted");
    assert_eq!(robot.binding.communicate(|_| {}), 0);
    assert_eq!(robot.binding.state_name(), "parked");
    assert_eq!(robot.binding.machine().ignored(), 0);
    robot.outputs("unpark").unwrap();
    assert_eq!(robot.outputs("").unwrap(), ["fast"]);
    assert_eq!(robot.binding.state_name(), "inside");
}

#[test]
fn an_abort_is_an_input_and_voids_what_waits() {
    let mut robot = Robot::new(&robot_model());
    robot.outputs("near").unwrap();
    robot.read();
    robot.set("granted");
    robot.outputs("").unwrap();
    robot.mediator.abort().unwrap();
    robot.outputs("out").unwrap();
    assert_eq!(
        robot.binding.waiting("area"),
        1,
        "released, of a run that is over"
    );
    robot.outputs("near").unwrap();
    assert_eq!(robot.outputs("").unwrap(), ["stop"]);
    assert_eq!(
        (robot.binding.waiting("area"), robot.binding.voided()),
        (0, 2)
    );
    assert_eq!(robot.binding.state_name(), "away");
    assert_eq!(robot.read(), []);
    robot.outputs("near").unwrap();
    assert_eq!(robot.read(), robot.flags(&["request"]));
}

/// A machine that releases what it never asked for is stuck, says so, and is held back in the end.
#[test]
fn a_machine_out_of_order_is_stuck_and_bounded() {
    let mut model = MachineModel::new("confused");
    model.state("s").initial("s");
    model.transition("s", "leave", "s", &["area.released"]);
    let mut robot = Robot::new(&model);
    robot.outputs("leave").unwrap();
    let released = robot.protocol.flag("released").unwrap();
    let at = Position::START;
    {
        let stuck: Vec<_> = robot.binding.stuck().collect();
        assert_eq!(
            (stuck.len(), stuck[0].protocol, stuck[0].flag),
            (1, "area", released)
        );
        assert_eq!(stuck[0].error, SetError::OutOfOrder { flag: released, at });
    }
    let mut steps = 1;
    while robot.outputs("leave").is_ok() {
        steps += 1;
        assert!(steps < 100, "what waits is bounded");
    }
    assert_eq!(robot.binding.waiting("area"), steps);
    let event = robot.event("leave");
    assert_eq!(robot.binding.step(event, |_| {}), Err(NoRoom(event)));
    assert_eq!(robot.read(), []);
}

#[test]
fn what_does_not_fit_is_refused_with_its_reason() {
    let refuse = |on: &str, output: &str, names: [&str; 2]| {
        let mut model = MachineModel::new("m");
        model.state("s").initial("s");
        model.transition("s", on, "s", &[output]);
        let machine = model.compile(&mut EventTable::new()).unwrap();
        let sides = names.map(|name| (name, channel(&area("mediator")).0));
        let errors = MachineBinding::new(machine, sides)
            .err()
            .unwrap_or_default();
        errors.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(refuse("a.granted", "a.request", ["a", "b"]), [""; 0]);
    assert_eq!(
        refuse("c.granted", "near", ["a", "b"]),
        [""; 0],
        "they are plain events"
    );
    assert_eq!(
        refuse("near", "c.request", ["a", "b"]),
        ["output `c.request` of machine `m` names the unknown protocol `c`; known protocols: a, b"]
    );
    assert_eq!(refuse("a.b.granted", "a.b.request", ["a", "a.b"]), [""; 0]);
    assert_eq!(
        refuse("a.request", "a.granted", ["a", "b"]),
        [
            "input `a.request` of machine `m` is bound to flag `request` of protocol `a`, which `robot` sets",
            "output `a.granted` of machine `m` is bound to flag `granted` of protocol `a`, which `mediator` sets"
        ]
    );
    assert_eq!(
        refuse("a.grant", "a.aborted", ["a", "b"]),
        [
            "input `a.grant` of machine `m` names the unknown flag `grant` of protocol `a`; its flags: request, granted, released",
            "output `a.aborted` of machine `m` is bound to `aborted` of protocol `a`, whose keeper is not across"
        ]
    );
    assert_eq!(
        refuse("a.granted", "a.request", ["a", "a"])[0],
        "two protocols are called `a`"
    );
}
