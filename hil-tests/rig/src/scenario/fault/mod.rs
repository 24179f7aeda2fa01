//! What goes wrong in a run on the simulated clock: what, when, for how long and for whom.

mod keys;
mod kind;
mod latches;
mod stopping;
#[cfg(test)]
mod tests;

use std::fmt;

use serde::{Deserialize, Serialize};

pub use kind::{SUPERVISOR, ScriptedKind};
pub use stopping::{GRAVITY_M_S2, Stopping};
pub(crate) use stopping::{OVERLOADED_BY_S, STARTED_AGAIN_S};

/// Something that goes wrong. Times are seconds since the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScriptedFault {
    /// When it begins.
    pub at_s: f64,
    /// How long it lasts.
    pub for_s: f64,
    /// What it is.
    pub what: ScriptedKind,
    /// For this robot; left out where it concerns all, or the mediator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// How often, or how much, from 0 to 1; of a clock from -1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// By how much, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_s: Option<f64>,
    /// Of the robot's threads only this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thread: Option<String>,
    /// Where in `map`: x and y in metres, heading in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 3]>,
    /// What who drives by hand wants: forward, metres per second, and turning, radians per second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<[f64; 2]>,
    /// Of messages only those that go this way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub way: Option<Direction>,
    /// Of messages only those to or from this mediator, where there are two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mediator: Option<WhichMediator>,
}

/// Which way messages go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// What robots say.
    ToMediator,
    /// What the mediator says.
    ToRobots,
}

/// One of two mediators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WhichMediator {
    /// That of the scenario.
    First,
    /// That of `second-mediator` or `copied-mediator`.
    Second,
}

impl WhichMediator {
    fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::Second => "second",
        }
    }
}

impl Direction {
    fn name(self) -> &'static str {
        match self {
            Self::ToMediator => "to-mediator",
            Self::ToRobots => "to-robots",
        }
    }

    /// As often either one as both, by a number between 0 and 1.
    #[must_use]
    pub fn drawn(unit: f64) -> Option<Self> {
        match unit {
            ..0.333 => Some(Self::ToMediator),
            0.333..0.667 => Some(Self::ToRobots),
            _ => None,
        }
    }
}

impl ScriptedFault {
    /// When it is over.
    #[must_use]
    pub fn until_s(&self) -> f64 {
        self.at_s + self.for_s
    }

    /// Whether it meets messages that go this way, from or to this mediator if not to everybody.
    #[must_use]
    pub fn meets(&self, way: Direction, mediator: Option<WhichMediator>) -> bool {
        self.way.is_none_or(|own| own == way)
            && self.mediator.is_none_or(|own| Some(own) == mediator)
    }

    /// Whether a robot may take its pose for another than it is because of it. A clock misleads nobody that is as good as any in a computer.
    #[must_use]
    pub fn misleads(&self) -> bool {
        const WORST_CLOCK: f64 = 0.001;
        let drifts = self.what == ScriptedKind::Drift;
        self.what.misleads() || drifts && self.share.is_some_and(|share| share.abs() > WORST_CLOCK)
    }

    /// What is wrong with it, for a scenario with these robots, and the names of their threads.
    #[must_use]
    pub fn complaints(&self, robots: &[(&str, Vec<&str>)]) -> Vec<String> {
        const LONGEST_S: f64 = 3600.0;
        let mut complaints = Vec::new();
        let keys = self.what.keys();
        for (key, value, [least, most]) in [
            ("at_s", Some(self.at_s), [0.0, LONGEST_S]),
            ("for_s", Some(self.for_s), [0.0, LONGEST_S]),
            ("share", self.share, [self.what.least_share(), 1.0]),
            ("by_s", self.by_s, [0.0, 60.0]),
        ] {
            if let Some(value) = value.filter(|value| !(least..=most).contains(value)) {
                complaints.push(format!("found {key} = {value}, expected {least} to {most}"));
            }
        }
        let mut key = |name: &str, is: bool, may: bool, must: bool| {
            if is && !may {
                complaints.push(format!("found `{name}`, expected none for this fault"));
            } else if must && !is {
                complaints.push(format!("found no `{name}`, expected one for this fault"));
            }
        };
        key(
            "robot",
            self.robot.is_some(),
            keys.robot.is_some(),
            keys.robot == Some(true),
        );
        key("share", self.share.is_some(), keys.share, keys.share);
        key("by_s", self.by_s.is_some(), keys.by_s, keys.by_s);
        key("thread", self.thread.is_some(), keys.thread, false);
        key("pose", self.pose.is_some(), keys.pose, false);
        key("motion", self.motion.is_some(), keys.motion, keys.motion);
        key("way", self.way.is_some(), keys.way, false);
        key("mediator", self.mediator.is_some(), keys.way, false);
        const FARTHEST: f64 = 1000.0;
        let near = |value: &f64| value.abs() <= FARTHEST;
        if let Some(pose) = self.pose.filter(|pose| !pose.iter().all(near)) {
            complaints.push(format!(
                "found pose = {pose:?}, expected metres, metres and degrees, each from -{FARTHEST} to {FARTHEST}"
            ));
        }
        const FASTEST: f64 = 3.0;
        let slow = |value: &f64| value.abs() <= FASTEST;
        if let Some(motion) = self.motion.filter(|motion| !motion.iter().all(slow)) {
            complaints.push(format!(
                "found motion = {motion:?}, expected metres and radians per second, each from -{FASTEST} to {FASTEST}"
            ));
        }
        if let Some(robot) = &self.robot {
            let own = robots.iter().find(|(id, _)| id == robot);
            let ids = || robots.iter().map(|(id, _)| *id);
            complaints.extend(unknown("robot", robot, own.is_some(), ids()));
            if let (Some(thread), Some((_, threads))) = (&self.thread, own) {
                let mut known = threads.iter().copied().chain([SUPERVISOR]);
                let is = known.clone().any(|name| name == thread);
                complaints.extend(unknown("thread", thread, is, &mut known));
            }
        }
        complaints
    }
}

/// What is wrong with a name that should be one of those known.
fn unknown<'a>(
    key: &str,
    found: &str,
    is_known: bool,
    known: impl Iterator<Item = &'a str>,
) -> Option<String> {
    (!is_known).then(|| {
        let known = known.collect::<Vec<_>>().join("`, `");
        format!("found {key} `{found}`, expected one of `{known}`")
    })
}

impl fmt::Display for ScriptedFault {
    /// As it stands in a scenario file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            at_s, for_s, what, ..
        } = self;
        let what = what.name();
        write!(f, "{{ at_s = {at_s:?}, for_s = {for_s:?}, what = {what:?}")?;
        if let Some(robot) = &self.robot {
            write!(f, ", robot = {robot:?}")?;
        }
        if let Some(share) = self.share {
            write!(f, ", share = {share:?}")?;
        }
        if let Some(by_s) = self.by_s {
            write!(f, ", by_s = {by_s:?}")?;
        }
        if let Some(thread) = &self.thread {
            write!(f, ", thread = {thread:?}")?;
        }
        if let Some(pose) = self.pose {
            write!(f, ", pose = {pose:?}")?;
        }
        if let Some(motion) = self.motion {
            write!(f, ", motion = {motion:?}")?;
        }
        if let Some(way) = self.way {
            write!(f, ", way = {:?}", way.name())?;
        }
        if let Some(mediator) = self.mediator {
            write!(f, ", mediator = {:?}", mediator.name())?;
        }
        f.write_str(" }")
    }
}
