//! Numbers in the place of names.

/// A dense place id, valid in the [`Net`](super::Net) that gave it; ids count in the model's order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlaceId(pub u16);

impl PlaceId {
    /// The id as an index into an array with one entry per place.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    pub(super) fn from_index(index: usize) -> Self {
        Self(index as u16)
    }
}

/// A dense transition id, valid in the [`Net`](super::Net) that gave it; ids count in the model's order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TransitionId(pub u16);

impl TransitionId {
    /// The id as an index into an array with one entry per transition.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    pub(super) fn from_index(index: usize) -> Self {
        Self(index as u16)
    }
}
