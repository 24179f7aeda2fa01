//! What a person should hear of.

use contract::VersionMismatch;
use contract::level::LevelError;
use coordination::protocol::MergeError;

/// Something that happened and should not have. Its text says what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Alarm {
    /// A report of a robot that the site does not list.
    #[error(
        "robot `{0}` is unknown here: list it under [robots] of the site file, or correct its identity.id"
    )]
    UnknownRobot(String),
    /// A report of another version of the contract.
    #[error("robot `{robot}`: {mismatch}")]
    Version {
        /// Who.
        robot: String,
        /// Which version.
        mismatch: VersionMismatch,
    },
    /// A robot that drives by another site.
    #[error(
        "robot `{robot}` drives by site `{found}`, expected `{expected}`: give it this mediator's site file"
    )]
    Site {
        /// Who.
        robot: String,
        /// What it says.
        found: String,
        /// Ours.
        expected: String,
    },
    /// A name or level that makes no sense; that part of the report was ignored.
    #[error("robot `{robot}`, area `{area}`: {what}; ignored")]
    BadReport {
        /// Who.
        robot: String,
        /// About which area.
        area: String,
        /// What was wrong.
        what: BadReport,
    },
    /// No report for too long.
    #[error("robot `{robot}` is silent; blocked until it is back or cleared: {areas}")]
    Silent {
        /// Who.
        robot: String,
        /// Where it may be.
        areas: String,
    },
    /// It is heard again.
    #[error("robot `{robot}` is back")]
    Back {
        /// Who.
        robot: String,
    },
    /// The journal lacked what the robot had been told; what the robot says is taken over.
    #[error(
        "robot `{robot}` has a newer level of area `{area}` than the journal, which has lost its last entries; the level is taken over from the robot"
    )]
    Adopted {
        /// Who.
        robot: String,
        /// About which area.
        area: String,
    },
    /// A robot reaches into an area that it was not granted.
    #[error(
        "robot `{robot}` is in area `{area}` without a grant; no other robot is let in until it has left"
    )]
    Intruder {
        /// Who.
        robot: String,
        /// Where.
        area: String,
    },
    /// A part of protocol 2 in a report that makes no sense.
    #[error("robot `{robot}`, discrete control: {what}; ignored")]
    BadControl {
        /// Who.
        robot: String,
        /// What was wrong.
        what: BadReport,
    },
    /// A coordination of the journal cannot go on.
    #[error(
        "coordination `{coordination}` of the journal is given up, and its robots are let go: {what}"
    )]
    NotResumed {
        /// Which.
        coordination: String,
        /// Why.
        what: String,
    },
    /// The journal lacked what a robot was told in a coordination.
    #[error(
        "robot `{robot}` has a newer level in coordination `{coordination}` than the journal, which has lost its last entries; the coordination is broken off"
    )]
    Forgotten {
        /// Which.
        coordination: String,
        /// Who.
        robot: String,
    },
    /// A robot is where a net decides, and the net has not let it in.
    #[error(
        "robot `{robot}` has area `{area}`, into which coordination `{coordination}` has not let it; the coordination ends, and begins again when its areas are empty"
    )]
    Bypassed {
        /// Which.
        coordination: String,
        /// Who.
        robot: String,
        /// Where.
        area: String,
    },
    /// A coordination makes no progress.
    #[error("coordination `{coordination}` has made no progress for {since_s} s: {what}")]
    Still {
        /// Which.
        coordination: String,
        /// Seconds since it last made progress.
        since_s: u64,
        /// What each robot waits for.
        what: String,
    },
    /// A coordination is broken off because it makes no progress.
    #[error(
        "coordination `{coordination}` is broken off: its robots are told to get out of the way"
    )]
    Preempted {
        /// Which.
        coordination: String,
    },
    /// More robots than it holds stand in an area.
    #[error("area `{area}` holds at most {capacity} robots, and {found} are in it: {robots}")]
    Overfull {
        /// Where.
        area: String,
        /// How many it holds.
        capacity: u32,
        /// How many there are.
        found: usize,
        /// Who.
        robots: String,
    },
}

/// What was wrong with one part of a report.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BadReport {
    /// No coordination has such a number.
    #[error("no coordination has number {0}")]
    Number(u64),
    /// The site has no such area.
    #[error("this site has no such area")]
    UnknownArea,
    /// Numbers that no level has.
    #[error(transparent)]
    Level(#[from] LevelError),
    /// A level that cannot follow ours.
    #[error("its level cannot follow ours: {0}")]
    Merge(#[from] MergeError),
}
