//! A net file as plain data: its keys, each declared once.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use ::coordination::petri::{Binding, PlaceKind};
use ::coordination::protocol::Protocol;

use crate::origin::Origin;
use description::geometry::Pose2;
use description::keys::{
    Id, List, Map, Name, Need, Optional, POSITION, Pose, SPEED, Text, Texts, Truth, Word,
};

/// The mediator's name as a party of protocols; no role may have it.
pub const MEDIATOR: &str = "mediator";

/// What an array of flags holds.
pub(super) const FLAGS: &str = "{ robot = \"<flag>\" } and { mediator = \"<flag>\" }";

/// The rule of places: the tables `[places]`, `[sources]` and `[sinks]`.
pub struct Places;
/// The rule of named sets of places.
pub struct Sets;

/// A coordination.
///
/// The protocol of role `R` is in use under the name `R`, between the parties `R` and
/// [`MEDIATOR`]; its flags are the events `R.<flag>`.
#[derive(Clone, Debug)]
pub struct NetConfig {
    /// What the file says.
    pub file: NetFile,
    /// Where each value was written.
    pub origin: Origin,
    /// By role.
    pub(crate) compiled: BTreeMap<String, Arc<Protocol>>,
}

impl Deref for NetConfig {
    type Target = NetFile;

    fn deref(&self) -> &NetFile {
        &self.file
    }
}

impl DerefMut for NetConfig {
    fn deref_mut(&mut self) -> &mut NetFile {
        &mut self.file
    }
}

description::words! {
    /// What a net file conforms to: the keys that `config/KEYS.md` lists and what they mean. It changes when a file of before would
    /// mean something else.
    pub enum NetMetamodel {
        /// The first.
        V1 "urn:kelo-onboard:net:1",
    }
}

description::section! {
    /// A net file says how robots in roles and the mediator coordinate: the flags that they set, and the Petri net by
    /// which the mediator decides.
    pub struct NetFile {
        /// What the file conforms to; another one is refused.
        pub metamodel: NetMetamodel as Word => NetMetamodel::V1,
        /// The net's name.
        pub name: String as Id("the net's name"),
        /// What it is for.
        pub about: Option<String> as Optional(Text("what the net is for")),
        /// Who takes part, besides the mediator.
        pub roles: Vec<NetRole> as Map("sections [roles.<id>]", Need::Required),
        /// In which order flags are set.
        pub protocols: Vec<NetProtocol> as Map("sections [protocols.<id>]", Need::Required),
        /// Internal places, then sources, then sinks; each group in the order of the file.
        pub places: Vec<NetPlace> as Places,
        /// Transitions, in the order of the file: the order in which they are tried.
        pub transitions: Vec<NetTransition> as Map("sections [transitions.<id>]", Need::Required),
        /// Sets of places of which at most one may be marked.
        pub exclusions: Vec<NetSet> as Sets,
        /// Markings of internal places in which the coordination may end.
        pub ends: Vec<NetSet> as Sets,
        /// The net may fire for ever by itself, without any flag of a robot.
        pub endless: bool as Truth => false,
        /// Markings of internal places in which it may begin; at least one.
        pub situations: Vec<NetSituation> as Map("sections [situations.<id>]", Need::Required),
    }
}

description::section! {
    /// A part that one robot plays.
    #[derive(Eq)]
    pub struct NetRole {
        /// Unique among roles.
        pub id: String as Name,
        /// The protocol between it and the mediator.
        pub protocol: String as Text("a protocol's id"),
        /// What it is.
        pub about: Option<String> as Optional(Text("what the role is")),
    }
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

description::section! {
    /// One array of a protocol that has alternatives.
    pub struct NetArray {
        /// Unique in the protocol.
        pub id: String as Name,
        /// Its entries, in the order in which they are set.
        pub flags: Vec<NetFlag> as List(FLAGS, Need::Required),
        /// The arrays that can follow; none: the run ends.
        pub then: Vec<String> as Texts("an array's id"),
    }
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

description::section! {
    /// What a flag of the mediator's means for the robot, besides being set.
    #[derive(Default)]
    pub struct NetCommand {
        /// With a flag of the mediator's: the site's areas that the robot may enter, whose grants the flag carries.
        pub enters: Vec<String> as Texts("an area's id"),
        /// With a flag of the mediator's: from now on not faster than this.
        pub speed_limit_m_s: Option<f64> as Optional(SPEED),
        /// With a flag of the mediator's: drive to this pose in `map` and stop.
        pub stop_pose: Option<Pose2> as Optional(Pose(POSITION)),
    }
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

description::section! {
    /// A transition.
    #[derive(Eq)]
    pub struct NetTransition {
        /// Unique among places and transitions.
        pub id: String as Name,
        /// Places that it takes tokens from.
        pub from: Vec<String> as Texts("a place's id"),
        /// Places that it puts tokens into.
        pub to: Vec<String> as Texts("a place's id"),
    }
}

/// An entry of `[exclusions]` or `[ends]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetSet {
    /// Its name.
    pub id: String,
    /// Its places.
    pub places: Vec<String>,
}

description::section! {
    /// Where a coordination begins.
    #[derive(Eq)]
    pub struct NetSituation {
        /// Unique among situations.
        pub id: String as Name,
        /// When it is the right one.
        pub about: Option<String> as Optional(Text("when the net begins like this")),
        /// The internal places that are marked.
        pub marked: Vec<String> as Texts("an internal place's id"),
    }
}
