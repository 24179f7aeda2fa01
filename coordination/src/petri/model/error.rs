//! What can be wrong with a net's model.

use alloc::string::String;

use thiserror::Error;

use crate::event::TooManyEvents;

/// What is wrong with a [`NetModel`](super::NetModel); each names the element.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ModelError {
    /// The net has no transition, so nothing can ever happen.
    #[error("net `{net}` has no transitions")]
    NoTransitions { net: String },
    /// Something has an empty name.
    #[error("net `{net}` has {what} without a name")]
    EmptyName { net: String, what: &'static str },
    /// Two elements, or two declarations of one kind, have the same name.
    #[error("net `{net}`: the name `{name}` is used twice, for {first} and for {second}")]
    DuplicateName {
        net: String,
        name: String,
        first: &'static str,
        second: &'static str,
    },
    /// Something names an element that does not exist.
    #[error("net `{net}`: {user} names `{name}`, which is neither a place nor a transition")]
    UnknownName {
        net: String,
        user: String,
        name: String,
    },
    /// Something that needs a place names a transition.
    #[error("net `{net}`: {user} names the transition `{name}`; expected a place")]
    NotAPlace {
        net: String,
        user: String,
        name: String,
    },
    /// An arc joins two places or two transitions.
    #[error(
        "net `{net}`: the arc from `{from}` to `{to}` joins two {what}; expected a place and a transition"
    )]
    ArcBetweenEquals {
        net: String,
        from: String,
        to: String,
        /// `places` or `transitions`.
        what: &'static str,
    },
    /// An arc is declared twice.
    #[error("net `{net}`: the arc from `{from}` to `{to}` is declared twice")]
    DuplicateArc {
        net: String,
        from: String,
        to: String,
    },
    /// A transition marks a source, which only its event may mark.
    #[error("net `{net}`: transition `{transition}` marks the source `{place}`")]
    ArcIntoSource {
        net: String,
        place: String,
        transition: String,
    },
    /// A transition empties a sink, which only its consumer may empty.
    #[error("net `{net}`: transition `{transition}` takes from the sink `{place}`")]
    ArcOutOfSink {
        net: String,
        place: String,
        transition: String,
    },
    /// Nothing ever marks this internal place.
    #[error(
        "net `{net}`: place `{place}` is never marked: it has no incoming arc and no initial mark, and it is bound to no event or flag"
    )]
    UnboundSource { net: String, place: String },
    /// Nothing ever empties this internal place.
    #[error(
        "net `{net}`: place `{place}` is never emptied: it has no outgoing arc, it is in no declared end, and it is bound to no event or flag"
    )]
    UnboundSink { net: String, place: String },
    /// A place has no arc at all.
    #[error("net `{net}`: no arc touches the place `{place}`")]
    IsolatedPlace { net: String, place: String },
    /// A transition without inputs would fire for ever.
    #[error("net `{net}`: transition `{transition}` has no input")]
    TransitionWithoutInput { net: String, transition: String },
    /// A place is named twice where each place may be named once.
    #[error("net `{net}`: {user} names the place `{place}` twice")]
    PlaceNamedTwice {
        net: String,
        user: String,
        place: String,
    },
    /// An exclusion of fewer than two places excludes nothing.
    #[error("net `{net}`: exclusion `{exclusion}` has {found} places; expected at least two")]
    ExclusionTooSmall {
        net: String,
        exclusion: String,
        found: usize,
    },
    /// An end names a source or a sink; those are empty at an end.
    #[error("net `{net}`: end `{end}` names `{place}`, which is not internal")]
    EndNotInternal {
        net: String,
        end: String,
        place: String,
    },
    /// Two different flags of the net, or a flag and another event, would be the same event.
    #[error(
        "net `{net}`: `{first}` and `{second}` are bound to a flag and to something else, but both are called `{event}`"
    )]
    AmbiguousFlag {
        net: String,
        first: String,
        second: String,
        event: String,
    },
    /// The net is larger than its tables can be.
    #[error("net `{net}` has {found} {what}; at most {limit} fit")]
    TooLarge {
        net: String,
        what: &'static str,
        found: usize,
        limit: usize,
    },
    /// The event table is full.
    #[error("net `{net}`: {reason}")]
    Events { net: String, reason: TooManyEvents },
}
