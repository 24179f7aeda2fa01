//! Sides of different kinds in one binding.

use std::sync::Arc;

use super::area;
use super::net::compile;
use crate::analysis::{Limits, Use, check};
use crate::binding::NetBinding;
use crate::petri::{Binding, Budget, NetModel};
use crate::protocol::{AbortError, AnySide, Change, Party, Position, Replica, Side, channel};

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
