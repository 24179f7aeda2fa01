//! What can be wrong when a net is bound to protocols.

use thiserror::Error;

use crate::analysis::Reason;
use crate::petri::Executor;

/// Why a net does not fit the protocols given.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum BindError {
    /// A place hangs on what the sides given do not have.
    #[error(transparent)]
    Place(#[from] Box<Reason>),
    /// The proof is one of another net.
    #[error(
        "the proof is one of net `{proved}` with other places, transitions or marks, not of this net `{net}`"
    )]
    OtherModel { net: String, proved: String },
    /// A side is of another protocol, or of another party, than the proof has under that name.
    #[error(
        "the side given for `{protocol}` is of another protocol or another party than in the net's proof"
    )]
    OtherProtocol { protocol: String },
    /// The proof knows of no protocol with that name.
    #[error("protocol `{protocol}` is not part of the net's proof")]
    NotInProof { protocol: String },
    /// There is no side for a protocol of the proof.
    #[error("no side is given for protocol `{protocol}`, which is part of the net's proof")]
    NoSide { protocol: String },
    /// A place to be marked is none of the net.
    #[error("the net has no place or source number {place}")]
    UnknownPlace { place: u16 },
    /// More events are to wait for a source than may.
    #[error(
        "{found} events are to wait for source {place}, of at most {}",
        Executor::MAX_WAITING
    )]
    TooManyWait { place: u16, found: u32 },
    /// The analysis never looked at the state in which the net is to begin.
    #[error(
        "net `{net}` never comes to where it is to begin, so nothing is proved of that: marked are {marked}; set are {positions}"
    )]
    NotReached {
        net: String,
        marked: String,
        positions: String,
    },
}
