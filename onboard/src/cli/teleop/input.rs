//! What a keyboard or a gamepad says.

use description::geometry::Twist2;

/// What somebody does at this end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Input {
    /// Wants this motion; to stand, when no dead-man is held.
    Wants(Twist2),
    /// Wants faults to be forgotten.
    Reset,
    /// Leaves.
    Leaves,
    /// Nothing new.
    Nothing,
}
