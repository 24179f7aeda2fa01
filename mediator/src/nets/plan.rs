//! When and how a net runs on a site, in the manager's numbers.

use std::collections::BTreeMap;
use std::sync::Arc;

use contract::protocols::{RELEASE, flags_and_paths};
use contract::wire::{ControlFlag, ControlPath, Instruction};
use coordination::analysis::Proof;
use coordination::petri::Net;
use coordination::protocol::{FlagId, Position, Protocol};
use description::geometry::Rect;

/// A coordination of a site: its net, checked and analysed, and what that means for the site's areas and robots.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its id in the site file.
    pub id: String,
    /// The net's name.
    pub net: String,
    pub(crate) alarm_after_ns: u64,
    /// In the order of the net file.
    pub(crate) roles: Vec<RolePlan>,
    /// In the order of the site file.
    pub(crate) situations: Vec<SituationPlan>,
    pub(crate) preempt: Option<PreemptPlan>,
    /// Areas into which only this net lets robots.
    pub(crate) governed: Vec<usize>,
    /// These, and those that its flags keep for robots: areas into which others may be let when it changes.
    pub(crate) concerned: Vec<usize>,
    /// What a token in an internal place means.
    pub(crate) meanings: BTreeMap<String, String>,
}

/// A role of the net.
#[derive(Clone, Debug)]
pub(crate) struct RolePlan {
    pub(crate) name: String,
    pub(crate) script: Script,
    pub(crate) kind: Kind,
}

/// What a role's protocol is about.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    /// Protocol 1: its ways in.
    Access(Vec<Passage>),
    /// Protocol 2.
    Control,
}

/// One way of a role into areas that a net governs.
#[derive(Clone, Debug)]
pub(crate) struct Passage {
    pub(crate) request: FlagId,
    pub(crate) granted_at: Position,
    pub(crate) entered: FlagId,
    pub(crate) entered_at: Position,
    pub(crate) released: FlagId,
    pub(crate) areas: Vec<usize>,
}

impl Passage {
    /// A robot whose side is there may be in its areas: it was let in, and has not left all of them.
    pub(crate) fn is_within(&self, at: Position) -> bool {
        at == self.granted_at || at == self.entered_at
    }
}

/// A protocol between mediator and robot, and what is said along with it.
#[derive(Clone, Debug)]
pub(crate) struct Script {
    pub(crate) protocol: Arc<Protocol>,
    /// By flag: areas that are kept for the robot from then on.
    pub(crate) enters: Arc<[Vec<usize>]>,
    /// For messages.
    pub(crate) flags: Vec<ControlFlag>,
    pub(crate) paths: Vec<ControlPath>,
}

impl Script {
    /// `enters` is by flag; what the flags mean is still to be said.
    pub(crate) fn new(protocol: Arc<Protocol>, enters: Vec<Vec<usize>>) -> Self {
        let (flags, paths) = flags_and_paths(&protocol);
        Self {
            enters: enters.into(),
            protocol,
            flags,
            paths,
        }
    }

    /// Areas that its flags keep for the robot.
    pub(crate) fn areas(&self) -> impl Iterator<Item = usize> + '_ {
        self.enters.iter().flatten().copied()
    }

    /// What the robot does when it is let go.
    pub(crate) fn release(&self) -> Option<Instruction> {
        let release = self.flags.iter().find(|flag| flag.name == RELEASE);
        release.and_then(|flag| flag.instruction.clone())
    }
}

/// A situation in which the net starts.
#[derive(Clone, Debug)]
pub(crate) struct SituationPlan {
    pub(crate) name: String,
    /// By role.
    pub(crate) casts: Vec<Cast>,
    pub(crate) net: Net,
    pub(crate) proof: Proof,
}

/// Which robot fits a role.
#[derive(Clone, Debug)]
pub(crate) struct Cast {
    /// Robots that may play it, by robot file and role; sorted.
    pub(crate) robots: Vec<usize>,
    pub(crate) holds: Vec<usize>,
    pub(crate) stands_in: Vec<usize>,
    pub(crate) without: Vec<usize>,
    pub(crate) asks: Vec<usize>,
    pub(crate) states: Vec<String>,
    pub(crate) within: Option<Rect>,
}

impl Cast {
    /// The robot may play it.
    pub(crate) fn names(&self, robot: usize) -> bool {
        self.robots.binary_search(&robot).is_ok()
    }
}

/// What is done when nothing goes on.
#[derive(Clone, Debug)]
pub(crate) struct PreemptPlan {
    pub(crate) after_ns: u64,
    /// Where the net begins again; none: all are released.
    pub(crate) situation: Option<usize>,
    /// By role.
    pub(crate) yields: Vec<YieldPlan>,
}

/// How the robot of a role gets out of the way.
#[derive(Clone, Debug)]
pub(crate) struct YieldPlan {
    pub(crate) script: Script,
    /// In which it is out of the way.
    pub(crate) states: Vec<String>,
}

impl Plan {
    /// What the analysis has to say about the net, though it may run: by situation.
    pub fn warnings(&self) -> impl Iterator<Item = String> + '_ {
        self.situations.iter().flat_map(|situation| {
            let warnings = situation.proof.report().warnings.iter();
            warnings.map(|warning| format!("situation {}: {warning}", situation.name))
        })
    }

    /// The coordination takes discrete control of robots, so that it ends.
    pub(crate) fn controls(&self) -> bool {
        { self.roles.iter() }.any(|role| matches!(role.kind, Kind::Control))
    }
}
