use super::*;
use crate::wire::{ControlFlag, ControlPath};
use coordination::protocol::{Position, Protocol, ProtocolModel};

/// All flags of path `path`, in their order.
fn path(protocol: &Protocol, path: u16) -> Vec<&str> {
    let mut at = Position::START;
    let mut flags = Vec::new();
    for progress in 1.. {
        let Some(next) = protocol.position(path, progress) else {
            break;
        };
        let (flag, _) = protocol.towards(at, next).expect("one flag further");
        flags.push(protocol.flag_name(flag));
        at = next;
    }
    assert!(protocol.is_end(at));
    flags
}

// PROTOCOL.md numbers the paths like this: other vendors rely on it.
#[test]
fn paths_are_numbered_as_the_contract_says() {
    let access = access();
    assert_eq!(access.paths(), 2);
    assert_eq!(path(&access, 0), [REQUEST, GRANTED, ENTERED, RELEASED]);
    assert_eq!(path(&access, 1), [REQUEST, GRANTED, RETURNED]);
    let revocation = revocation();
    assert_eq!(revocation.paths(), 2);
    assert_eq!(path(&revocation, 0), [REVOKE, YIELDED]);
    assert_eq!(path(&revocation, 1), [REVOKE, KEPT]);
}

// Robots of before spoke these arrays, and the pattern must make the same of them.
#[test]
fn instances_of_the_pattern_are_the_contracts_arrays() {
    let model = |name| {
        let mut model = ProtocolModel::new(name, ROBOT, MEDIATOR);
        model.keeper(MEDIATOR);
        model
    };
    let mut arrays = model("access");
    arrays
        .array("ask", &[(REQUEST, ROBOT), (GRANTED, MEDIATOR)])
        .array("pass", &[(ENTERED, ROBOT), (RELEASED, ROBOT)])
        .array("return", &[(RETURNED, ROBOT)])
        .follow("ask", "pass")
        .follow("ask", "return");
    assert_eq!(arrays.compile(), Ok(access()));
    let mut arrays = model("revocation");
    arrays
        .array("ask", &[(REVOKE, MEDIATOR)])
        .array("yield", &[(YIELDED, ROBOT)])
        .array("keep", &[(KEPT, ROBOT)])
        .follow("ask", "yield")
        .follow("ask", "keep");
    assert_eq!(arrays.compile(), Ok(revocation()));
    let flags = [
        flag(ACQUIRE, true),
        flag(ACQUIRED, false),
        flag("e1", true),
        flag("done1", false),
        flag(RELEASE, true),
        flag(RELEASED, false),
    ];
    let steps = [("e1", true), ("done1", false)];
    assert_eq!(control_paths(&flags, &[]), control(steps));
}

#[test]
fn control_wraps_the_steps_of_a_net() {
    let control = control([("e1", true), ("done1", false)]).expect("valid");
    assert_eq!(control.paths(), 1);
    assert_eq!(
        path(&control, 0),
        [ACQUIRE, ACQUIRED, "e1", "done1", RELEASE, RELEASED]
    );
}

#[test]
fn a_flag_twice_is_refused_by_name() {
    let twice = control([("e1", true), ("done1", false), ("e1", true)]).expect_err("twice");
    assert!(twice.to_string().contains("e1"), "{twice}");
    let reserved = control([(RELEASED, false)]).expect_err("reserved");
    assert!(reserved.to_string().contains(RELEASED), "{reserved}");
}

fn flag(name: &str, by_mediator: bool) -> ControlFlag {
    ControlFlag {
        name: name.into(),
        by_mediator,
        ..ControlFlag::default()
    }
}

fn paths<const N: usize>(paths: [&[u32]; N]) -> [ControlPath; N] {
    paths.map(|flags| ControlPath {
        flags: flags.to_vec(),
    })
}

#[test]
fn alternatives_keep_their_numbers() {
    let flags = [
        flag("acquire", true),
        flag("acquired", false),
        flag("e5", true),
        flag("e1", true),
        flag("done", false),
    ];
    let alternatives = paths([&[0, 1, 2, 3, 4], &[0, 1, 3, 4]]);
    let protocol = control_paths(&flags, &alternatives).expect("valid");
    assert_eq!(
        path(&protocol, 0),
        ["acquire", "acquired", "e5", "e1", "done"]
    );
    assert_eq!(path(&protocol, 1), ["acquire", "acquired", "e1", "done"]);
    let (flags, alternatives) = flags_and_paths(&protocol);
    assert_eq!(control_paths(&flags, &alternatives), Ok(protocol));
}

#[test]
fn paths_that_cannot_be_are_refused() {
    let flags = [flag("a", true), flag("b", false), flag("c", false)];
    let refused = |paths: &[ControlPath]| control_paths(&flags, paths).expect_err("refused");
    let unknown = refused(&paths([&[0, 3]]));
    assert_eq!(
        unknown.to_string(),
        "path 0 names flag 3, and there are 3, numbered from 0"
    );
    assert_eq!(
        refused(&paths([&[0, 1], &[0, 1]])),
        ControlError::Order { path: 1 }
    );
    assert_eq!(
        refused(&paths([&[0, 1, 2], &[0, 1]])),
        ControlError::Order { path: 1 }
    );
    assert!(matches!(refused(&paths([&[]])), ControlError::Model(_)));
    assert!(matches!(refused(&paths([&[0, 0]])), ControlError::Model(_)));
    assert!(control_paths(&[], &[]).is_err());
}

#[test]
fn lookups_find_their_flags_and_parties() {
    for protocol in [access(), revocation(), control([]).expect("valid")] {
        assert_eq!(protocol.party(ROBOT), Some(ROBOT_PARTY));
        assert_eq!(protocol.party(MEDIATOR), Some(MEDIATOR_PARTY));
    }
    let access = AccessProtocol::new();
    assert!(access.is_held(access.granted_at) && access.is_held(access.entered_at));
    assert!(!access.is_held(Position::START));
    let revocation = RevocationProtocol::new();
    assert_ne!(revocation.yielded, revocation.kept);
}
