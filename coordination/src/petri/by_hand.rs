//! One transition at a time: whether it is enabled, why not, and firing it.
//!
//! For tools, tests and those who choose by a rule of their own. [`Executor::evaluate`] chooses by itself.

use alloc::format;
use alloc::string::{String, ToString};

use thiserror::Error;

use super::executor::{Executor, fill_sources};
use super::id::{PlaceId, TransitionId};
use super::model::PlaceKind;
use super::net::Net;
use crate::event::EventId;

/// What keeps a transition from firing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[non_exhaustive]
pub enum Obstacle {
    /// The net has no such transition.
    #[error("the net has no transition {}", .0.0)]
    Unknown(TransitionId),
    /// An input is empty, and no event waits to fill it.
    #[error("input place {} is empty", .0.0)]
    Empty(PlaceId),
    /// An output that is no input is full; if it is a sink, its consumer has not taken the token.
    #[error("output place {} is full", .0.0)]
    Full(PlaceId),
}

impl Obstacle {
    /// In the names of the net. Allocates.
    #[must_use]
    pub fn describe(self, net: &Net) -> String {
        let known = |place: PlaceId| {
            let is_known = place.index() < net.places().len();
            is_known.then(|| net.structure().kind(place))
        };
        match self {
            Self::Unknown(_) => self.to_string(),
            Self::Empty(place) => match known(place) {
                Some(PlaceKind::Source) => format!("no event fills `{}`", net.place_name(place)),
                _ => format!("`{}` is empty", net.place_name(place)),
            },
            Self::Full(place) => match known(place) {
                Some(PlaceKind::Sink) => format!("nobody has taken `{}`", net.place_name(place)),
                _ => format!("`{}` is full", net.place_name(place)),
            },
        }
    }
}

impl Executor {
    /// Whether `transition` could fire next, once empty sources are filled with what waits for them.
    /// Looks at its arcs.
    #[must_use]
    pub fn is_enabled(&self, transition: TransitionId) -> bool {
        self.why_not(transition).next().is_none()
    }

    /// The enabled transitions, in the model's order. Looks at every transition.
    pub fn enabled(&self) -> impl Iterator<Item = TransitionId> {
        let all = self.net().transitions();
        all.filter(|&transition| self.is_enabled(transition))
    }

    /// All that keeps `transition` from firing: empty inputs, then full outputs, each in the order of
    /// declaration; nothing if it is enabled. Looks at its arcs.
    pub fn why_not(&self, transition: TransitionId) -> impl Iterator<Item = Obstacle> {
        let structure = self.net().structure();
        let is_known = transition.index() < structure.transition_count();
        let (inputs, outputs) = match is_known {
            true => (structure.inputs(transition), structure.outputs(transition)),
            false => (&[][..], &[][..]),
        };
        let is_empty = |&place: &PlaceId| !self.is_marked(place) && self.waiting(place) == 0;
        let is_full = |&place: &PlaceId| self.is_marked(place) && !inputs.contains(&place);
        let unknown = (!is_known).then_some(Obstacle::Unknown(transition));
        let empty = inputs.iter().copied().filter(is_empty);
        let full = outputs.iter().copied().filter(is_full);
        { unknown.into_iter() }
            .chain(empty.map(Obstacle::Empty))
            .chain(full.map(Obstacle::Full))
    }

    /// Fires `transition`, after filling empty sources as an evaluation does. The order of choice goes on
    /// where it was. Costs the arcs of the transition and the sources that are filled.
    ///
    /// ```
    /// use coordination::event::EventTable;
    /// use coordination::petri::{NetModel, Obstacle};
    ///
    /// let mut model = NetModel::new("lamp");
    /// model.place("off").mark("off").place("on");
    /// model.transition("switch on", &["off"], &["on"]);
    /// model.transition("switch off", &["on"], &["off"]);
    /// let net = model.compile(&mut EventTable::new()).expect("the model is sound");
    /// let [on, off] = ["switch on", "switch off"].map(|name| net.transition_id(name).expect("declared"));
    ///
    /// let mut lamp = net.executor();
    /// let error = lamp.fire(off).unwrap_err();
    /// assert_eq!(error.describe(&net), "`on` is empty");
    /// lamp.fire(on)?;
    /// assert_eq!(lamp.enabled().collect::<Vec<_>>(), [off]);
    /// # Ok::<(), Obstacle>(())
    /// ```
    ///
    /// # Errors
    /// The first [`Obstacle`] if it is not enabled; then nothing has changed.
    pub fn fire(&mut self, transition: TransitionId) -> Result<(), Obstacle> {
        if let Some(obstacle) = self.why_not(transition).next() {
            return Err(obstacle);
        }
        let Self {
            net, state, ports, ..
        } = self;
        fill_sources(net, state, ports);
        let structure = net.structure();
        let (inputs, outputs) = (structure.inputs(transition), structure.outputs(transition));
        let find = |list: &[(PlaceId, EventId)], place| {
            list.binary_search_by_key(&place, |&(place, _)| place).ok()
        };
        for &place in inputs.iter().filter(|place| !outputs.contains(place)) {
            state.flip(net.layout(), place);
            if let Some(source) = find(net.sources(), place) {
                ports.emptied(source);
            }
        }
        for &place in outputs.iter().filter(|place| !inputs.contains(place)) {
            state.flip(net.layout(), place);
            if let Some(sink) = find(net.sinks(), place) {
                ports.filled(sink);
            }
        }
        self.firings = self.firings.wrapping_add(1);
        Ok(())
    }
}
