//! The protocols that robots and mediator run, as flag arrays.
//!
//! [`access`] and [`revocation`] are the same for every robot and area. [`control_paths`] is made for each coordination from the
//! flags of its net's file, which the mediator sends along, so that a robot needs to know no net.

use std::collections::BTreeMap;

use coordination::protocol::{ModelError, Protocol, ProtocolModel};

/// The robot's side of every protocol: its first party.
pub const ROBOT: &str = "robot";
/// The mediator's side of every protocol: its second party, and the keeper, who may give up a run.
pub const MEDIATOR: &str = "mediator";

/// The robot asks for an area.
pub const REQUEST: &str = "request";
/// The mediator gives it; the grant's fence goes with it.
pub const GRANTED: &str = "granted";
/// The robot reaches into it.
pub const ENTERED: &str = "entered";
/// The robot has left it.
pub const RELEASED: &str = "released";
/// The robot gives it back without having entered.
pub const RETURNED: &str = "returned";

/// The mediator asks for a granted area back.
pub const REVOKE: &str = "revoke";
/// The robot gives it back; [`RETURNED`] follows in the access protocol.
pub const YIELDED: &str = "yielded";
/// The robot keeps it: it has entered, or can no longer stop before it.
pub const KEPT: &str = "kept";

/// The mediator takes over the discrete control of the robot.
pub const ACQUIRE: &str = "acquire";
/// The robot has handed it over.
pub const ACQUIRED: &str = "acquired";
/// The mediator gives it back.
pub const RELEASE: &str = "release";

/// Protocol 1: request, granted, then entered and released, or returned.
#[must_use]
pub fn access() -> Protocol {
    let mut model = model("access");
    model
        .array("ask", &[(REQUEST, ROBOT), (GRANTED, MEDIATOR)])
        .array("pass", &[(ENTERED, ROBOT), (RELEASED, ROBOT)])
        .array("return", &[(RETURNED, ROBOT)])
        .follow("ask", "pass")
        .follow("ask", "return");
    compiled(&model)
}

/// Taking a grant back: revoke, then yielded or kept.
#[must_use]
pub fn revocation() -> Protocol {
    let mut model = model("revocation");
    model
        .array("ask", &[(REVOKE, MEDIATOR)])
        .array("yield", &[(YIELDED, ROBOT)])
        .array("keep", &[(KEPT, ROBOT)])
        .follow("ask", "yield")
        .follow("ask", "keep");
    compiled(&model)
}

/// Protocol 2 of a coordination without alternatives: acquire, acquired, then `steps` (a flag, and whether it is the
/// mediator's), then release and released.
///
/// # Errors
/// [`ControlError`] when a flag is empty, is listed twice, or has the name of one of those four.
pub fn control<'a>(
    steps: impl IntoIterator<Item = (&'a str, bool)>,
) -> Result<Protocol, ControlError> {
    let mut flags = vec![(ACQUIRE, true), (ACQUIRED, false)];
    flags.extend(steps);
    flags.extend([(RELEASE, true), (RELEASED, false)]);
    control_paths(&flags, &[])
}

/// Protocol 2 as a message gives it: flags, each with whether it is the mediator's, and paths of flags by number. No path
/// means one of all flags in their order.
///
/// # Errors
/// [`ControlError`] when flags or paths make no protocol.
pub fn control_paths(
    flags: &[(&str, bool)],
    paths: &[Vec<usize>],
) -> Result<Protocol, ControlError> {
    let all = [(0..flags.len()).collect()];
    let paths = if paths.is_empty() { &all } else { paths };
    // Paths that begin alike share a position; each position is an array of one flag.
    let mut begins: BTreeMap<&[usize], usize> = BTreeMap::new();
    let mut model = model("control");
    for (number, path) in paths.iter().enumerate() {
        for end in 1..=path.len() {
            let flag = path[end - 1];
            let &(name, by_mediator) = flags.get(flag).ok_or(ControlError::NoSuchFlag {
                path: number,
                found: flag,
                flags: flags.len(),
            })?;
            if begins.contains_key(&path[..end]) {
                continue;
            }
            let array = begins.len().to_string();
            let party = if by_mediator { MEDIATOR } else { ROBOT };
            model.array(&array, &[(name, party)]);
            match begins.get(&path[..end - 1]) {
                Some(before) => model.follow(before.to_string(), &array),
                None => model.start(&array),
            };
            begins.insert(&path[..end], begins.len());
        }
    }
    let protocol = model.compile()?;
    // Both sides must number the paths alike.
    for (number, path) in paths.iter().enumerate() {
        let end = u16::try_from(path.len()).ok();
        let end = end.and_then(|end| protocol.position(number.try_into().ok()?, end));
        let same = end.is_some_and(|end| {
            protocol.is_end(end)
                && path.iter().map(|&flag| flags[flag].0).eq(protocol
                    .set_flags(end)
                    .map(|(flag, _)| protocol.flag_name(flag)))
        });
        if !same {
            return Err(ControlError::Order { path: number });
        }
    }
    Ok(protocol)
}

/// Flags and paths that make no protocol.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ControlError {
    /// A path names a flag that is not there.
    #[error("path {path} names flag {found}, and there are {flags}, numbered from 0")]
    NoSuchFlag {
        /// Which path.
        path: usize,
        /// As found.
        found: usize,
        /// How many there are.
        flags: usize,
    },
    /// Paths that begin alike must stand together, each once, and none may be the beginning of another.
    #[error(
        "path {path} is not where it belongs: paths that begin alike stand together, each once"
    )]
    Order {
        /// Which path.
        path: usize,
    },
    /// What protocols in general must keep.
    #[error(transparent)]
    Model(#[from] ModelError),
}

fn model(name: &str) -> ProtocolModel {
    let mut model = ProtocolModel::new(name, ROBOT, MEDIATOR);
    model.keeper(MEDIATOR);
    model
}

fn compiled(model: &ProtocolModel) -> Protocol {
    model
        .compile()
        .expect("the contract's own arrays are consistent; a test compiles them")
}

#[cfg(test)]
mod tests {
    use super::*;
    use coordination::protocol::Position;

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

    #[test]
    fn alternatives_keep_their_numbers() {
        let flags = [
            ("acquire", true),
            ("acquired", false),
            ("e5", true),
            ("e1", true),
            ("done", false),
        ];
        let protocol =
            control_paths(&flags, &[vec![0, 1, 2, 3, 4], vec![0, 1, 3, 4]]).expect("valid");
        assert_eq!(
            path(&protocol, 0),
            ["acquire", "acquired", "e5", "e1", "done"]
        );
        assert_eq!(path(&protocol, 1), ["acquire", "acquired", "e1", "done"]);
    }

    #[test]
    fn paths_that_cannot_be_are_refused() {
        let flags = [("a", true), ("b", false), ("c", false)];
        let refused = |paths: &[Vec<usize>]| control_paths(&flags, paths).expect_err("refused");
        let unknown = refused(&[vec![0, 3]]);
        assert_eq!(
            unknown.to_string(),
            "path 0 names flag 3, and there are 3, numbered from 0"
        );
        assert_eq!(
            refused(&[vec![0, 1], vec![0, 1]]),
            ControlError::Order { path: 1 }
        );
        assert_eq!(
            refused(&[vec![0, 1, 2], vec![0, 1]]),
            ControlError::Order { path: 1 }
        );
        assert!(matches!(refused(&[vec![]]), ControlError::Model(_)));
        assert!(matches!(refused(&[vec![0, 0]]), ControlError::Model(_)));
        assert!(control_paths(&[], &[]).is_err());
    }
}
