//! The protocols that robots and mediator run, as flag arrays.
//!
//! [`access`] and [`revocation`] are the same for every robot and area. [`control`] is made for each coordination from the
//! flags of its net's file, which the mediator sends along, so that a robot needs to know no net.

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

/// Protocol 2: acquire, acquired, then the `steps` of a coordination (a flag, and whether it is the mediator's), then
/// release and released.
///
/// # Errors
/// [`ModelError`] when a flag is empty, is listed twice, or has the name of one of those four.
pub fn control<'a>(
    steps: impl IntoIterator<Item = (&'a str, bool)>,
) -> Result<Protocol, ModelError> {
    let party = |by_mediator| if by_mediator { MEDIATOR } else { ROBOT };
    let mut flags = vec![(ACQUIRE, MEDIATOR), (ACQUIRED, ROBOT)];
    flags.extend(
        steps
            .into_iter()
            .map(|(flag, by_mediator)| (flag, party(by_mediator))),
    );
    flags.extend([(RELEASE, MEDIATOR), (RELEASED, ROBOT)]);
    let mut model = model("control");
    model.array("run", &flags);
    model.compile()
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
}
