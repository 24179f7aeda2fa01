//! Lays a net out; see [blocks](crate::petri::blocks).

use super::firings::Firings;
use super::tables::Tables;
use crate::event::EventId;
use crate::petri::blocks::layout::Layout;
use crate::petri::blocks::state::State;
use crate::petri::id::PlaceId;
use crate::petri::model::Structure;

/// The tables of `structure`, and its state in the initial marking. `sources` and `sinks` are in the
/// order of their places.
pub(in crate::petri) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> (Layout, State) {
    let has_ports = !sources.is_empty() || !sinks.is_empty();
    let mut tables = Tables::new(structure);
    for block in 0..tables.blocks.len() {
        tables.add_block(block, structure, has_ports);
    }
    tables.add_flips_of_others();
    Firings::of(tables, structure, sources, sinks)
}
