//! The names of the grammar that is read and written.

/// The namespace of PNML.
pub(super) const NAMESPACE: &str = "http://www.pnml.org/version-2009/grammar/pnml";
/// The type of place/transition nets.
pub(super) const PT_NET: &str = "http://www.pnml.org/version-2009/grammar/ptnet";
