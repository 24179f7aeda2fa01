//! A model as it is written down, for serde. Wrong ones are read too: their
//! [check](super::NetModel::check) says what is wrong.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::binding::{Binding, PlaceKind};
use super::net_model::NetModel;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Form {
    name: String,
    #[serde(default, skip_serializing_if = "is_false")]
    endless: bool,
    places: Vec<PlaceForm>,
    #[serde(default)]
    transitions: Vec<TransitionForm>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    exclusions: Vec<SetForm>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    ends: Vec<SetForm>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceForm {
    name: String,
    #[serde(default, skip_serializing_if = "is_false")]
    marked: bool,
    /// What fills it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    source: Option<Binding>,
    /// What it becomes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sink: Option<Binding>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TransitionForm {
    name: String,
    inputs: Vec<String>,
    outputs: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SetForm {
    name: String,
    places: Vec<String>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_false(value: &bool) -> bool {
    !value
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

fn borrowed(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

impl Serialize for NetModel {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let set = |set: super::PlaceSet<'_>| SetForm {
            name: set.name.to_owned(),
            places: owned(&set.places),
        };
        let form = Form {
            name: self.name().to_owned(),
            endless: self.allows_endless(),
            places: { self.places() }
                .map(|place| {
                    let binding = |kind| place.binding.filter(|_| place.kind == kind).cloned();
                    PlaceForm {
                        name: place.name.to_owned(),
                        marked: place.marked,
                        source: binding(PlaceKind::Source),
                        sink: binding(PlaceKind::Sink),
                    }
                })
                .collect(),
            transitions: { self.transitions() }
                .map(|transition| TransitionForm {
                    name: transition.name.to_owned(),
                    inputs: owned(&transition.inputs),
                    outputs: owned(&transition.outputs),
                })
                .collect(),
            exclusions: self.exclusions().map(set).collect(),
            ends: self.ends().map(set).collect(),
        };
        form.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for NetModel {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let form = Form::deserialize(deserializer)?;
        let mut model = Self::new(form.name);
        for place in form.places {
            let name = place.name.as_str();
            match (place.source, place.sink) {
                (None, None) => model.place(name),
                (Some(binding), None) => model.source(name, binding),
                (None, Some(binding)) => model.sink(name, binding),
                (Some(_), Some(_)) => {
                    let error = format!("place `{name}` is a source and a sink; expected one");
                    return Err(serde::de::Error::custom(error));
                }
            };
            if place.marked {
                model.mark(name);
            }
        }
        for transition in form.transitions {
            let (inputs, outputs) = (&transition.inputs, &transition.outputs);
            model.transition(&transition.name, &borrowed(inputs), &borrowed(outputs));
        }
        for set in form.exclusions {
            model.exclusion(set.name, &borrowed(&set.places));
        }
        for set in form.ends {
            model.end(set.name, &borrowed(&set.places));
        }
        if form.endless {
            model.allow_endless();
        }
        Ok(model)
    }
}
