//! What can be wrong with a net's model.

use thiserror::Error;

use crate::event::TooManyEvents;

/// What is wrong with a [`NetModel`](super::NetModel); each names the element.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The net has no transition, so nothing can ever happen.
    #[error("net `{net}` has no transitions")]
    NoTransitions {
        /// The net's name.
        net: String,
    },
    /// Something has an empty name.
    #[error("net `{net}` has {what} without a name")]
    EmptyName {
        /// The net's name.
        net: String,
        /// Which kind of thing has no name.
        what: &'static str,
    },
    /// Two elements, or two declarations of one kind, have the same name.
    #[error("net `{net}`: the name `{name}` is used twice, for {first} and for {second}")]
    DuplicateName {
        /// The net's name.
        net: String,
        /// The name used twice.
        name: String,
        /// What was declared first under that name.
        first: &'static str,
        /// What was declared later.
        second: &'static str,
    },
    /// Something names an element that does not exist.
    #[error("net `{net}`: {user} names `{name}`, which is neither a place nor a transition")]
    UnknownName {
        /// The net's name.
        net: String,
        /// Where the name is used.
        user: String,
        /// The unknown name.
        name: String,
    },
    /// Something that needs a place names a transition.
    #[error("net `{net}`: {user} names the transition `{name}`; expected a place")]
    NotAPlace {
        /// The net's name.
        net: String,
        /// Where the name is used.
        user: String,
        /// The transition's name.
        name: String,
    },
    /// An arc joins two places or two transitions.
    #[error(
        "net `{net}`: the arc from `{from}` to `{to}` joins two {what}; expected a place and a transition"
    )]
    ArcBetweenEquals {
        /// The net's name.
        net: String,
        /// Where the arc begins.
        from: String,
        /// Where the arc ends.
        to: String,
        /// `places` or `transitions`.
        what: &'static str,
    },
    /// An arc is declared twice.
    #[error("net `{net}`: the arc from `{from}` to `{to}` is declared twice")]
    DuplicateArc {
        /// The net's name.
        net: String,
        /// Where the arc begins.
        from: String,
        /// Where the arc ends.
        to: String,
    },
    /// A transition marks a source, which only its event may mark.
    #[error("net `{net}`: transition `{transition}` marks the source `{place}`")]
    ArcIntoSource {
        /// The net's name.
        net: String,
        /// The source.
        place: String,
        /// The transition.
        transition: String,
    },
    /// A transition empties a sink, which only its consumer may empty.
    #[error("net `{net}`: transition `{transition}` takes from the sink `{place}`")]
    ArcOutOfSink {
        /// The net's name.
        net: String,
        /// The sink.
        place: String,
        /// The transition.
        transition: String,
    },
    /// Nothing ever marks this internal place.
    #[error(
        "net `{net}`: place `{place}` is never marked: it has no incoming arc and no initial mark, and it is bound to no event or flag"
    )]
    UnboundSource {
        /// The net's name.
        net: String,
        /// The place.
        place: String,
    },
    /// Nothing ever empties this internal place.
    #[error(
        "net `{net}`: place `{place}` is never emptied: it has no outgoing arc, it is in no declared end, and it is bound to no event or flag"
    )]
    UnboundSink {
        /// The net's name.
        net: String,
        /// The place.
        place: String,
    },
    /// A place has no arc at all.
    #[error("net `{net}`: no arc touches the place `{place}`")]
    IsolatedPlace {
        /// The net's name.
        net: String,
        /// The place.
        place: String,
    },
    /// A transition without inputs would fire for ever.
    #[error("net `{net}`: transition `{transition}` has no input")]
    TransitionWithoutInput {
        /// The net's name.
        net: String,
        /// The transition.
        transition: String,
    },
    /// A place is named twice where each place may be named once.
    #[error("net `{net}`: {user} names the place `{place}` twice")]
    PlaceNamedTwice {
        /// The net's name.
        net: String,
        /// Where it is named.
        user: String,
        /// The place.
        place: String,
    },
    /// An exclusion of fewer than two places excludes nothing.
    #[error("net `{net}`: exclusion `{exclusion}` has {found} places; expected at least two")]
    ExclusionTooSmall {
        /// The net's name.
        net: String,
        /// The exclusion.
        exclusion: String,
        /// How many places it has.
        found: usize,
    },
    /// An end names a source or a sink; those are empty at an end.
    #[error("net `{net}`: end `{end}` names `{place}`, which is not internal")]
    EndNotInternal {
        /// The net's name.
        net: String,
        /// The end.
        end: String,
        /// The source or sink.
        place: String,
    },
    /// Two different flags of the net, or a flag and another event, would be the same event.
    #[error(
        "net `{net}`: `{first}` and `{second}` are bound to a flag and to something else, but both are called `{event}`"
    )]
    AmbiguousFlag {
        /// The net's name.
        net: String,
        /// The place bound first.
        first: String,
        /// The place bound later.
        second: String,
        /// The event that both would be.
        event: String,
    },
    /// The net is larger than its tables can be.
    #[error("net `{net}` has {found} {what}; at most {limit} fit")]
    TooLarge {
        /// The net's name.
        net: String,
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many fit.
        limit: usize,
    },
    /// The event table is full.
    #[error("net `{net}`: {reason}")]
    Events {
        /// The net's name.
        net: String,
        /// Which event found no room.
        reason: TooManyEvents,
    },
}
