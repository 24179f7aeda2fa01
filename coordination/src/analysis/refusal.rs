//! Why a net may not run, and how it gets there.

use std::fmt;

use thiserror::Error;

use crate::petri::ModelError;
use crate::protocol::ABORTED;

/// One step of a closed net, in names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum Step {
    /// A transition fires.
    Fires { transition: String },
    /// The other party of a protocol sets a flag.
    Sets {
        party: String,
        protocol: String,
        flag: String,
    },
    /// A sink is emptied and its flag set.
    Raises {
        party: String,
        protocol: String,
        flag: String,
    },
    /// The other party of a protocol gives up the run.
    Aborts { party: String, protocol: String },
    /// An event fills its sources.
    Arrives { event: String },
    /// A sink is emptied and its event sent.
    Sends { event: String },
}

impl fmt::Display for Step {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fires { transition } => formatter.write_str(transition),
            Self::Sets {
                party,
                protocol,
                flag,
            } if party == protocol => write!(formatter, "{party} sets {flag}"),
            Self::Sets {
                party,
                protocol,
                flag,
            } => write!(formatter, "{party} sets {protocol}.{flag}"),
            Self::Raises {
                party,
                protocol,
                flag,
            } => write!(formatter, "{party} raises {protocol}.{flag}"),
            Self::Aborts { party, protocol } if party == protocol => {
                write!(formatter, "{party} gives up")
            }
            Self::Aborts { party, protocol } => write!(formatter, "{party} gives up {protocol}"),
            Self::Arrives { event } => write!(formatter, "event {event} arrives"),
            Self::Sends { event } => write!(formatter, "event {event} is sent"),
        }
    }
}

/// The steps from the initial state to another; printed as `robot sets request; t1; t2`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Trace {
    /// The steps, in their order.
    pub steps: Vec<Step>,
}

impl fmt::Display for Trace {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.steps.is_empty() {
            return formatter.write_str("nothing");
        }
        for (index, step) in self.steps.iter().enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(formatter, "{separator}{step}")?;
        }
        Ok(())
    }
}

/// A transition that never fires.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Dead {
    /// The transition.
    pub transition: String,
    /// What it lacks where it comes nearest to firing: empty inputs, or full sinks. Empty if there
    /// are too many such transitions to explain each.
    pub lacks: Vec<String>,
    /// How the net gets there.
    pub nearest: Trace,
}

impl fmt::Display for Dead {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.lacks.is_empty() {
            return write!(formatter, "transition `{}` never fires", self.transition);
        }
        write!(
            formatter,
            "transition `{}` never fires: it comes nearest after `{}`, and then lacks {}",
            self.transition,
            self.nearest,
            quoted(&self.lacks)
        )
    }
}

