//! The two ways in which a net is laid out.

use alloc::boxed::Box;

use super::blocks;
use super::evaluation::Allowance;
use super::id::PlaceId;
use super::masks;
use super::model::Structure;
use super::ports::Ports;
use crate::event::EventId;

/// The constant tables of a net.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Without a transition if the net is laid out in blocks.
    masks: masks::Layout,
    blocks: Option<Box<blocks::Layout>>,
}

/// The marking of a net, and what is kept beside it.
#[derive(Clone, Debug)]
pub(super) struct State {
    masks: masks::State,
    blocks: Option<Box<blocks::State>>,
}

/// The tables of `structure`, and its state in the initial marking. `sources` and `sinks` are in the
/// order of their places.
#[inline(always)]
pub(super) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> (Layout, State) {
    match masks::compile(structure, sources, sinks) {
        Some((layout, state)) => (
            Layout {
                masks: layout,
                blocks: None,
            },
            State {
                masks: state,
                blocks: None,
            },
        ),
        None => in_blocks(structure, sources, sinks),
    }
}

#[cold]
fn in_blocks(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> (Layout, State) {
    let masks = masks::nothing();
    let (layout, state) = blocks::compile(structure, sources, sinks);
    (
        Layout {
            masks: masks.0,
            blocks: Some(Box::new(layout)),
        },
        State {
            masks: masks.1,
            blocks: Some(Box::new(state)),
        },
    )
}

impl State {
    #[inline]
    pub(super) fn is_marked(&self, layout: &Layout, place: PlaceId) -> bool {
        match (&self.blocks, &layout.blocks) {
            (Some(state), Some(layout)) => state.is_marked(layout, place),
            _ => self.masks.is_marked(&layout.masks, place),
        }
    }

    /// Marks a place that is empty or empties one that is marked. Between two evaluations only.
    #[inline]
    pub(super) fn flip(&mut self, layout: &Layout, place: PlaceId) {
        match (&mut self.blocks, &layout.blocks) {
            (Some(state), Some(layout)) => state.flip(layout, place),
            _ => self.masks.flip(&layout.masks, place),
        }
    }

    /// Makes this a copy of a state of the same net.
    pub(super) fn copy_from(&mut self, other: &Self) {
        match (&mut self.blocks, &other.blocks) {
            (Some(state), Some(other)) => state.copy_from(other),
            _ => self.masks.copy_from(&other.masks),
        }
    }

    /// Fires one transition, if it is known which is next and no source is to be filled before, and returns
    /// which, and whether something is left to do then. Not in a net laid out in blocks.
    #[inline(always)]
    pub(super) fn step(&mut self, layout: &Layout, ports: &mut Ports) -> Option<(usize, bool)> {
        self.masks.step(&layout.masks, ports)
    }

    /// As [`step`](Self::step), in a net laid out in blocks: not if the next one needs several shared
    /// places.
    pub(super) fn step_in_blocks(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        looks: u32,
    ) -> Option<(usize, bool)> {
        let (state, layout) = (self.blocks.as_mut()?, layout.blocks.as_ref()?);
        if ports.can_fill() {
            return None;
        }
        let (fired, enabled) = state.step(layout, ports, looks)?;
        Some((fired, enabled || ports.can_fill()))
    }

    /// Fires as far as `left` allows, and uses it up. Returns whether a transition is enabled, or may
    /// be, if the search for one was cut short.
    #[inline]
    pub(super) fn run(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        left: &mut Allowance,
        on_fire: impl FnMut(usize),
    ) -> bool {
        match (&mut self.blocks, &layout.blocks) {
            (Some(state), Some(layout)) => state.run(layout, ports, left, on_fire),
            _ => self.masks.run(&layout.masks, ports, left, on_fire),
        }
    }
}
