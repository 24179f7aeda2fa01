//! What a site file says about priorities, and about when robots are coordinated.

use std::collections::BTreeMap;

use crate::geometry::Rect;

/// `[roles.<role>]`: what the mediator knows of robots in this role.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RoleConfig {
    /// Who goes first: the larger one. Without an entry it is 0.
    pub priority: u32,
}

/// `[coordinations.<id>]`: when a net is started, and what its flags mean for the robots of this site.
#[derive(Clone, Debug, PartialEq)]
pub struct CoordinationConfig {
    /// The net's name: `nets/<net>.toml` beside the folder of the site file.
    pub net: String,
    /// An alarm is raised when nothing has gone on for so long.
    pub alarm_after_s: f64,
    /// By situation of the net: which robot plays which role. The first that fits is taken.
    pub situations: Vec<SituationConfig>,
    /// By role of the net, then by flag.
    pub flags: BTreeMap<String, BTreeMap<String, FlagMeaning>>,
    /// What is done when nothing has gone on for longer.
    pub preempt: Option<PreemptConfig>,
}

/// `[coordinations.<id>.situations.<situation>]`
#[derive(Clone, Debug, PartialEq)]
pub struct SituationConfig {
    /// The net's situation.
    pub situation: String,
    /// `[….<net role>]`
    pub roles: BTreeMap<String, CastConfig>,
}

/// Which robot fits a role of a net: one for which all of this is true.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CastConfig {
    /// It is this robot.
    pub robot: Option<String>,
    /// It has this role on the site.
    pub role: Option<String>,
    /// It has these areas, by a grant.
    pub holds: Vec<String>,
    /// It is in these areas, whole or in part.
    pub stands_in: Vec<String>,
    /// It neither has nor is in any of these areas.
    pub without: Vec<String>,
    /// It waits for these areas.
    pub asks: Vec<String>,
    /// Its state machine is in one of these states; empty: in any.
    pub states: Vec<String>,
    /// Its `base_link` is there.
    pub within: Option<Rect>,
}

/// What a flag of a net means for a robot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FlagMeaning {
    /// A flag of the mediator: this event is posted to the robot's state machine.
    pub event: Option<String>,
    /// A flag of the robot: it is set when its state machine fires this output.
    pub on_output: Option<String>,
}

/// `[coordinations.<id>.preempt]`
#[derive(Clone, Debug, PartialEq)]
pub struct PreemptConfig {
    /// When nothing has gone on for so long.
    pub after_s: f64,
    /// From which situation of the net it begins again when all have yielded; `None`: all are released.
    pub situation: Option<String>,
    /// By role of the net.
    pub yields: BTreeMap<String, YieldConfig>,
}

/// `[coordinations.<id>.preempt.yields.<net role>]`: how a robot gets out of the way.
#[derive(Clone, Debug, PartialEq)]
pub struct YieldConfig {
    /// Posted to its state machine.
    pub event: String,
    /// States in which it is out of the way. At least one.
    pub states: Vec<String>,
    /// Areas that it needs for that; they are kept for it.
    pub enters: Vec<String>,
}
