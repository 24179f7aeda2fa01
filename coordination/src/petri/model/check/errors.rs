//! What a check has found so far.

use alloc::borrow::ToOwned;
use alloc::string::String;
use alloc::vec::Vec;

use super::super::data::ModelData;
use super::super::error::ModelError;
use super::super::names::{Element, NameId};

pub(super) struct Check<'a> {
    pub(super) data: &'a ModelData,
    pub(super) errors: Vec<ModelError>,
}

impl Check<'_> {
    pub(super) fn net(&self) -> String {
        self.data.name.clone()
    }

    pub(super) fn owned(&self, name: NameId) -> String {
        self.data.name_of(name).to_owned()
    }

    /// The number of the place `name`, or an error and nothing.
    pub(super) fn place(&mut self, name: NameId, user: impl FnOnce() -> String) -> Option<usize> {
        match self.data.names.element(name) {
            Element::Place(number) => return Some(number as usize),
            Element::Transition(_) => self.errors.push(ModelError::NotAPlace {
                net: self.net(),
                user: user(),
                name: self.owned(name),
            }),
            Element::Unknown => self.errors.push(ModelError::UnknownName {
                net: self.net(),
                user: user(),
                name: self.owned(name),
            }),
        }
        None
    }

    pub(super) fn named_twice(&mut self, place: NameId, user: String) {
        self.errors.push(ModelError::PlaceNamedTwice {
            net: self.net(),
            user,
            place: self.owned(place),
        });
    }
}