/// What is wrong with a net.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum Reason {
    /// The model does not compile.
    #[error("{}", joined(.0))]
    Model(Vec<ModelError>),
    /// There is nothing to analyse.
    #[error("it has no situation, so it never starts")]
    NoSituation,
    /// A question names a place that the net does not have.
    #[error("it has no place `{place}`")]
    UnknownPlace { place: String },
    /// Two protocols in use have the same name.
    #[error("two protocols are called `{protocol}`")]
    TwoProtocols { protocol: String },
    /// The other party can give up a run of a protocol, and the net would not hear of it.
    #[error(
        "no source is bound to `{ABORTED}` of protocol `{protocol}`, whose other party can give up its runs"
    )]
    UnreadAbort { protocol: String },
    /// A flag fills several sources although its run can be given up, which could then not take it
    /// back from all of them.
    #[error(
        "flag `{flag}` of protocol `{protocol}` fills several sources, but the other party can give up its run; bind one source"
    )]
    SeveralSources { protocol: String, flag: String },
    /// A place is bound to a protocol that is not in use.
    #[error("place `{place}` is bound to the unknown protocol `{protocol}`; known: {known}")]
    UnknownProtocol {
        place: String,
        protocol: String,
        known: String,
    },
    /// A place is bound to a flag that its protocol does not have.
    #[error(
        "place `{place}` is bound to the unknown flag `{flag}` of protocol `{protocol}`; known: {known}"
    )]
    UnknownFlag {
        place: String,
        protocol: String,
        flag: String,
        known: String,
    },
    /// A source waits for a flag of the net's own party, or a sink sets the other party's.
    #[error(
        "{kind} `{place}` is bound to flag `{flag}` of protocol `{protocol}`, which belongs to `{owner}`; expected a flag of `{expected}`"
    )]
    WrongOwner {
        /// `source` or `sink`.
        kind: &'static str,
        place: String,
        protocol: String,
        flag: String,
        owner: String,
        expected: String,
    },
    /// The analysis was not finished.
    #[error("it is too large to analyse: more than {limit} {what}; {}", known(.proved))]
    TooLarge {
        what: &'static str,
        limit: u64,
        /// What place invariants prove all the same; empty if they prove nothing.
        proved: String,
    },
    /// A firing would put a second token into a place.
    #[error(
        "it is not safe: transition `{transition}` would put a second token into place `{place}`"
    )]
    Unsafe { transition: String, place: String },
    /// Two places of an exclusion are marked.
    #[error("exclusion `{exclusion}` is broken: {} are marked together", quoted(.places))]
    Exclusion {
        exclusion: String,
        places: Vec<String>,
    },
    /// A sink is marked whose flag is not next.
    #[error(
        "flag `{flag}` of protocol `{protocol}` is out of order: sink `{sink}` is marked, but after {} comes {next}", if .done.is_empty() { "the beginning of a run" } else { .done.as_str() }
    )]
    OutOfOrder {
        sink: String,
        protocol: String,
        flag: String,
        done: String,
        /// The flags that could be next, and whose they are.
        next: String,
    },
    /// More events wait for a source than may.
    #[error(
        "source `{place}` overflows: `{event}` comes again while {waiting} of them wait already"
    )]
    Overflow {
        place: String,
        event: String,
        waiting: u8,
    },
    /// Nothing can happen any more, and this is no declared end.
    #[error("it stops for ever{}", stopped(.marked, .missed))]
    Deadlock {
        marked: Vec<String>,
        /// What each protocol in the middle of a run waits for.
        missed: Vec<String>,
    },
    /// From here no end can be reached, though the net goes on.
    #[error("it can go on for ever without any way to an end; marked are {}", quoted(.marked))]
    Livelock { marked: Vec<String> },
    /// From here a run of a protocol can never be completed, though the net goes on.
    #[error(
        "a run of protocol `{protocol}` can never be completed: {missed}; marked are {}",
        quoted(.marked)
    )]
    Unfinished {
        protocol: String,
        missed: String,
        marked: Vec<String>,
    },
    /// Its transitions can fire for ever without any flag or event from outside.
    #[error(
        "it can fire for ever without any flag or event from outside, so that nobody knows when it comes to an end; \
         a net that is meant to do so declares it (`endless = true` in a net file)"
    )]
    Endless,
    /// Transitions that never fire, and what follows from that.
    #[error("{}{}", joined(.transitions), unreached(.sinks))]
    DeadTransitions {
        transitions: Vec<Dead>,
        sinks: Vec<String>,
    },
    /// A declared end that never comes.
    #[error("end `{end}` is never reached")]
    EndUnreached { end: String },
}

/// A net that may not run: what is wrong, and the shortest way there.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Refusal {
    /// The net.
    pub net: String,
    /// In which situation it was started, if it has several.
    pub situation: Option<String>,
    /// What is wrong.
    pub reason: Box<Reason>,
    /// The steps that lead there; none if it is wrong before the first step, or never comes.
    pub trace: Option<Trace>,
}

impl fmt::Display for Refusal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "net `{}`", self.net)?;
        if let Some(situation) = &self.situation {
            write!(formatter, " in situation `{situation}`")?;
        }
        write!(formatter, ": {}", self.reason)?;
        match &self.trace {
            Some(trace) if trace.steps.is_empty() => formatter.write_str(", from the beginning"),
            Some(trace) => write!(formatter, ", after `{trace}`"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Refusal {}

/// How many names a message shows.
const SHOWN: usize = 12;

/// "`a`, `b` and 3 more", or "nothing".
pub(super) fn quoted(names: &[String]) -> String {
    if names.is_empty() {
        return "nothing".to_owned();
    }
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect();
    let more = names.len().saturating_sub(SHOWN);
    match more {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

fn joined<T: fmt::Display>(parts: &[T]) -> String {
    let shown: Vec<String> = parts.iter().take(SHOWN).map(T::to_string).collect();
    match parts.len().saturating_sub(SHOWN) {
        0 => shown.join("; "),
        more => format!("{}; and {more} more", shown.join("; ")),
    }
}

fn known(proved: &str) -> String {
    match proved {
        "" => "nothing is known about the rest".to_owned(),
        proved => {
            format!("place invariants prove {proved}, and nothing else is known about the rest")
        }
    }
}

fn stopped(marked: &[String], missed: &[String]) -> String {
    let waits = if missed.is_empty() {
        String::new()
    } else {
        format!(" and {}", missed.join(" and "))
    };
    format!(": marked are {}{waits}", quoted(marked))
}

fn unreached(sinks: &[String]) -> String {
    match sinks {
        [] => String::new(),
        sinks => format!("; so these sinks are never marked: {}", quoted(sinks)),
    }
}
