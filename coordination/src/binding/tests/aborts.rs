//! Robots that give up at any moment.

use std::cell::RefCell;
use std::sync::Arc;

use crate::binding::NetBinding;
use crate::event::EventTable;
use crate::petri::{Binding, Budget, NetModel};
use crate::protocol::{
    AbortError, Change, End, FlagId, Party, Position, Protocol, SetError, Side, channel,
};

use super::area;

const ROBOTS: [&str; 2] = ["a", "b"];

/// One robot at a time; what a robot that gave up holds is free again.
fn gate(robots: &[&str]) -> NetModel {
    let mut net = NetModel::new("gate");
    net.place("free").mark("free");
    for &robot in robots {
        let place = |what: &str| format!("{robot} {what}");
        let [asked, may, left, gone] = ["asked", "may", "left", "gone"].map(place);
        let [taken, outside] = ["taken", "outside"].map(place);
        net.source(&asked, Binding::flag(robot, "request"));
        net.sink(&may, Binding::flag(robot, "granted"));
        net.source(&left, Binding::flag(robot, "released"));
        net.source(&gone, Binding::flag(robot, "aborted"));
        net.place(&taken).place(&outside).mark(&outside);
        net.transition(
            place("enters"),
            &[&asked, "free", &outside],
            &[&taken, &may],
        );
        net.transition(place("leaves"), &[&left, &taken], &["free", &outside]);
        net.transition(place("ignored"), &[&gone, &outside], &[&outside]);
        net.transition(place("cleared"), &[&gone, &taken], &["free", &outside]);
    }
    net
}

fn bind<S: Side>(
    model: &NetModel,
    sides: impl IntoIterator<Item = (&'static str, S)>,
) -> NetBinding<S> {
    let net = model.compile(&mut EventTable::new()).unwrap();
    NetBinding::unproved(&net, sides).unwrap()
}

fn is_marked<S: Side>(binding: &NetBinding<S>, name: &str) -> bool {
    let executor = binding.executor();
    let mut marking = executor.marking();
    marking.any(|place| executor.net().place_name(place) == name)
}

/// The request of the next run must not be granted before the net has heard that the last is over:
/// clearing up would then free what has just been granted.
#[test]
fn a_request_does_not_overtake_the_abort_before_it() {
    let protocol = area("robot");
    let flag = |name| protocol.flag(name).unwrap();
    let (mut robot, mediator) = channel(&protocol);
    let mut binding = bind(&gate(&["a"]), [("a", mediator)]);
    robot.set(flag("request")).unwrap();
    robot.abort().unwrap();
    robot.set(flag("request")).unwrap();
    let progress = binding.step(Budget::default(), |_| true);
    assert_eq!((progress.read, binding.aborts("a")), (1, 1));
    assert!(progress.remaining, "the request is unread");
    assert_eq!(robot.poll(), None);
    let progress = binding.step(Budget::default(), |_| true);
    assert_eq!((progress.read, progress.set), (1, 1));
    assert!(!progress.remaining);
    assert_eq!(robot.poll(), Some(Change::Flag(flag("granted"))));
    assert!(is_marked(&binding, "a taken") && !is_marked(&binding, "free"));
}

/// A net that never deals with an abort reads nothing more, and does not ask to be called again.
#[test]
fn an_abort_that_stays_in_its_source_holds_back_what_follows() {
    let protocol = area("robot");
    let request = protocol.flag("request").unwrap();
    let (mut robot, mediator) = channel(&protocol);
    let mut net = NetModel::new("deaf");
    net.source("asked", Binding::flag("a", "request"));
    net.source("gone", Binding::flag("a", "aborted"));
    net.source("go", Binding::event("go"));
    net.sink("noted", Binding::event("noted"));
    net.transition("note", &["asked"], &["noted"]);
    net.transition("hear", &["gone", "go"], &[]);
    let mut events = EventTable::new();
    let compiled = net.compile(&mut events).unwrap();
    let mut binding = NetBinding::unproved(&compiled, [("a", mediator)]).unwrap();
    for _ in 0..2 {
        robot.set(request).unwrap();
        robot.abort().unwrap();
    }
    robot.set(request).unwrap();
    for _ in 0..3 {
        let progress = binding.step(Budget::default(), |_| panic!("nothing is noted"));
        assert!(!progress.remaining);
    }
    assert_eq!(binding.aborts("a"), 1, "two aborts at once are one");
    // A further one waits too.
    robot.abort().unwrap();
    robot.set(request).unwrap();
    binding.step(Budget::default(), |_| panic!("nothing is noted"));
    let go = events.id("go").unwrap();
    for aborts in [1, 2] {
        assert_eq!(binding.aborts("a"), aborts);
        binding.offer(go).unwrap();
        let progress = binding.step(Budget::default(), |_| panic!("nothing is noted"));
        assert!(progress.remaining);
        if aborts == 1 {
            assert!(!binding.step(Budget::default(), |_| true).remaining);
        }
    }
    let mut noted = 0;
    binding.step(Budget::default(), |_| {
        noted += 1;
        true
    });
    assert_eq!(noted, 1);
}

/// Robots ask, leave and give up whenever they like, while the net does a little at a time.
#[test]
fn whatever_robots_give_up_no_two_are_granted() {
    let protocol = area("robot");
    let flag = |name| protocol.flag(name).unwrap();
    let (request, granted, released) = (flag("request"), flag("granted"), flag("released"));
    let (mut robots, mut sides) = (Vec::new(), Vec::new());
    for name in ROBOTS {
        let (robot, mediator) = channel(&protocol);
        robots.push((robot, false));
        sides.push((name, mediator));
    }
    let mut binding = bind(&gate(&ROBOTS), sides);
    let mut seed = 1_u64;
    let mut coin = |sides: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) % sides
    };
    let (mut entered, mut given_up) = (0, 0);
    for _ in 0..50_000 {
        for (robot, inside) in &mut robots {
            match coin(6) {
                0 | 1 => drop(robot.set(request)),
                2 if *inside => {
                    robot.set(released).unwrap();
                    *inside = false;
                }
                3 => {
                    given_up += u32::from(robot.abort().unwrap() != Position::START);
                    *inside = false;
                }
                _ => {
                    if let Some(change) = robot.poll() {
                        assert_eq!(change, Change::Flag(granted));
                        *inside = true;
                        entered += 1;
                    }
                }
            }
        }
        let inside = robots.iter().filter(|(_, inside)| *inside).count();
        assert!(inside <= 1, "both were granted");
        assert!(
            inside == 0 || !is_marked(&binding, "free"),
            "the net calls free what a robot holds"
        );
        if coin(2) == 0 {
            binding.step(Budget::ONE, |_| true);
        }
    }
    assert!(entered > 1000 && given_up > 1000, "{entered}, {given_up}");
}

