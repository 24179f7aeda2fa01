//! The words of our `toolspecific` elements, for both directions.

/// The tool.
pub(super) const TOOL: &str = "coordination";
/// The version of what stands inside.
pub(super) const VERSION: &str = "1";

/// In a place: it is filled from outside.
pub(super) const SOURCE: &str = "source";
/// In a place: it is emptied from outside.
pub(super) const SINK: &str = "sink";
/// What a source or sink is bound to: an event, or a flag of a protocol.
pub(super) const EVENT: &str = "event";
pub(super) const PROTOCOL: &str = "protocol";
pub(super) const FLAG: &str = "flag";

/// In a net: a set of places of which one at most is marked.
pub(super) const EXCLUSION: &str = "exclusion";
/// In a net: a marking in which it may rest.
pub(super) const END: &str = "end";
/// The name of an exclusion or end, and the ids of its places, each in an element of its own.
pub(super) const NAME: &str = "name";
pub(super) const PLACE: &str = "place";
pub(super) const REF: &str = "ref";
/// In a net: it may fire for ever without news from outside.
pub(super) const ENDLESS: &str = "endless";
/// In a net: texts count to the last space, as [`Document`](super::Document) writes them.
pub(super) const VERBATIM: &str = "verbatim";
