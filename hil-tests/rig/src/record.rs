//! All that is known of a run when it is over: what reports are made of.
//!
//! Times are seconds since the first robot was started. Paths are the world's truth; holdings, waits and latencies
//! are what an independent listener heard on the network; only firings and markings of nets are the mediator's own
//! word.

use config::{NetConfig, SiteConfig};
use description::geometry::Footprint;
use sim::world::{Pose, Shape};

use crate::scenario::Limits;
use crate::summary::{Holding, Summary};

/// A run.
#[derive(Clone, Debug)]
pub struct Record {
    /// What it is about, in a sentence; may be empty.
    pub about: String,
    /// The site.
    pub site: SiteConfig,
    /// The nets that the site's coordinations use.
    pub nets: Vec<NetConfig>,
    /// What was a violation.
    pub limits: Limits,
    /// The robots, in the order of their identities.
    pub robots: Vec<RobotRecord>,
    /// Obstacles and walkers that the site file does not know, as they were at the end.
    pub obstacles: Vec<Shape>,
    /// Who had which area, in the order of grants.
    pub holdings: Vec<Holding>,
    /// Who waited for which area, in the order in which they began.
    pub waits: Vec<Wait>,
    /// When a mediator ran; several spans when it was restarted, none without one.
    pub mediator: Vec<Span>,
    /// What the rig or an operator did to the run, such as killing a robot.
    pub incidents: Vec<Incident>,
    /// From requests that could be granted at once to their grants.
    pub grant_latency_ms: Vec<f64>,
    /// From a robot's flag to the mediator's next command through the net.
    pub command_latency_ms: Vec<f64>,
    /// The figures, with outcome, coordinations and violations.
    pub summary: Summary,
}

/// What was seen of one robot.
#[derive(Clone, Debug)]
pub struct RobotRecord {
    /// Its identity.
    pub id: String,
    /// Its role on the site.
    pub role: String,
    /// What it is, as its file says.
    pub model: String,
    /// Fastest speed that its file allows.
    pub max_speed_m_s: f64,
    /// From `base_link` to the edges of its body.
    pub footprint: Footprint,
    /// Where it truly was.
    pub path: Vec<PathPoint>,
    /// States of its machine, as it reported them.
    pub states: Vec<StateChange>,
}

/// Where a robot truly was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// When.
    pub at_s: f64,
    /// `base_link` in `map`.
    pub pose: Pose,
    /// Forward speed.
    pub speed_m_s: f64,
    /// Distance of its footprint to anything.
    pub clearance_m: f64,
    /// It was touching something.
    pub in_contact: bool,
}

/// A robot said that its state machine went on.
#[derive(Clone, Debug, PartialEq)]
pub struct StateChange {
    /// When it was heard.
    pub at_s: f64,
    /// State of its machine.
    pub state: String,
    /// Area in which it believed to be; may be empty.
    pub area: String,
    /// Skill that is scheduled.
    pub skill: String,
    /// Where it believed to be.
    pub believed_m: [f64; 2],
}

/// A robot asked for an area and did not get it at once.
#[derive(Clone, Debug, PartialEq)]
pub struct Wait {
    /// Robot.
    pub robot: String,
    /// Area.
    pub area: String,
    /// When its request was heard.
    pub from_s: f64,
    /// When the grant was heard; none: it waited until the end.
    pub to_s: Option<f64>,
    /// Why, as the mediator told it last; may be empty.
    pub why: String,
}

/// A stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its beginning.
    pub from_s: f64,
    /// Its end.
    pub to_s: f64,
}

/// Something was done to the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Incident {
    /// When.
    pub at_s: f64,
    /// What, in a few words.
    pub what: String,
}
