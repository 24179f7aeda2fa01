//! A net file as plain data.

use std::collections::BTreeMap;
use std::sync::Arc;

use ::coordination::petri::{Binding, PlaceKind};
use ::coordination::protocol::Protocol;

use crate::origin::Origin;
use description::geometry::Pose2;

/// The mediator's name as a party of protocols; no role may have it.
pub const MEDIATOR: &str = "mediator";

/// A coordination.
///
/// The protocol of role `R` is in use under the name `R`, between the parties `R` and
/// [`MEDIATOR`]; its flags are the events `R.<flag>`.
#[derive(Clone, Debug)]
pub struct NetConfig {
    /// The net's name.
    pub name: String,
    /// What it is for.
    pub about: Option<String>,
    /// Who takes part, besides the mediator.
    pub roles: Vec<NetRole>,
    /// In which order flags are set.
    pub protocols: Vec<NetProtocol>,
    /// Internal places, then sources, then sinks; each group in the order of the file.
    pub places: Vec<NetPlace>,
    /// Transitions, in the order of the file: the order in which they are tried.
    pub transitions: Vec<NetTransition>,
    /// Sets of places of which at most one may be marked.
    pub exclusions: Vec<NetSet>,
    /// Markings of internal places in which the coordination may end.
    pub ends: Vec<NetSet>,
    /// Markings of internal places in which it may begin; at least one.
    pub situations: Vec<NetSituation>,
    /// The net may fire for ever by itself, without any flag of a robot.
    pub endless: bool,
    /// Where each value was written.
    pub origin: Origin,
    /// By role.
    pub(crate) compiled: BTreeMap<String, Arc<Protocol>>,
}

/// `[roles.<id>]`: a part that one robot plays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetRole {
    /// Unique among roles.
    pub id: String,
    /// The protocol between it and the mediator.
    pub protocol: String,
    /// What it is.
    pub about: Option<String>,
}

description::words! {
    /// Who may set a flag.
    pub enum NetParty {
        /// The robot in the role that has the protocol.
        Robot "robot",
        /// The mediator.
        Mediator "mediator",
    }
}

/// `[protocols.<id>]`: flags in order, in one array or in several that make alternatives.
#[derive(Clone, Debug, PartialEq)]
pub struct NetProtocol {
    /// Unique among protocols.
    pub id: String,
    /// Who may give up a run; without a keeper nobody.
    pub keeper: Option<NetParty>,
    /// The arrays that a run can begin with; empty means the first.
    pub start: Vec<String>,
    /// The arrays.
    pub arrays: Vec<NetArray>,
}

/// `[protocols.<id>.arrays.<id>]`
#[derive(Clone, Debug, PartialEq)]
pub struct NetArray {
    /// Unique in the protocol.
    pub id: String,
    /// Its entries.
    pub flags: Vec<NetFlag>,
    /// The arrays that can follow; none: the run ends.
    pub then: Vec<String>,
}

/// One entry of a flag array.
#[derive(Clone, Debug, PartialEq)]
pub struct NetFlag {
    /// The flag.
    pub flag: String,
    /// Who sets it.
    pub by: NetParty,
    /// What the mediator says along with it; empty for a robot's flag.
    pub command: NetCommand,
}

/// What a flag of the mediator's means for the robot, besides being set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetCommand {
    /// The site's areas that the robot may enter: the flag carries their grants.
    pub enters: Vec<String>,
    /// From now on not faster than this.
    pub speed_limit_m_s: Option<f64>,
    /// Drive to this pose in `map` and stop.
    pub stop_pose: Option<Pose2>,
}

/// A place, from `[places]`, `[sources]` or `[sinks]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetPlace {
    /// Unique among places and transitions.
    pub id: String,
    /// Who marks and empties it.
    pub kind: PlaceKind,
    /// What a token in it means; only for internal places.
    pub about: String,
    /// What a source or sink is bound to.
    pub binding: Option<Binding>,
}

/// `[transitions.<id>]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetTransition {
    /// Unique among places and transitions.
    pub id: String,
    /// Places that it takes tokens from.
    pub from: Vec<String>,
    /// Places that it puts tokens into.
    pub to: Vec<String>,
}

/// An entry of `[exclusions]` or `[ends]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetSet {
    /// Its name.
    pub id: String,
    /// Its places.
    pub places: Vec<String>,
}

/// `[situations.<id>]`: where a coordination begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetSituation {
    /// Unique among situations.
    pub id: String,
    /// When it is the right one.
    pub about: Option<String>,
    /// The internal places that are marked.
    pub marked: Vec<String>,
}
