//! The compiled net.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use super::engine::{Layout, State, compile};
use super::id::{PlaceId, TransitionId};
use super::model::{Element, ModelData, ModelError, NetModel, PlaceKind, Structure};
use crate::event::{EventId, EventTable};

/// A net ready to run; see [the module](super). A clone is another handle to the same net.
#[derive(Clone, Debug)]
pub struct Net {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    data: Arc<ModelData>,
    structure: Structure,
    layout: Layout,
    initial: State,
    /// In the model's order.
    sources: Box<[(PlaceId, EventId)]>,
    /// In the model's order.
    sinks: Box<[(PlaceId, EventId)]>,
    /// Indices into `sources`, by event.
    sources_by_event: Box<[(EventId, u16)]>,
}

impl NetModel {
    /// Checks the model and makes the net, whose events are entered into `events`. Not for
    /// real-time threads.
    ///
    /// # Errors
    /// Everything that [`check`](Self::check) finds, or that the table is full.
    pub fn compile(&self, events: &mut EventTable) -> Result<Net, Vec<ModelError>> {
        Net::new(self.structure()?, Arc::clone(self.data()), events).map_err(|error| vec![error])
    }
}

impl Net {
    fn new(
        structure: Structure,
        data: Arc<ModelData>,
        events: &mut EventTable,
    ) -> Result<Self, ModelError> {
        let mut sources = Vec::new();
        let mut sinks = Vec::new();
        for (place, binding) in &data.bindings {
            let place = PlaceId::from_index(*place as usize);
            let event =
                events
                    .intern(&binding.event_name())
                    .map_err(|reason| ModelError::Events {
                        net: data.name.clone(),
                        reason,
                    })?;
            match structure.kind(place) {
                PlaceKind::Source => sources.push((place, event)),
                PlaceKind::Sink => sinks.push((place, event)),
                PlaceKind::Internal => {}
            }
        }
        let mut sources_by_event: Vec<_> = sources
            .iter()
            .enumerate()
            .map(|(index, &(_, event))| (event, index as u16))
            .collect();
        sources_by_event.sort_unstable();
        let (layout, initial) = compile(&structure, &sources, &sinks);
        Ok(Self {
            inner: Arc::new(Inner {
                data,
                structure,
                layout,
                initial,
                sources: sources.into(),
                sinks: sinks.into(),
                sources_by_event: sources_by_event.into(),
            }),
        })
    }

    /// The net's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.inner.data.name
    }

    /// The model that this net was made from; shared, not copied.
    #[must_use]
    pub fn model(&self) -> NetModel {
        NetModel::from_data(Arc::clone(&self.inner.data))
    }

    /// The inputs, outputs, kinds and initial marks in numbers.
    #[must_use]
    pub fn structure(&self) -> &Structure {
        &self.inner.structure
    }

    /// The place called `name`.
    #[must_use]
    pub fn place_id(&self, name: &str) -> Option<PlaceId> {
        match self.inner.data.names.find(name) {
            Element::Place(number) => Some(PlaceId::from_index(number as usize)),
            _ => None,
        }
    }

    /// The name of a place, or `?` for an id of another net.
    #[must_use]
    pub fn place_name(&self, place: PlaceId) -> &str {
        let data = &self.inner.data;
        let place = data.places.get(place.index());
        place.map_or("?", |&name| data.name_of(name))
    }

    /// The transition called `name`.
    #[must_use]
    pub fn transition_id(&self, name: &str) -> Option<TransitionId> {
        match self.inner.data.names.find(name) {
            Element::Transition(number) => Some(TransitionId::from_index(number as usize)),
            _ => None,
        }
    }

    /// The name of a transition, or `?` for an id of another net.
    #[must_use]
    pub fn transition_name(&self, transition: TransitionId) -> &str {
        let data = &self.inner.data;
        let transition = data.transitions.get(transition.index());
        transition.map_or("?", |&name| data.name_of(name))
    }

    /// All places, in the model's order.
    #[must_use]
    pub fn places(&self) -> impl ExactSizeIterator<Item = PlaceId> + Clone + use<> {
        self.inner.structure.places()
    }

    /// All transitions, in the model's order.
    #[must_use]
    pub fn transitions(&self) -> impl ExactSizeIterator<Item = TransitionId> + Clone + use<> {
        self.inner.structure.transitions()
    }

    /// The sources and the events that fill them, in the model's order.
    #[must_use]
    pub fn sources(&self) -> &[(PlaceId, EventId)] {
        &self.inner.sources
    }

    /// The sinks and the events that they produce, in the model's order.
    #[must_use]
    pub fn sinks(&self) -> &[(PlaceId, EventId)] {
        &self.inner.sinks
    }

    /// The places that are marked initially, in the model's order.
    pub fn initial_marking(&self) -> impl Iterator<Item = PlaceId> {
        self.places()
            .filter(|&place| self.inner.structure.marked(place))
    }

    #[inline]
    pub(super) fn layout(&self) -> &Layout {
        &self.inner.layout
    }

    pub(super) fn initial(&self) -> &State {
        &self.inner.initial
    }

    /// The sources, as indices into [`sources`](Self::sources), that `event` fills.
    pub(super) fn filled_by(&self, event: EventId) -> &[(EventId, u16)] {
        let all = &*self.inner.sources_by_event;
        let from = all.partition_point(|&(other, _)| other < event);
        let to = from + all[from..].partition_point(|&(other, _)| other == event);
        &all[from..to]
    }
}