/// An end whose keeper gives up just after this party has looked, before it reads.
#[derive(Debug)]
struct Overtaken {
    end: End,
    keeper: RefCell<Option<End>>,
}

impl Side for Overtaken {
    fn protocol(&self) -> &Protocol {
        self.end.protocol()
    }
    fn party(&self) -> Party {
        self.end.party()
    }
    fn read_to(&self) -> Position {
        self.end.read_to()
    }
    fn set(&mut self, flag: FlagId) -> Result<(), SetError> {
        self.end.set(flag)
    }
    fn peek(&self) -> Option<Change> {
        let seen = self.end.peek();
        if let (Some(Change::Flag(_)), Some(mut keeper)) = (seen, self.keeper.take()) {
            keeper.abort().unwrap();
        }
        seen
    }
    fn poll(&mut self) -> Option<Change> {
        self.end.poll()
    }
    fn abort(&mut self) -> Result<Position, AbortError> {
        self.end.abort()
    }
}

fn overtaken(end: End, keeper: End) -> Overtaken {
    let keeper = RefCell::new(Some(keeper));
    Overtaken { end, keeper }
}

#[test]
fn a_net_does_not_mistake_an_abort_for_the_flag_that_it_saw() {
    let protocol: Arc<Protocol> = area("robot");
    let (mut robot, mediator) = channel(&protocol);
    robot.set(protocol.flag("request").unwrap()).unwrap();
    let mut binding = bind(&gate(&["a"]), [("a", overtaken(mediator, robot))]);
    let progress = binding.step(Budget::default(), |_| true);
    assert_eq!((progress.set, binding.aborts("a")), (0, 1));
    assert!(is_marked(&binding, "free"));
}
