//! Why a net has no machine.

use alloc::string::String;

use thiserror::Error;

/// What of a net no machine can say, or that it has too many states.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum OfNetError {
    /// A source or sink is bound to a flag, which is set once in a run of its protocol; a machine has events only.
    #[error(
        "net `{net}`: place `{place}` is bound to the flag `{flag}`; a machine has only events"
    )]
    Flag {
        net: String,
        place: String,
        flag: String,
    },
    /// Transitions can go on firing without another event.
    #[error("net `{net}` can go on for ever after {event} in state `{state}`")]
    Endless {
        net: String,
        event: String,
        state: String,
    },
    /// The order in which transitions happen to fire decides what the net does.
    #[error(
        "net `{net}`: after {event} in state `{state}` it comes to {first} or to {second}, depending on which transition \
         fires first"
    )]
    Undetermined {
        net: String,
        event: String,
        state: String,
        first: String,
        second: String,
    },
    /// The net keeps an event that it cannot use yet; see [`Unused`](super::Unused).
    #[error(
        "net `{net}`: in state `{state}` {event} stays in source `{source_place}`; a machine keeps no events"
    )]
    Unused {
        net: String,
        event: String,
        state: String,
        source_place: String,
    },
    /// Outputs are fired before any event.
    #[error("net `{net}` fires `{output}` before any event; a machine fires only on one")]
    FiresAtStart { net: String, output: String },
    /// The machine would have more states than were allowed.
    #[error("net `{net}` has more than {limit} states; it is too large for a machine")]
    TooManyStates { net: String, limit: usize },
    /// More markings on the way between states than were allowed.
    #[error(
        "net `{net}` has more than {limit} markings between its states; it is too large for a machine"
    )]
    TooManyMarkings { net: String, limit: usize },
}
