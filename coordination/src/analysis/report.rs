//! What an analysis found out about a net that may run.

use std::fmt;

use super::refusal::{Trace, quoted};

/// What is worth knowing, but no reason to refuse a net.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum Warning {
    /// The net declares no end, so only single runs of protocols were shown to complete.
    NoEnds,
    /// No source reads a flag that the other party sets.
    Unread { protocol: String, flag: String },
    /// The net's transitions can fire for ever without any flag or event from outside, as it
    /// declares, so that an evaluation may always use up its budget.
    NeverRests {
        /// How it gets to where that begins.
        trace: Trace,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoEnds => formatter.write_str("no end is declared"),
            Self::Unread { protocol, flag } => {
                write!(
                    formatter,
                    "no source reads flag `{flag}` of protocol `{protocol}`"
                )
            }
            Self::NeverRests { trace } => write!(
                formatter,
                "after `{trace}` it can fire for ever without any flag or event from outside"
            ),
        }
    }
}

/// What follows from [place invariants](super::place_invariants()) alone, without a look at any state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ByInvariants {
    /// Whether it is safe: no internal place ever holds a second token.
    pub is_safe: bool,
    /// The exclusions that hold.
    pub exclusions: Vec<String>,
}

impl fmt::Display for ByInvariants {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let exclusions = quoted(&self.exclusions);
        match (self.is_safe, self.exclusions.is_empty()) {
            (false, true) => formatter.write_str("nothing"),
            (true, true) => formatter.write_str("that it is safe"),
            (false, false) => write!(formatter, "exclusion {exclusions}"),
            (true, false) => write!(formatter, "that it is safe, and exclusion {exclusions}"),
        }
    }
}

/// What an analysis looked at; part of a [`Proof`](super::Proof).
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Report {
    /// The net.
    pub net: String,
    /// In which situation it was started, if it has several.
    pub situation: Option<String>,
    /// How many states it can reach; the largest number if there are more.
    pub states: u128,
    /// How many steps there are between them; the largest number if there are more.
    pub steps: u128,
    /// The ends that it can reach from this situation.
    pub ends: Vec<String>,
    /// What is worth knowing.
    pub warnings: Vec<Warning>,
    /// What was proved before any state was looked at.
    pub by_invariants: ByInvariants,
}
