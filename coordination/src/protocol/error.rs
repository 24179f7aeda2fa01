//! What can be wrong with a model.

use alloc::boxed::Box;
use alloc::string::String;

use thiserror::Error;

use super::tree::ABORTED;

/// What is wrong with a [`ProtocolModel`](super::ProtocolModel); every message begins with the protocol's name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("protocol `{protocol}`{problem}")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct ModelError {
    pub protocol: String,
    pub problem: Box<Problem>,
}

/// One thing that can be wrong with a [`ProtocolModel`](super::ProtocolModel).
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum Problem {
    /// The model has no array.
    #[error(" has no arrays")]
    NoArrays,
    /// The protocol's name is empty.
    #[error(" has no name")]
    NoName,
    /// Something in it has an empty name.
    #[error(" has {what} without a name")]
    EmptyName { what: &'static str },
    /// Both parties have the same name.
    #[error(": both parties are called `{party}`")]
    SameParties { party: String },
    /// A name that is not one of the two parties.
    #[error(": {place} names the unknown party `{found}`; expected `{first}` or `{second}`")]
    UnknownParty {
        place: String,
        found: String,
        first: String,
        second: String,
    },
    /// Two different parties were made the keeper.
    #[error(" has two keepers, `{first}` and `{second}`")]
    TwoKeepers { first: String, second: String },
    /// Two arrays have the same name.
    #[error(" has two arrays named `{array}`")]
    DuplicateArray { array: String },
    /// An array without entries.
    #[error(": array `{array}` has no entries")]
    EmptyArray { array: String },
    /// A name that is not an array.
    #[error(": {place} names the unknown array `{found}`; known arrays: {known}")]
    UnknownArray {
        place: String,
        found: String,
        known: String,
    },
    /// One flag has two owners.
    #[error(": flag `{flag}` belongs to `{first}` and to `{second}`")]
    TwoOwners {
        flag: String,
        first: String,
        second: String,
    },
    /// A flag has the name that stands for an abort.
    #[error(": no flag can be called `{ABORTED}`, which is what an aborted run is called")]
    ReservedName,
    /// Alternatives begin with the same flag, so that nobody can tell them apart.
    #[error(
        ": {place} can go on with `{first}` or `{second}`, which both begin with flag `{flag}`"
    )]
    SameFlag {
        place: String,
        first: String,
        second: String,
        flag: String,
    },
    /// Alternatives begin with flags of different parties, so that both could choose at once.
    #[error(
        ": {place} can go on with `{first}`, begun by `{first_owner}`, or `{second}`, begun by `{second_owner}`; one party must choose"
    )]
    TwoChoose {
        place: String,
        first: String,
        first_owner: String,
        second: String,
        second_owner: String,
    },
    /// An array is followed, in the end, by itself.
    #[error(": array `{array}` would follow itself; a run must end")]
    Cycle { array: String },
    /// No path leads to an array.
    #[error(": no path from the beginning leads to array `{array}`")]
    Unreachable { array: String },
    /// A flag would be set twice in one run.
    #[error(": flag `{flag}` of array `{array}` is already set when the run gets there")]
    SetTwice { flag: String, array: String },
    /// There are more positions than fit.
    #[error(" has more than {limit} positions, counted along every path")]
    TooLarge { limit: usize },
}
