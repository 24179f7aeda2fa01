//! Nets in names, and what a checked one is in numbers.

mod binding;
mod check;
mod data;
mod error;
#[cfg(feature = "serde")]
mod form;
mod lists;
mod names;
mod net_model;
mod structure;

pub use binding::{Binding, PlaceKind};
pub(super) use data::ModelData;
pub use error::ModelError;
pub(super) use names::Element;
pub use net_model::{NetModel, Place, PlaceSet, Transition};
pub(super) use structure::Arcs;
pub use structure::Structure;
