//! What can be wrong when a net is bound to protocols.

use thiserror::Error;

use crate::protocol::{ABORTED, FlagId, Party, Protocol};

/// Why a net does not fit the protocols given.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum BindError {
    /// Two sides were given the same name.
    #[error("two protocols are called `{protocol}`")]
    DuplicateProtocol { protocol: String },
    /// A binding names a protocol that was not given.
    #[error("place `{place}` names the unknown protocol `{protocol}`; known protocols: {known}")]
    UnknownProtocol {
        /// The place that names it.
        place: String,
        /// The unknown name.
        protocol: String,
        known: String,
    },
    /// A binding names a flag that the protocol does not have.
    #[error(
        "place `{place}` names the unknown flag `{flag}` of protocol `{protocol}`; its flags: {known}"
    )]
    UnknownFlag {
        /// The place that names it.
        place: String,
        /// The protocol.
        protocol: String,
        flag: String,
        known: String,
    },
    /// What sets a flag must be on its owner's side, and what reads it on the other.
    #[error(
        "place `{place}` is bound to flag `{flag}` of protocol `{protocol}`, which `{owner}` sets"
    )]
    WrongOwner {
        /// The place.
        place: String,
        /// The protocol.
        protocol: String,
        flag: String,
        owner: String,
    },
    /// Something is bound to the abort of a protocol that the other party cannot abort.
    #[error(
        "place `{place}` is bound to `{ABORTED}` of protocol `{protocol}`, whose keeper is not across"
    )]
    NeverAborted {
        /// The place.
        place: String,
        /// The protocol.
        protocol: String,
    },
    /// A flag fills several sources although its run can be aborted, which could then not take it
    /// back from all of them.
    #[error(
        "flag `{flag}` of protocol `{protocol}` fills several sources, but the other party can abort its run; \
         bind one source"
    )]
    SeveralSources { protocol: String, flag: String },
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

/// Who uses a flag: the party that sets it, or the one that reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Sets,
    Reads,
}

/// What the other half of `<protocol>.<flag>` stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Named {
    Flag(FlagId),
    Abort,
}

/// Finds `flag` in `protocol`, called `name` here, for the side of `party`.
pub(super) fn find_flag(
    place: &str,
    (name, protocol): (&str, &Protocol),
    party: Party,
    role: Role,
    flag: &str,
) -> Result<Named, BindError> {
    if flag == ABORTED {
        return if role == Role::Reads && protocol.keeper() == Some(party.other()) {
            Ok(Named::Abort)
        } else {
            Err(BindError::NeverAborted {
                place: place.to_owned(),
                protocol: name.to_owned(),
            })
        };
    }
    let Some(id) = protocol.flag(flag) else {
        let known: Vec<_> = protocol.flags().map(|(_, flag, _)| flag).collect();
        return Err(BindError::UnknownFlag {
            place: place.to_owned(),
            protocol: name.to_owned(),
            flag: flag.to_owned(),
            known: known.join(", "),
        });
    };
    let setter = match role {
        Role::Sets => party,
        Role::Reads => party.other(),
    };
    match protocol.owner(id) {
        Some(owner) if owner != setter => Err(BindError::WrongOwner {
            place: place.to_owned(),
            protocol: name.to_owned(),
            flag: flag.to_owned(),
            owner: protocol.party_name(owner).to_owned(),
        }),
        _ => Ok(Named::Flag(id)),
    }
}

/// The most flags that one run sets.
pub(super) fn longest_run(protocol: &Protocol) -> u16 {
    let depths = protocol.positions().map(|at| protocol.progress(at));
    depths.max().unwrap_or(0)
}

/// All names that occur a second time.
pub(super) fn duplicates<'a>(names: impl Iterator<Item = &'a str>) -> Vec<BindError> {
    let mut seen = std::collections::HashSet::new();
    names
        .filter(|&name| !seen.insert(name))
        .map(|name| BindError::DuplicateProtocol {
            protocol: name.to_owned(),
        })
        .collect()
}
