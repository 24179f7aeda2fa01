//! The two ends of a channel, one call after the other.

use coordination::protocol::{
    AbortError, Change, FlagId, Position, SetError, Side, channel, channel_at,
};

use super::common::{crossing, flag};

#[test]
fn a_run_goes_from_the_first_flag_to_an_empty_array() {
    let protocol = crossing();
    let (mut robot, mut mediator) = channel(&protocol);
    let f = |name| flag(&protocol, name);
    for run in 0..3 {
        assert_eq!((robot.run(), mediator.run()), (run, run));
        robot.set(f("request")).unwrap();
        assert_eq!(mediator.peek(), Some(Change::Flag(f("request"))));
        assert_eq!(mediator.poll(), Some(Change::Flag(f("request"))));
        assert_eq!(mediator.poll(), None);
        mediator.set(f("granted")).unwrap();
        assert_eq!(robot.poll(), Some(Change::Flag(f("granted"))));
        robot.set(f("entered")).unwrap();
        robot.set(f("released")).unwrap();
        assert_eq!(robot.set(f("request")), Err(SetError::Complete));
        assert_eq!(mediator.poll(), Some(Change::Flag(f("entered"))));
        assert_eq!(robot.set(f("request")), Err(SetError::Complete));
        assert_eq!(mediator.poll(), Some(Change::Flag(f("released"))));
        assert_eq!((mediator.poll(), robot.poll()), (None, None));
        assert_eq!(mediator.position(), Position::START);
    }
}

#[test]
fn what_is_not_allowed_changes_nothing_and_says_why() {
    let protocol = crossing();
    let (mut robot, mut mediator) = channel(&protocol);
    let f = |name| flag(&protocol, name);
    let refuse = |side: &mut dyn Side, flag: FlagId, expected: &str| {
        let error = side.set(flag).unwrap_err();
        assert_eq!(
            error.describe(&protocol),
            format!("protocol `crossing`: {expected}")
        );
    };
    refuse(
        &mut robot,
        f("granted"),
        "flag `granted` belongs to `mediator`",
    );
    refuse(
        &mut robot,
        f("entered"),
        "flag `entered` is out of order: expected `request` after nothing set",
    );
    refuse(
        &mut mediator,
        f("granted"),
        "flag `granted` is out of order: expected `request` after nothing set",
    );
    refuse(&mut robot, FlagId(99), "the protocol has no flag number 99");
    assert_eq!(robot.level(0), channel(&protocol).0.level(0));

    robot.set(f("request")).unwrap();
    let level = robot.level(0);
    refuse(
        &mut mediator,
        f("granted"),
        "flag `request` has not been read",
    );
    refuse(
        &mut robot,
        f("request"),
        "flag `request` is out of order: expected `granted` or `refused` after request",
    );
    assert_eq!(robot.level(0), level);
    mediator.poll();
    mediator.set(f("refused")).unwrap();
    refuse(&mut robot, f("request"), "flag `refused` has not been read");
    refuse(
        &mut mediator,
        f("granted"),
        "the run is complete and the other party has not read its last flag",
    );
    robot.poll();
    robot.set(f("request")).unwrap();
}

#[test]
fn the_keeper_aborts_and_nobody_else() {
    let protocol = crossing();
    let (mut robot, mut mediator) = channel(&protocol);
    let f = |name| flag(&protocol, name);
    assert_eq!(robot.abort(), Err(AbortError::NotKeeper));
    assert_eq!(mediator.abort(), Ok(Position::START), "nothing to abort");
    assert_eq!(mediator.run(), 0);

    robot.set(f("request")).unwrap();
    assert_eq!(mediator.abort().map(|cut| protocol.progress(cut)), Ok(1));
    assert_eq!(mediator.poll(), None, "the cut off request is void");
    assert_eq!(robot.set(f("request")), Err(SetError::Aborted));
    assert_eq!(robot.peek(), Some(Change::Aborted));
    assert_eq!((robot.poll(), robot.poll()), (Some(Change::Aborted), None));
    assert!(robot.level(0).after_abort);

    robot.set(f("request")).unwrap();
    mediator.poll();
    mediator.set(f("granted")).unwrap();
    mediator.abort().unwrap();
    assert_eq!((robot.poll(), robot.poll()), (Some(Change::Aborted), None));
    assert_eq!(robot.run(), 2);

    robot.set(f("request")).unwrap();
    mediator.poll();
    mediator.set(f("refused")).unwrap();
    mediator.abort().unwrap();
    assert_eq!((robot.poll(), robot.poll()), (Some(Change::Aborted), None));
    robot.set(f("request")).unwrap();
    assert_eq!(mediator.poll(), Some(Change::Flag(f("request"))));
    assert_eq!(mediator.poll(), None);
}

#[test]
fn several_aborts_between_two_polls_read_as_one() {
    let mut model = coordination::protocol::ProtocolModel::new("p", "a", "b");
    model.array("only", &[("x", "a"), ("y", "b")]).keeper("a");
    let protocol = std::sync::Arc::new(model.compile().unwrap());
    let (mut a, mut b) = channel(&protocol);
    for _ in 0..3 {
        a.set(flag(&protocol, "x")).unwrap();
        a.abort().unwrap();
    }
    a.set(flag(&protocol, "x")).unwrap();
    assert_eq!(b.poll(), Some(Change::Aborted));
    assert_eq!(b.poll(), Some(Change::Flag(flag(&protocol, "x"))));
    assert_eq!((b.poll(), b.run()), (None, 3));
    b.set(flag(&protocol, "y")).unwrap();
}

#[test]
fn run_numbers_end_and_do_not_wrap() {
    let protocol = crossing();
    let (mut robot, mut mediator) = channel_at(&protocol, u32::MAX - 1);
    let f = |name| flag(&protocol, name);
    for _ in 0..2 {
        robot.set(f("request")).unwrap();
        mediator.poll();
        mediator.set(f("refused")).unwrap();
        assert_eq!(robot.poll(), Some(Change::Flag(f("refused"))));
    }
    assert_eq!(robot.poll(), None);
    for _ in 0..2 {
        assert_eq!(robot.set(f("request")), Err(SetError::Exhausted));
    }
    assert_eq!(mediator.abort(), Err(AbortError::Exhausted));
    assert_eq!((mediator.poll(), mediator.run()), (None, u32::MAX));
}

#[test]
fn an_end_knows_when_the_other_is_gone() {
    let (robot, mediator) = channel(&crossing());
    assert!(!mediator.is_abandoned());
    drop(robot);
    assert!(mediator.is_abandoned());
}
