//! How one robot stands with `acquire`.

/// How a robot stands with `acquire`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Answer {
    /// The coordination that asks it, and since when; none: none does, or it has answered.
    pub(super) asked: Option<(u64, u64)>,
    /// It did not answer before, and is left alone until then.
    pub(super) mute_until_ns: u64,
    /// The coordination that it did not answer last.
    pub(super) mute_in: u64,
}
