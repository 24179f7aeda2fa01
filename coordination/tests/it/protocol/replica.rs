//! Replicas and the levels that they exchange, one call after the other.

use std::sync::Arc;

use coordination::protocol::{
    AbortError, Change, Level, MergeError, Merged, Party, Protocol, Replica, SetError, Side,
};

use super::common::{crossing, flag};

const ID: u16 = 7;

fn pair(protocol: &Arc<Protocol>) -> (Replica, Replica) {
    let side = |party| Replica::new(protocol, ID, party, 10);
    (side(Party::First), side(Party::Second))
}

fn read(replica: &mut Replica) -> Vec<String> {
    let changes: Vec<_> = std::iter::from_fn(|| replica.poll()).collect();
    let name = |change| match change {
        Change::Flag(flag) => replica.protocol().flag_name(flag).to_owned(),
        Change::Aborted => "aborted".to_owned(),
    };
    changes.into_iter().map(name).collect()
}

#[test]
fn a_lost_level_is_made_up_for_by_the_next() {
    let protocol = crossing();
    let (mut robot, mut mediator) = pair(&protocol);
    let f = |name| flag(&protocol, name);
    robot.set(f("request")).unwrap();
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Risen));
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Nothing));
    assert_eq!(
        mediator.set(f("granted")),
        Err(SetError::Unread {
            unread: f("request")
        })
    );
    assert_eq!(read(&mut mediator), ["request"]);
    let early = mediator.level();
    mediator.set(f("granted")).unwrap();
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Risen));
    assert_eq!(robot.merge(early), Ok(Merged::Nothing));
    assert_eq!(read(&mut robot), ["granted"]);
    robot.set(f("entered")).unwrap();
    robot.set(f("released")).unwrap();
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Risen));
    assert_eq!(robot.set(f("request")), Err(SetError::Complete));
    assert_eq!(read(&mut mediator), ["entered", "released"]);
    assert_eq!(mediator.level().run, 11);
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Risen));
    assert_eq!(read(&mut robot), [""; 0]);
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Nothing));
    robot.set(f("request")).unwrap();
    let expected = Level {
        protocol: ID,
        run: 11,
        path: 0,
        progress: 1,
        after_abort: false,
    };
    assert_eq!(robot.level(), expected);
}

#[test]
fn a_level_that_cannot_be_is_refused() {
    let protocol = crossing();
    let (mut robot, mut mediator) = pair(&protocol);
    let f = |name| flag(&protocol, name);
    let level = |run, path, progress| Level {
        protocol: ID,
        run,
        path,
        progress,
        after_abort: false,
    };
    let refuse = |replica: &mut Replica, level: Level, expected: MergeError| {
        let before = (replica.level(), replica.peek());
        assert_eq!(replica.merge(level), Err(expected));
        assert_eq!((replica.level(), replica.peek()), before);
    };
    let other = Level {
        protocol: 8,
        ..level(10, 0, 0)
    };
    refuse(
        &mut robot,
        other,
        MergeError::OtherProtocol {
            expected: ID,
            found: 8,
        },
    );
    for (path, progress) in [(0, 5), (1, 3), (2, 0), (u16::MAX, u16::MAX)] {
        let error = MergeError::NoSuchPosition { path, progress };
        refuse(&mut robot, level(10, path, progress), error);
    }
    let mine = MergeError::ClaimsMine { flag: f("request") };
    refuse(&mut robot, level(10, 0, 1), mine);
    refuse(&mut robot, level(10, 0, 2), mine);
    let skipped = MergeError::ClaimsMine { flag: f("granted") };
    refuse(&mut mediator, level(10, 0, 3), skipped);
    let future = |found| MergeError::UnexpectedRun { present: 10, found };
    refuse(&mut robot, level(11, 0, 0), future(11));
    refuse(&mut robot, level(u32::MAX, 0, 0), future(u32::MAX));
    let abort = Level {
        after_abort: true,
        ..level(11, 0, 0)
    };
    refuse(&mut mediator, abort, future(11));
    let with_mine = Level {
        after_abort: true,
        ..level(11, 0, 1)
    };
    refuse(&mut robot, with_mine, mine);

    robot.set(f("request")).unwrap();
    mediator.merge(robot.level()).unwrap();
    mediator.poll();
    mediator.set(f("refused")).unwrap();
    robot.merge(mediator.level()).unwrap();
    let path = MergeError::OtherPath {
        path: 0,
        mine: robot.position(),
    };
    refuse(&mut robot, level(10, 0, 2), path);
    refuse(&mut mediator, level(12, 0, 0), future(12));
    refuse(
        &mut mediator,
        level(11, 1, 2),
        MergeError::ClaimsMine { flag: f("refused") },
    );
}

