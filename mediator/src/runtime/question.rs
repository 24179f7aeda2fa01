//! What an operator can ask a running mediator: one line of JSON there, one back, over its control socket or from afar.

use std::fmt;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::checked::shown;
use crate::journal::OrderRecord;
use crate::manager::Status;

/// Timeout of an answer: longer than the mediator may take, whose last word is that the order is being carried out.
const PATIENCE: Duration = Duration::from_secs(7);

/// A question or an order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Question {
    /// How everything stands.
    Status,
    /// Why a robot waits.
    Why {
        /// Its id.
        robot: String,
    },
    /// No silent robot is in this area.
    Clear {
        /// Its id.
        area: String,
        /// One that stands in it, for all that is known, was taken away.
        taken_away: bool,
    },
    /// Nobody is to be let into this area.
    Close {
        /// Its id.
        area: String,
        /// Why, for people.
        why: String,
    },
    /// Robots may be let into it again.
    Open {
        /// Its id.
        area: String,
    },
    /// This coordination is to end.
    End {
        /// Its id, its number, or both: `id/number`.
        coordination: String,
    },
    /// This silent robot is nowhere on the floor.
    Absent {
        /// Its id.
        robot: String,
        /// Though it stands in an area, for all that is known: it was taken away.
        #[serde(default)]
        taken_away: bool,
    },
    /// What operators have ordered.
    Orders,
}

/// As it is typed; it comes into the journal and to terminals of others, whatever somebody has sent.
impl fmt::Display for Question {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Status => write!(f, "status"),
            Self::Why { robot } => write!(f, "why {}", shown(robot)),
            Self::Clear { area, taken_away } => {
                write!(f, "clear {}{}", shown(area), option(*taken_away))
            }
            Self::Close { area, why } if why.is_empty() => write!(f, "close {}", shown(area)),
            Self::Close { area, why } => {
                write!(f, "close {} --because {:?}", shown(area), shown(why))
            }
            Self::Open { area } => write!(f, "open {}", shown(area)),
            Self::End { coordination } => write!(f, "end {}", shown(coordination)),
            Self::Absent { robot, taken_away } => {
                write!(f, "absent {}{}", shown(robot), option(*taken_away))
            }
            Self::Orders => write!(f, "orders"),
        }
    }
}

fn option(taken_away: bool) -> &'static str {
    if taken_away { " --taken-away" } else { "" }
}

impl Question {
    /// What people have written in it.
    pub(super) fn texts(&self) -> impl Iterator<Item = &str> {
        let (text, why) = match self {
            Self::Status | Self::Orders => (None, None),
            Self::Close { area, why } => (Some(area), Some(why)),
            Self::Clear { area, .. } | Self::Open { area } => (Some(area), None),
            Self::Why { robot } | Self::Absent { robot, .. } => (Some(robot), None),
            Self::End { coordination } => (Some(coordination), None),
        };
        text.into_iter().chain(why).map(String::as_str)
    }

    /// Whether it changes anything.
    #[must_use]
    pub fn is_order(&self) -> bool {
        match self {
            Self::Clear { .. }
            | Self::Close { .. }
            | Self::Open { .. }
            | Self::End { .. }
            | Self::Absent { .. } => true,
            Self::Status | Self::Why { .. } | Self::Orders => false,
        }
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// To [`Question::Status`].
    Status(Box<Status>),
    /// Done, or the text that was asked for.
    Done(String),
    /// Not done, and why.
    Refused(String),
    /// An order that is being carried out, and takes effect later than anybody waits for.
    Underway(String),
    /// To [`Question::Orders`], the oldest first.
    Orders(Vec<OrderRecord>),
}

/// Asks the mediator behind a socket.
///
/// # Errors
/// A sentence that says why there is no answer.
pub fn ask(socket: &Path, question: &Question) -> Result<Answer, String> {
    let none = |error: std::io::Error| format!("no answer from {}: {error}", socket.display());
    let mut stream = UnixStream::connect(socket).map_err(|error| {
        format!(
            "no mediator answers at {}: {error}; is it running, with the same --runtime?",
            socket.display()
        )
    })?;
    stream.set_read_timeout(Some(PATIENCE)).map_err(none)?;
    stream.set_write_timeout(Some(PATIENCE)).map_err(none)?;
    let line = serde_json::to_string(question).expect("a question is always JSON");
    writeln!(stream, "{line}").map_err(none)?;
    let mut text = String::new();
    BufReader::new(stream).read_line(&mut text).map_err(none)?;
    serde_json::from_str(&text).map_err(|_| format!("unexpected answer: {}", text.trim()))
}
