//! Sides of different kinds in one binding.

use std::sync::Arc;

use super::area;
use super::net::{compile, gate_model};
use crate::analysis::{Limits, Use, check};
use crate::binding::NetBinding;
use crate::petri::{Binding, Budget, NetModel};
use crate::protocol::{
    AbortError, AnySide, Change, Party, Position, Protocol, ProtocolModel, Replica, Side, channel,
};

/// One robot on a thread of the same machine, one on another machine.
#[test]
fn sides_of_different_kinds_are_bound_together() {
    let protocol = area("mediator");
    let flag = |name| protocol.flag(name).unwrap();
    let mut model = NetModel::new("gate");
    model.place("free").mark("free");
    for robot in ["near", "far"] {
        let [asked, granted, left, inside] =
            ["asked", "granted", "left", "inside"].map(|what| format!("{robot} {what}"));
        model.source(&asked, Binding::flag(robot, "request"));
        model.sink(&granted, Binding::flag(robot, "granted"));
        model.source(&left, Binding::flag(robot, "released"));
        model.place(&inside);
        let inside = [inside.as_str()];
        model.transition(
            format!("{robot} enters"),
            &[&asked, "free"],
            &[&granted, inside[0]],
        );
        model.transition(format!("{robot} leaves"), &[&left, inside[0]], &["free"]);
    }
    model.end("idle", &["free"]);
    let uses = ["near", "far"].map(|name| Use::new(name, Arc::clone(&protocol), Party::Second));
    let proof = check(&model, &uses, &Limits::default()).unwrap();
    let (net, _) = compile(&model);

    let (mut near, end) = channel(&protocol);
    let mut far = Replica::new(&protocol, 1, Party::First, 0);
    let replica = Replica::new(&protocol, 1, Party::Second, 0);
    let sides = [("near", AnySide::from(end)), ("far", replica.into())];
    let mut gate = NetBinding::new(&proof, &net, sides).unwrap();
    assert!(gate.side_mut("near").unwrap().replica_mut().is_none());
    near.set(flag("request")).unwrap();
    far.set(flag("request")).unwrap();
    let other = gate.side_mut("far").unwrap().replica_mut().unwrap();
    other.merge(far.level()).unwrap();
    let progress = gate.step(Budget::default(), |_| true);
    assert_eq!((progress.read, progress.set), (2, 1));
    assert_eq!(near.poll(), Some(Change::Flag(flag("granted"))));
    near.set(flag("released")).unwrap();
    let granted = std::iter::repeat_with(|| gate.step(Budget::default(), |_| true).set);
    assert_eq!(
        granted.take(2).sum::<u32>(),
        1,
        "now it is free for the far one"
    );
    let other = gate.side_mut("far").unwrap().replica_mut().unwrap();
    far.merge(other.level()).unwrap();
    assert_eq!(far.poll(), Some(Change::Flag(flag("granted"))));
    assert!(gate.is_proved_by(&proof));
    assert_eq!(gate.abort(), Ok(()), "it keeps both");
    assert_eq!(near.poll(), None, "its run was over");
    let other = gate.side_mut("far").unwrap().replica_mut().unwrap();
    far.merge(other.level()).unwrap();
    assert_eq!(far.poll(), Some(Change::Aborted));

    // Any kind of side behind a pointer is one.
    let sides: [Box<dyn Side + '_>; 2] = [Box::new(&mut near), Box::new(far)];
    for mut side in sides {
        assert_eq!(
            (side.party(), side.read_to()),
            (Party::First, Position::START)
        );
        assert_eq!(side.protocol().name(), "area");
        assert_eq!((side.peek(), Side::poll(&mut side)), (None, None));
        assert_eq!(Side::abort(&mut side), Err(AbortError::NotKeeper));
        assert_eq!(Side::set(&mut side, flag("request")), Ok(()));
    }
}

/// Neither may a side be exchanged for one that the proof does not know, nor may somebody else set its flags.
#[test]
fn a_net_stands_still_while_a_side_does_not_fit() {
    let protocol = area("mediator");
    let flag = |name| protocol.flag(name).unwrap();
    let replica = |protocol: &Arc<Protocol>, party| Replica::new(protocol, 1, party, 0);
    let mut longer = ProtocolModel::new("area", "robot", "mediator");
    let mut flags = vec![("request", "robot"), ("more", "robot"), ("most", "robot")];
    flags.extend([("granted", "mediator"), ("released", "robot")]);
    longer.keeper("mediator").array("pass", &flags);
    let longer = Arc::new(longer.compile().unwrap());

    let mut robot = replica(&protocol, Party::First);
    let own = replica(&protocol, Party::Second);
    let mut gate =
        NetBinding::unproved(&compile(&gate_model()).0, [("robot", own.clone())]).unwrap();
    robot.set(flag("request")).unwrap();
    let mut other_robot = replica(&longer, Party::First);
    for name in ["request", "more", "most"] {
        other_robot.set(longer.flag(name).unwrap()).unwrap();
    }
    let mut other = replica(&longer, Party::Second);
    other.merge(other_robot.level()).unwrap();
    let mut read = own.clone();
    read.merge(robot.level()).unwrap();
    read.poll().unwrap();
    let others = [other, replica(&protocol, Party::First), read];
    for (other, stays) in others.into_iter().zip([true, true, false]) {
        gate.sides_mut()[0] = other;
        let progress = gate.step(Budget::default(), |_| true);
        assert_eq!((progress.read, progress.evaluation.fired), (0, 0));
        assert_eq!(gate.misfits().collect::<Vec<_>>(), ["robot"]);
        if stays {
            assert_eq!(gate.abort(), Err(AbortError::OtherSide));
        }
    }
    *gate.side_mut("robot").unwrap() = own;
    assert_eq!(gate.misfits().count(), 0);
    gate.sides_mut()[0].merge(robot.level()).unwrap();
    let progress = gate.step(Budget::default(), |_| true);
    assert_eq!((progress.read, progress.set), (1, 1));
    // An abort brings the net and all sides back to the beginning.
    gate.sides_mut()[0].restart(7).unwrap();
    assert_eq!(gate.misfits().collect::<Vec<_>>(), ["robot"]);
    assert_eq!(gate.abort(), Ok(()));
    assert_eq!(gate.misfits().count(), 0);
}