#[test]
fn an_abort_reaches_the_other_side_and_old_levels_do_not_undo_it() {
    let protocol = crossing();
    let (mut robot, mut mediator) = pair(&protocol);
    let f = |name| flag(&protocol, name);
    assert_eq!(robot.abort(), Err(AbortError::NotKeeper));
    robot.set(f("request")).unwrap();
    let request = robot.level();
    mediator.merge(request).unwrap();
    mediator.poll();
    mediator.set(f("granted")).unwrap();
    let granted = mediator.level();
    assert_eq!(mediator.abort().map(|cut| protocol.progress(cut)), Ok(2));
    assert_eq!(mediator.merge(request), Ok(Merged::Nothing));
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Aborted));
    assert_eq!(robot.merge(granted), Ok(Merged::Nothing));
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Nothing));
    assert_eq!(robot.set(f("request")), Err(SetError::Aborted));
    assert_eq!(read(&mut robot), ["aborted"]);
    robot.set(f("request")).unwrap();
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Risen));
    assert_eq!(read(&mut mediator), ["request"]);
}

/// The robot has set its last flag and the keeper, which never heard of it, gives up the run: that
/// must not look as if the last flag had arrived.
#[test]
fn an_abort_is_not_taken_for_the_end() {
    let protocol = crossing();
    let (mut robot, mut mediator) = pair(&protocol);
    let f = |name| flag(&protocol, name);
    robot.set(f("request")).unwrap();
    mediator.merge(robot.level()).unwrap();
    mediator.poll();
    mediator.set(f("granted")).unwrap();
    robot.merge(mediator.level()).unwrap();
    robot.poll();
    robot.set(f("entered")).unwrap();
    robot.set(f("released")).unwrap();
    mediator.abort().unwrap();
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Aborted));
    assert_eq!(read(&mut robot), ["aborted"]);
}

#[test]
fn a_side_restarts_in_a_run_that_it_is_told() {
    let protocol = crossing();
    let (mut robot, mut mediator) = pair(&protocol);
    let f = |name| flag(&protocol, name);
    robot.set(f("request")).unwrap();
    let past = robot.level();

    // The robot's program starts again; the mediator, at registration, tells it run 11.
    let error = mediator.restart(10).unwrap_err();
    assert_eq!(error.to_string(), "run 10 is not later than run 10");
    mediator.restart(11).unwrap();
    let mut robot = Replica::new(&protocol, ID, Party::First, 11);
    assert_eq!(mediator.merge(past), Ok(Merged::Nothing));
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Nothing));
    robot.set(f("request")).unwrap();
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Risen));
    assert_eq!(read(&mut mediator), ["request"]);

    // The mediator starts again from its journal, or from what the robot reports.
    let mut mediator = Replica::resume(&protocol, Party::Second, mediator.level()).unwrap();
    assert_eq!(read(&mut mediator), [""; 0]);
    mediator.set(f("granted")).unwrap();
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Risen));

    // A mediator that lost everything finds out and numbers on.
    let mut mediator = Replica::new(&protocol, ID, Party::Second, 0);
    let found = robot.run();
    let error = mediator.merge(robot.level()).unwrap_err();
    assert_eq!(error, MergeError::UnexpectedRun { present: 0, found });
    mediator.restart(found + 1).unwrap();
    assert_eq!(robot.merge(mediator.level()), Ok(Merged::Aborted));
    assert_eq!(read(&mut robot), ["aborted"]);
    robot.set(f("request")).unwrap();
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Risen));
}

#[test]
fn a_side_resumes_at_the_end_it_has_read() {
    let protocol = crossing();
    let level = |path, progress| Level {
        protocol: ID,
        run: 3,
        path,
        progress,
        after_abort: false,
    };
    let robot = Replica::resume(&protocol, Party::First, level(1, 2)).unwrap();
    assert_eq!(
        (robot.run(), robot.peek()),
        (4, None),
        "the reader empties the array"
    );
    let mut mediator = Replica::resume(&protocol, Party::Second, level(1, 2)).unwrap();
    assert_eq!(mediator.run(), 3);
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Risen));
    assert_eq!(mediator.level(), robot.level());
    let error = MergeError::NoSuchPosition {
        path: 9,
        progress: 2,
    };
    let refused = Replica::resume(&protocol, Party::First, level(9, 2));
    assert_eq!(refused.err(), Some(error));
}

#[test]
fn run_numbers_end_and_do_not_wrap() {
    let protocol = crossing();
    let f = |name| flag(&protocol, name);
    let mut robot = Replica::new(&protocol, ID, Party::First, u32::MAX);
    let mut mediator = Replica::new(&protocol, ID, Party::Second, u32::MAX);
    robot.set(f("request")).unwrap();
    mediator.merge(robot.level()).unwrap();
    mediator.poll();
    assert_eq!(mediator.abort(), Err(AbortError::Exhausted));
    mediator.set(f("refused")).unwrap();
    robot.merge(mediator.level()).unwrap();
    assert_eq!(read(&mut robot), ["refused"]);
    assert_eq!(robot.set(f("request")), Err(SetError::Exhausted));
    assert_eq!(mediator.merge(robot.level()), Ok(Merged::Nothing));
    assert_eq!(mediator.set(f("refused")), Err(SetError::Exhausted));
    let old = Level {
        run: 0,
        ..robot.level()
    };
    assert_eq!(mediator.merge(old), Ok(Merged::Nothing));
}
