//! What a person should hear of.

use contract::VersionMismatch;
use contract::level::LevelError;
use coordination::protocol::MergeError;

/// What is to be done where another mediator has granted: people have closed areas with it, and bodies that report no more block
/// areas by what it has found.
const LOOK_FIRST: &str = "nothing is granted until every robot of the site has reported where it stands, or is said to be absent; areas that people have closed with the other one, or in which it has found a second process of a robot that is silent now, are open here: look, and close them";

/// Something that happened and should not have. Its text says what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum Alarm {
    /// A report of a robot that the site does not list.
    #[error(
        "robot `{0}` is unknown here: list it under [robots] of the site file, or correct its identity.id"
    )]
    UnknownRobot(String),
    /// Two processes report as one robot, for longer than a restart takes.
    #[error(
        "two processes report as robot `{robot}`: the first goes on, the second is refused; end the wrong one (clear its areas if it was the first), then restart the other, say `mediator clear AREA --taken-away` of areas in which `mediator status` still lists a second process, and give each robot an identity.id of its own"
    )]
    Doubled { robot: String },
    /// Processes of a robot were offered all sessions that there are.
    #[error(
        "robot `{robot}` was offered {most} sessions since this start, and gets no more: see who uses its certificate, and whether the robot hears this mediator; then start the mediator again"
    )]
    TooManySessions { robot: String, most: u64 },
    /// A report under a number that its process cannot have reached.
    #[error(
        "robot `{robot}` reports under number {found}, which its process cannot have reached; dropped: see who uses its certificate, and if the robot is not heard, start its program again"
    )]
    MadeUpNumber { robot: String, found: u64 },
    /// Robots follow another mediator.
    #[error(
        "robots of this site follow another mediator; this one, {instance:016x}, {}: end the wrong one",
        if *stands_by { "stands by and grants nothing" } else { "goes on, since more follow it" }
    )]
    SecondMediator { instance: u64, stands_by: bool },
    /// A robot knows of a start of the mediator that the journal does not.
    #[error(
        "robot `{robot}` has followed start {found} of a mediator, of which this journal knows nothing: it is new, old or another one's; this is start {epoch} from now on; {LOOK_FIRST}"
    )]
    OlderJournal {
        robot: String,
        found: u64,
        epoch: u64,
    },
    /// This mediator has stood by, and does no more.
    #[error(
        "robots follow another mediator no more, and this one goes on as start {epoch}: {LOOK_FIRST}"
    )]
    GoesOn { epoch: u64 },
    /// A report of another version of the contract.
    #[error("robot `{robot}`: {mismatch}")]
    Version {
        robot: String,
        mismatch: VersionMismatch,
    },
    /// A robot that drives by another site.
    #[error(
        "robot `{robot}` drives by site `{found}`, expected `{expected}`: give it this mediator's site file"
    )]
    Site {
        robot: String,
        found: String,
        expected: String,
    },
    /// A robot that knows other areas than this site has.
    #[error("robot `{robot}` knows another floor: {difference}; give it this mediator's site file")]
    Floor { robot: String, difference: String },
    /// A name or level that makes no sense; that part of the report was ignored.
    #[error("robot `{robot}`, area `{area}`: {what}; ignored")]
    BadReport {
        robot: String,
        area: String,
        what: BadReport,
    },
    /// No report for too long.
    #[error("robot `{robot}` is silent; blocked until it is back or cleared: {areas}")]
    Silent { robot: String, areas: String },
    /// The same of a process that was found beside the one that speaks for the robot, that was refused while none was heard, or that spoke for
    /// another body with its name.
    #[error(
        "a second process of robot `{robot}`, one that was refused, or one before, is silent; blocked until it is heard elsewhere, or somebody has looked and says that no such body is there (`mediator clear AREA --taken-away`), as where it was restarted and is the robot that is heard there now: {areas}"
    )]
    SilentSecond { robot: String, areas: String },
    /// A new process of a robot stands where the one before cannot have come to, so that this one may be where it was.
    #[error(
        "robot `{robot}` has started anew in {here}, was last in {areas} or let in there, and was not heard to leave: another body of its name may be there, silent; blocked until it is heard elsewhere, or somebody has looked and says that no such body is there (`mediator clear AREA --taken-away`): {areas}"
    )]
    StartedElsewhere {
        robot: String,
        here: String,
        areas: String,
    },
    /// What an operator has said of it before this start counts.
    #[error(
        "robot `{robot}` was said to be absent before this start, was not heard since, and is not waited for any more: look whether it is on the floor"
    )]
    NotAwaited { robot: String },
    /// It is heard again.
    #[error("robot `{robot}` is back")]
    Back { robot: String },
    /// The journal lacked what the robot had been told; what the robot says is taken over.
    #[error(
        "robot `{robot}` has a newer level of area `{area}` than the journal, which has lost its last entries; the level is taken over from the robot"
    )]
    Adopted { robot: String, area: String },
    /// A robot that is asked anew what it has says that it has an area by a grant that is not known.
    #[error(
        "robot `{robot}` has area `{area}` by a grant that this mediator does not know: another one has given it, or this one's journal has lost it; it is taken over from the robot"
    )]
    TakenOver { robot: String, area: String },
    /// What a robot says that it was granted, or asks for, is not known, and was not taken over: it was not awaited.
    #[error(
        "robot `{robot}` has a newer level of area `{area}` than this mediator, which did not wait for the robot: that level has ended, and the robot asks anew"
    )]
    Void { robot: String, area: String },
    /// A robot reaches into an area that it was not granted.
    #[error(
        "robot `{robot}` is in area `{area}` without a grant; no other robot is let in until it has left"
    )]
    Intruder { robot: String, area: String },
    /// A robot is larger than any that this mediator reckons with.
    #[error(
        "robot `{robot}` reaches {reach_m:.2} m from its centre, and this mediator reckons with {} m: before it is heard, it may be in areas that do not count as occupied; let nothing be granted before it was heard",
        crate::setup::LONGEST_REACH_M
    )]
    TooLarge { robot: String, reach_m: f64 },
    /// A part of protocol 2 in a report that makes no sense.
    #[error("robot `{robot}`, discrete control: {what}; ignored")]
    BadControl { robot: String, what: BadReport },
    /// A coordination of the journal cannot go on.
    #[error(
        "coordination `{coordination}` of the journal is given up, and its robots are let go: {what}"
    )]
    NotResumed { coordination: String, what: String },
    /// The journal lacked what a robot was told in a coordination.
    #[error(
        "robot `{robot}` has a newer level in coordination `{coordination}` than the journal, which has lost its last entries; the coordination is broken off"
    )]
    Forgotten { coordination: String, robot: String },
    /// A robot is where a net decides, and the net has not let it in.
    #[error(
        "robot `{robot}` has area `{area}`, into which coordination `{coordination}` has not let it; the coordination ends, and begins again when its areas are empty"
    )]
    Bypassed {
        coordination: String,
        robot: String,
        area: String,
    },
    /// The same of a process that does not speak for the robot.
    #[error(
        "a second process of robot `{robot}`, or the last words of one that has ended, says that it is in area `{area}`, into which coordination `{coordination}` has not let it; the coordination ends, and begins again when its areas are empty"
    )]
    BypassedBySecond {
        coordination: String,
        robot: String,
        area: String,
    },
    /// A coordination makes no progress.
    #[error("coordination `{coordination}` has made no progress for {since_s} s: {what}")]
    Still {
        coordination: String,
        /// Seconds since it last made progress.
        since_s: u64,
        what: String,
    },
    /// A robot that was asked for its discrete control says nothing.
    #[error(
        "robot `{robot}` has not answered the `acquire` of coordination `{coordination}` for 5 s: the coordination ends, and none takes the robot in for 60 s; see whether its program knows protocol 2"
    )]
    Mute { robot: String, coordination: String },
    /// A coordination is broken off because it makes no progress.
    #[error(
        "coordination `{coordination}` is broken off: its robots are told to get out of the way"
    )]
    Preempted { coordination: String },
    /// Robots that were told to get out of the way did not.
    #[error(
        "coordination `{coordination}` ends, though its robots are not all out of the way: they are let go as they are"
    )]
    LetGo { coordination: String },
    /// Robots wait for each other.
    #[error(
        "robots wait for each other: {waits}; none goes on before one backs out: pause `{robot}`, drive it out of area {area} by hand (`onboard teleop`), and let it go on when the others have passed"
    )]
    Circle {
        waits: String,
        /// Who is to back out, and of what.
        robot: String,
        area: String,
    },
    /// More robots than it holds stand in an area, or may still come in.
    #[error(
        "area `{area}` holds at most {capacity} robots, and {found} are in it, or may still come in: {robots}"
    )]
    Overfull {
        area: String,
        capacity: u32,
        found: usize,
        robots: String,
    },
}

