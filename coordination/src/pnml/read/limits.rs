//! How large a document may be.

/// The longest document that is read, in bytes: more than four million arcs as
/// [`Document`](crate::pnml::Document) writes them.
pub const MAX_BYTES: usize = 512 << 20;
/// How deep pages may nest. No drawing has half as many levels.
pub const MAX_DEPTH: usize = 64;
/// Elements, texts and comments: some for each of the most arcs, and less than 2 GiB of memory for the
/// tree of a document.
pub(super) const MAX_NODES: u32 = 1 << 24;
