//! What can be wrong with a map's data.

use crate::borders::MAX_AREAS;
use description::geometry::Segment;

/// What is wrong with a map's data.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// A name is used twice.
    #[error("two {kind}s are called `{id}`")]
    Duplicate {
        /// Wall, lane or area.
        kind: &'static str,
        /// The name.
        id: String,
    },
    /// A wall or lane has no length, or a number is not finite.
    #[error("{kind} `{id}` must have a finite length above zero")]
    NoLength {
        /// Wall or lane.
        kind: &'static str,
        /// The name.
        id: String,
    },
    /// A name that nothing has.
    #[error("{kind} `{id}` names the {wanted} `{name}`, which does not exist")]
    Unknown {
        /// What names it.
        kind: &'static str,
        /// Its name.
        id: String,
        /// What is named.
        wanted: &'static str,
        /// The name that nothing has.
        name: String,
    },
    /// The end wall lies beside or behind the lane.
    #[error(
        "wall `{wall}` does not close lane `{lane}`: it must cross the lane's line ahead of its start"
    )]
    NotAcross {
        /// The lane.
        lane: String,
        /// The wall.
        wall: String,
    },
    /// An area's corners are in the wrong order, or a number is not finite.
    #[error("area `{id}` must have finite corners, the smaller coordinates first")]
    Region {
        /// The area.
        id: String,
    },
    /// More areas than a set of areas holds.
    #[error("{found} areas; expected at most {MAX_AREAS}")]
    TooManyAreas {
        /// Found.
        found: usize,
    },
    /// A limit of an area is not a positive number.
    #[error("{what} of area `{id}` must be positive, found {found}")]
    Limit {
        /// The area.
        id: String,
        /// Which limit.
        what: &'static str,
        /// Found.
        found: f64,
    },
}

pub(super) fn check_length(kind: &'static str, id: &str, line: &Segment) -> Result<(), MapError> {
    if line.a.is_finite() && line.b.is_finite() && line.length_m() > 1e-6 {
        return Ok(());
    }
    let id = id.to_owned();
    Err(MapError::NoLength { kind, id })
}
