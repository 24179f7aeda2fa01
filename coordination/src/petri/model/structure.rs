//! A checked model in numbers.

use alloc::boxed::Box;
use core::ops::Range;

use super::binding::PlaceKind;
use super::lists::Use;
use crate::petri::id::{PlaceId, TransitionId};

/// A checked model in numbers: what every form of execution or analysis begins with. Places and
/// transitions count in the order of declaration.
#[derive(Clone, Debug)]
pub struct Structure {
    pub(in crate::petri) kinds: Box<[PlaceKind]>,
    pub(in crate::petri) marked: Box<[bool]>,
    /// Where the places of each transition begin: at twice its index the inputs, behind that the
    /// outputs; at last the end of all.
    pub(in crate::petri) starts: Box<[u32]>,
    pub(in crate::petri) places: Box<[PlaceId]>,
    /// Whether some place is input and output of the same transition, by transition.
    pub(in crate::petri) self_loops: Box<[bool]>,
    /// By place.
    pub(in crate::petri) uses: Box<[Use]>,
}

/// The arcs of one transition.
#[derive(Clone, Copy)]
pub(in crate::petri) struct Arcs<'a> {
    /// First the inputs, then the outputs.
    pub(in crate::petri) places: &'a [PlaceId],
    /// How many are inputs.
    pub(in crate::petri) inputs: usize,
    /// Whether some place is both.
    pub(in crate::petri) has_self_loop: bool,
}

impl Structure {
    /// How many places there are.
    #[must_use]
    pub fn place_count(&self) -> usize {
        self.kinds.len()
    }

    /// How many transitions there are.
    #[must_use]
    pub fn transition_count(&self) -> usize {
        self.self_loops.len()
    }

    /// All transitions.
    pub fn transitions(&self) -> impl ExactSizeIterator<Item = TransitionId> + Clone + use<> {
        (0..self.transition_count()).map(TransitionId::from_index)
    }

    /// All places.
    pub fn places(&self) -> impl ExactSizeIterator<Item = PlaceId> + Clone + use<> {
        (0..self.place_count()).map(PlaceId::from_index)
    }

    /// The input places of a transition, in the order of declaration; none for an id of another net.
    #[must_use]
    pub fn inputs(&self, transition: TransitionId) -> &[PlaceId] {
        self.list(2 * transition.index())
    }

    /// The output places of a transition, in the order of declaration; none for an id of another net.
    #[must_use]
    pub fn outputs(&self, transition: TransitionId) -> &[PlaceId] {
        self.list(2 * transition.index() + 1)
    }

    fn list(&self, number: usize) -> &[PlaceId] {
        match self.starts.get(number..number + 2) {
            Some(&[from, to]) => &self.places[from as usize..to as usize],
            _ => &[],
        }
    }

    /// The arcs of all transitions, in order.
    pub(in crate::petri) fn arcs(&self) -> impl Iterator<Item = Arcs<'_>> {
        (0..self.transition_count()).map(|transition| self.arcs_of(transition))
    }

    /// Inputs and outputs of these transitions, in order.
    #[inline]
    pub(in crate::petri) fn arcs_among(
        &self,
        transitions: Range<usize>,
    ) -> impl Iterator<Item = (&[PlaceId], &[PlaceId])> {
        let starts = &self.starts[2 * transitions.start..=2 * transitions.end];
        let mut start = starts[0] as usize;
        let places = &*self.places;
        { starts[1..].as_chunks::<2>().0.iter() }.map(move |ends| {
            let [middle, end] = ends.map(|end| end as usize);
            let lists = (&places[start..middle], &places[middle..end]);
            start = end;
            lists
        })
    }

    pub(in crate::petri) fn arcs_of(&self, transition: usize) -> Arcs<'_> {
        let ends = &self.starts[2 * transition..2 * transition + 3];
        Arcs {
            places: &self.places[ends[0] as usize..ends[2] as usize],
            inputs: (ends[1] - ends[0]) as usize,
            has_self_loop: self.self_loops[transition],
        }
    }

    /// Who marks and empties a place.
    ///
    /// # Panics
    /// For an id of another net that has more places.
    #[must_use]
    pub fn kind(&self, place: PlaceId) -> PlaceKind {
        self.kinds[place.index()]
    }

    /// Whether a place is marked initially; not for an id of another net.
    #[must_use]
    pub fn marked(&self, place: PlaceId) -> bool {
        self.marked.get(place.index()).is_some_and(|&marked| marked)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::EventTable;
    use crate::petri::NetModel;

    #[test]
    fn an_id_of_a_larger_net_has_nothing() {
        let mut net = NetModel::new("light");
        net.place("red").mark("red").place("green");
        net.transition("go", &["red"], &["green"]);
        net.transition("halt", &["green"], &["red"]);
        let net = net.compile(&mut EventTable::new()).unwrap();
        let structure = net.structure();
        assert_eq!(structure.inputs(TransitionId(1)), [PlaceId(1)]);
        assert_eq!(structure.outputs(TransitionId(1)), [PlaceId(0)]);
        assert!(structure.marked(PlaceId(0)));
        for foreign in [2, 3, u16::MAX] {
            assert_eq!(structure.inputs(TransitionId(foreign)), []);
            assert_eq!(structure.outputs(TransitionId(foreign)), []);
            assert!(!structure.marked(PlaceId(foreign)));
        }
    }
}
