//! Names of parties and flags.

use coordination::protocol::Party;

/// The robot's side of every protocol: its first party.
pub const ROBOT: &str = "robot";
/// The mediator's side of every protocol: its second party, and the keeper, who may give up a run.
pub const MEDIATOR: &str = "mediator";
/// [`ROBOT`] as a party.
pub const ROBOT_PARTY: Party = Party::First;
/// [`MEDIATOR`] as a party.
pub const MEDIATOR_PARTY: Party = Party::Second;

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
