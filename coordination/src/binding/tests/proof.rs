//! What is proved is what runs: a binding is made with a proof of its own net, protocols and state.

use std::sync::Arc;

use crate::analysis::{Limits, Proof, Use, check};
use crate::binding::{NetBinding, Standing};
use crate::event::EventTable;
use crate::petri::{Binding, Budget, Net, NetModel};
use crate::protocol::{Change, Level, Party, Protocol, ProtocolModel, Replica, Side, channel};

use super::area;

/// Lets one of two robots in.
fn gate() -> NetModel {
    let mut gate = NetModel::new("gate");
    gate.place("free").mark("free").end("idle", &["free"]);
    for own in ["a", "b"] {
        let place = |what: &str| format!("{own} {what}");
        gate.source(place("asks"), Binding::flag(own, "request"));
        gate.sink(place("may"), Binding::flag(own, "granted"));
        gate.source(place("left"), Binding::flag(own, "released"));
        gate.place(place("inside"));
        gate.transition(
            place("enters"),
            &[&place("asks"), "free"],
            &[&place("inside"), &place("may")],
        );
        gate.transition(
            place("leaves"),
            &[&place("left"), &place("inside")],
            &["free"],
        );
    }
    gate
}

fn prove(model: &NetModel, protocols: &[(&str, &Arc<Protocol>)]) -> (Proof, Net) {
    let uses: Vec<_> = { protocols.iter() }
        .map(|&(name, protocol)| Use::new(name, Arc::clone(protocol), Party::Second))
        .collect();
    let proof = check(model, &uses, &Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    (proof, model.compile(&mut EventTable::new()).unwrap())
}

fn both(protocol: &Arc<Protocol>) -> (Proof, Net) {
    prove(&gate(), &[("a", protocol), ("b", protocol)])
}

/// The mediator's side, where a journal says that it was.
fn side(protocol: &Arc<Protocol>, flags: u16) -> Replica {
    let level = Level {
        protocol: 1,
        run: 0,
        path: 0,
        progress: flags,
        after_abort: false,
    };
    Replica::resume(protocol, Party::Second, level).unwrap()
}

fn refusal<S>(result: Result<NetBinding<S>, Vec<crate::binding::BindError>>) -> String {
    let errors = result.err().expect("it does not fit");
    let texts: Vec<_> = errors.iter().map(ToString::to_string).collect();
    texts.join("; ")
}

/// With A inside by its protocol, and `free` marked in the net, B would be let in too.
#[test]
fn a_side_that_is_elsewhere_than_the_net_is_refused() {
    let protocol = area("mediator");
    let (proof, net) = both(&protocol);
    let sides = |granted| [("a", side(&protocol, granted)), ("b", side(&protocol, 0))];
    assert!(NetBinding::new(&proof, &net, sides(0)).is_ok());
    assert_eq!(
        refusal(NetBinding::new(&proof, &net, sides(2))),
        "net `gate` never comes to where it is to begin, so nothing is proved of that: marked are free; \
         set are a: request, granted; b: nothing set"
    );
    let standing = |names: &[&str]| Standing {
        marked: names
            .iter()
            .map(|name| net.place_id(name).unwrap())
            .collect(),
        waiting: Vec::new(),
    };
    let inside = standing(&["a inside"]);
    assert!(NetBinding::resume(&proof, &net, sides(2), &inside).is_ok());
    for wrong in [
        standing(&["free"]),
        standing(&["a inside", "b inside"]),
        standing(&[]),
    ] {
        let refused = refusal(NetBinding::resume(&proof, &net, sides(2), &wrong));
        assert!(
            refused.contains("never comes to where it is to begin"),
            "{refused}"
        );
    }
}

#[test]
fn a_proof_of_something_else_is_refused() {
    let protocol = area("mediator");
    let (proof, net) = both(&protocol);
    let new = |name: &'static str| (name, channel(&protocol).1);
    let refused = |proof, net, sides| refusal(NetBinding::<_>::new(proof, net, sides));

    let (other, _) = prove(
        gate().exclusion("one", &["a inside", "b inside"]),
        &[("a", &protocol), ("b", &protocol)],
    );
    assert_eq!(
        refused(&other, &net, vec![new("a"), new("b")]),
        "the proof is one of net `gate` with other places, transitions or marks, not of this net `gate`"
    );
    // The same net, written a second time, is the same.
    let again = gate().compile(&mut EventTable::new()).unwrap();
    assert!(NetBinding::new(&proof, &again, [new("a"), new("b")]).is_ok());

    assert_eq!(
        refused(&proof, &net, vec![new("a"), new("b"), new("c")]),
        "protocol `c` is not part of the net's proof"
    );
    let swapped = ("b", channel(&area("robot")).1);
    assert!(refused(&proof, &net, vec![new("a"), swapped]).contains(
        "the side given for `b` is of another protocol or another party than in the net's proof"
    ));
}

/// Two sources of one flag are two queues: one that is full holds nothing back from the other. A flag
/// that were held while any of its sources is full, or offered while all are empty only, would stop
/// this net, which the analysis lets pass.
#[test]
fn a_flag_fills_each_of_its_sources_by_itself() {
    let mut model = ProtocolModel::new("steps", "robot", "mediator");
    model.array(
        "all",
        &[
            ("ask", "robot"),
            ("may", "mediator"),
            ("ask again", "robot"),
        ],
    );
    let protocol = Arc::new(model.compile().unwrap());
    let mut net = NetModel::new("two queues");
    net.source("first", Binding::flag("r", "ask"));
    net.source("second", Binding::flag("r", "ask"));
    net.source("over", Binding::flag("r", "ask again"));
    net.sink("may", Binding::flag("r", "may"));
    net.place("even")
        .mark("even")
        .place("odd")
        .place("told")
        .place("twice");
    // Every other run takes both tokens of `second`.
    net.transition("answer", &["first", "even"], &["told", "may"]);
    net.transition("go on", &["over", "told"], &["odd"]);
    net.transition("answer again", &["first", "odd"], &["twice", "may"]);
    net.transition("take", &["over", "twice", "second"], &["half"]);
    net.place("half");
    net.transition("take again", &["half", "second"], &["even"]);
    net.end("even", &["even"]);
    let (proof, compiled) = prove(&net, &[("r", &protocol)]);
    let (mut robot, mediator) = channel(&protocol);
    let mut binding = NetBinding::new(&proof, &compiled, [("r", mediator)]).unwrap();
    let flag = |name| protocol.flag(name).unwrap();
    for run in 0..6 {
        robot.set(flag("ask")).unwrap();
        binding.step(Budget::default(), |_| true);
        assert_eq!(binding.held("r"), run % 2);
        assert_eq!(robot.poll(), Some(Change::Flag(flag("may"))), "run {run}");
        robot.set(flag("ask again")).unwrap();
        while binding.step(Budget::ONE, |_| true).remaining {
            assert!(binding.is_proved_by(&proof));
        }
        assert_eq!(binding.held("r"), 0);
    }
    let even = compiled.place_id("even").unwrap();
    assert!(binding.executor().is_marked(even));
}

/// After any step, what is stored is enough to go on as if nothing had happened; flags that were not
/// read yet come again.
#[test]
fn a_net_goes_on_from_its_journal() {
    let protocol = area("mediator");
    let (proof, net) = both(&protocol);
    let replica = |party| Replica::new(&protocol, 1, party, 0);
    let mut robots = [replica(Party::First), replica(Party::First)];
    let sides = ["a", "b"].map(|name| (name, replica(Party::Second)));
    let mut binding = NetBinding::new(&proof, &net, sides).unwrap();
    let mut crossed = 0;
    for turn in 0..200_usize {
        // A restart between any two things that happen.
        let levels: Vec<Level> = binding.sides().iter().map(Replica::read_level).collect();
        let standing = binding.standing();
        let sides = ["a", "b"].into_iter().zip(levels).map(|(name, level)| {
            let side = Replica::resume(&protocol, Party::Second, level).unwrap();
            (name, side)
        });
        binding = NetBinding::resume(&proof, &net, sides, &standing).unwrap();

        for (robot, side) in robots.iter_mut().zip(binding.sides_mut()) {
            side.merge(robot.level()).unwrap();
            robot.merge(side.level()).unwrap();
            while robot.poll().is_some() {}
        }
        let robot = &mut robots[turn / 3 % 2];
        let (flag, _) = protocol.next(robot.read_to()).next().unwrap_or_else(|| {
            crossed += 1;
            let request = protocol.flag("request").unwrap();
            (request, robot.read_to())
        });
        let _ = robot.set(flag);
        binding.step(
            Budget {
                firings: turn as u32 % 2,
                rounds: 1,
            },
            |_| true,
        );
        let inside = |robot: &&Replica| protocol.progress(robot.position()) == 2;
        assert!(robots.iter().filter(inside).count() <= 1);
    }
    assert!(robots.iter().all(|robot| robot.run() > 10), "{crossed}");
}
