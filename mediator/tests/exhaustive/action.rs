//! What may happen next.

use std::fmt;

/// The names of both areas.
pub const AREAS: [&str; 2] = ["a", "b"];
/// The names of both robots. The third one is a second robot that was given the first one's identity.
pub const ROBOTS: [&str; 3] = ["one", "two", "one"];

/// What becomes of a report and its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    Arrive,
    ReportLate,
    ReportTwice,
    AnswerLate,
    AnswerTwice,
    /// A part of the robot that has fallen behind gives back what it has, by the fence of the grant before.
    OldFence,
}

/// What a mediator that starts again finds of its journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    All,
    /// All but the last write.
    AllButLast,
    /// Another file, which is empty.
    Nothing,
}

/// A step of the model; robots and areas by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// 0.98 s pass.
    Tick,
    /// A robot reports, and is answered.
    Talk(u8, Fate),
    /// What was held back arrives.
    Late,
    /// The robot passes its point of no return before the next area.
    Commit(u8),
    /// The body that could not stop any more reaches into it.
    Enter(u8),
    /// The body has left its hindmost area.
    Leave(u8),
    /// The robot does not want to go on any more, or again.
    Mind(u8),
    Cut(u8),
    Mend(u8),
    Crash(u8),
    Start(u8),
    Restart(Left),
    /// An operator sees the area empty, and says so.
    Clear(u8),
    /// An operator who takes one area for another says that this one is empty, in which a robot stands that has said so.
    Mistake(u8),
    /// An operator carries a robot off the floor that is in no area, switches it off, and says that it is absent.
    Absent(u8),
    /// An operator carries the robot out of its areas, and says so.
    TakeAway(u8),
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let robot = |robot: u8| {
            let second = if robot == 2 {
                "the second robot "
            } else {
                "robot "
            };
            format!("{second}{}", ROBOTS[usize::from(robot)])
        };
        match *self {
            Self::Tick => write!(f, "0.98 s pass"),
            Self::Talk(own, fate) => {
                let fate = match fate {
                    Fate::Arrive => "is answered",
                    Fate::ReportLate => "the report does not arrive yet",
                    Fate::ReportTwice => "is answered; the report will come again",
                    Fate::AnswerLate => "the answer does not arrive yet",
                    Fate::OldFence => {
                        "gives back a grant before by a level of now, and is answered"
                    }
                    Fate::AnswerTwice => "is answered; the answer will come again",
                };
                write!(f, "{} reports: {fate}", robot(own))
            }
            Self::Late => write!(f, "what was held back arrives"),
            Self::Commit(own) => {
                write!(f, "{} can no longer stop before its next area", robot(own))
            }
            Self::Enter(own) => write!(f, "{} reaches into it", robot(own)),
            Self::Leave(own) => write!(f, "{} leaves an area", robot(own)),
            Self::Mind(own) => write!(f, "{} changes its mind", robot(own)),
            Self::Cut(own) => write!(f, "{} is cut off", robot(own)),
            Self::Mend(own) => write!(f, "{} is within reach again", robot(own)),
            Self::Crash(own) => write!(f, "the process of {} ends", robot(own)),
            Self::Start(own) => write!(f, "a process of {} starts", robot(own)),
            Self::Restart(Left::All) => write!(f, "the mediator starts again"),
            Self::Restart(Left::AllButLast) => {
                write!(f, "the mediator starts again, and has lost its last write")
            }
            Self::Restart(Left::Nothing) => {
                write!(f, "the mediator starts again with an empty journal")
            }
            Self::Clear(area) => write!(f, "an operator clears area {}", AREAS[usize::from(area)]),
            Self::Mistake(area) => write!(
                f,
                "an operator clears area {}, and means another one",
                AREAS[usize::from(area)]
            ),
            Self::Absent(own) => write!(
                f,
                "an operator switches {} off, and says that it is absent",
                robot(own)
            ),
            Self::TakeAway(own) => write!(f, "an operator takes {} away", robot(own)),
        }
    }
}