impl Alarm {
    /// The robot, area or coordination of the site that it is about, if it is about one.
    #[must_use]
    pub fn subject(&self) -> Option<&str> {
        match self {
            Self::Doubled { robot }
            | Self::TooManySessions { robot, .. }
            | Self::MadeUpNumber { robot, .. }
            | Self::OlderJournal { robot, .. }
            | Self::Version { robot, .. }
            | Self::Site { robot, .. }
            | Self::Floor { robot, .. }
            | Self::BadReport { robot, .. }
            | Self::Silent { robot, .. }
            | Self::SilentSecond { robot, .. }
            | Self::StartedElsewhere { robot, .. }
            | Self::NotAwaited { robot }
            | Self::Back { robot }
            | Self::Adopted { robot, .. }
            | Self::TakenOver { robot, .. }
            | Self::Void { robot, .. }
            | Self::Intruder { robot, .. }
            | Self::TooLarge { robot, .. }
            | Self::BadControl { robot, .. }
            | Self::Forgotten { robot, .. }
            | Self::Bypassed { robot, .. }
            | Self::BypassedBySecond { robot, .. }
            | Self::Mute { robot, .. }
            | Self::Circle { robot, .. } => Some(robot),
            Self::NotResumed { coordination, .. }
            | Self::Still { coordination, .. }
            | Self::Preempted { coordination }
            | Self::LetGo { coordination } => Some(coordination),
            Self::Overfull { area, .. } => Some(area),
            Self::UnknownRobot(_) | Self::SecondMediator { .. } | Self::GoesOn { .. } => None,
        }
    }
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
    /// A level about another grant than the robot's present one, or about none.
    #[error("its level names fence {found}, expected {expected}, that of its grant")]
    Fence {
        /// What the report says.
        found: u64,
        /// That of its grant.
        expected: u64,
    },
    /// A grant that the robot says it has, though nobody can have given it.
    #[error(
        "it says that it has a grant with fence {found}, which nobody has given: expected one after {after}, that of the journal"
    )]
    NoGrant {
        /// What the report says.
        found: u64,
        /// The last fence of that area in the journal.
        after: u64,
    },
    /// A number that cannot be reached.
    #[error("its {what} is {found}, expected less than {most}")]
    TooLarge {
        /// Run or fence.
        what: &'static str,
        /// What the report says.
        found: u64,
        /// Nobody has counted so far.
        most: u64,
    },
    /// A level that cannot follow ours.
    #[error("its level cannot follow ours: {0}")]
    Merge(#[from] MergeError),
}
