//! From a net as its document has it to a model.

use std::collections::HashSet;

use super::super::error::ReadError;
use super::element::{at, shortened};
use super::net::{RawNet, RawNode, Target};
use super::references::{resolve, wrong};
use crate::petri::NetModel;

pub(super) fn model(net: &RawNet<'_, '_>) -> Result<NetModel, ReadError> {
    let references = resolve(net)?;
    let find = |name: &str| match net.targets.get(name) {
        Some(&Target::Reference(number)) => references.get(number).copied(),
        found => found.copied(),
    };
    // By transition: the places of its arcs.
    let mut inputs = vec![Vec::new(); net.transitions.len()];
    let mut outputs = inputs.clone();
    let mut seen = HashSet::with_capacity(net.arcs.len());
    for arc in &net.arcs {
        let (from, to) = (find(arc.from), find(arc.to));
        let (list, transition, place) = match (from, to) {
            (Some(Target::Place(place)), Some(Target::Transition(transition))) => {
                (&mut inputs, transition, place)
            }
            (Some(Target::Transition(transition)), Some(Target::Place(place))) => {
                (&mut outputs, transition, place)
            }
            (Some(Target::Place(_)), to) => {
                return Err(wrong(net, arc.node, arc.to, to, "a transition of this net"));
            }
            (Some(Target::Transition(_)), to) => {
                return Err(wrong(net, arc.node, arc.to, to, "a place of this net"));
            }
            (from, _) => {
                let expected = "a place or transition of this net";
                return Err(wrong(net, arc.node, arc.from, from, expected));
            }
        };
        let is_input = matches!(from, Some(Target::Place(_)));
        if !seen.insert((is_input, transition, place)) {
            return Err(ReadError::SecondArc {
                at: at(arc.node),
                from: shortened(arc.from),
                to: shortened(arc.to),
            });
        }
        list[transition].push(place);
    }

    let names = Names::of(net);
    let name = names.text(net.name.as_deref()).unwrap_or(net.id);
    let mut model = NetModel::new(name);
    let places: Vec<&str> = net
        .places
        .iter()
        .map(|place| names.of_node(place))
        .collect();
    for (place, &name) in net.places.iter().zip(&places) {
        match &place.port {
            None => model.place(name),
            Some(port) if port.is_source => model.source(name, port.binding()),
            Some(port) => model.sink(name, port.binding()),
        };
        if place.marked {
            model.mark(name);
        }
    }
    let named = |list: &[usize]| list.iter().map(|&place| places[place]).collect::<Vec<_>>();
    for ((transition, inputs), outputs) in net.transitions.iter().zip(&inputs).zip(&outputs) {
        let (inputs, outputs) = (named(inputs), named(outputs));
        model.transition(names.of_node(transition), &inputs, &outputs);
    }
    for set in &net.declared.sets {
        let mut members = Vec::with_capacity(set.places.len());
        for &(node, place) in &set.places {
            match find(place) {
                Some(Target::Place(number)) => members.push(places[number]),
                found => return Err(wrong(net, node, place, found, "a place of this net")),
            }
        }
        match set.is_end {
            true => model.end(set.name, &members),
            false => model.exclusion(set.name, &members),
        };
    }
    if net.declared.endless {
        model.allow_endless();
    }
    Ok(model)
}

/// How texts become names.
#[derive(Clone, Copy)]
struct Names {
    /// As they are, white space included.
    verbatim: bool,
    /// Ids instead.
    by_id: bool,
}

impl Names {
    fn of(net: &RawNet<'_, '_>) -> Self {
        let mut names = Self {
            verbatim: net.declared.verbatim,
            by_id: false,
        };
        let mut seen = HashSet::new();
        let mut nodes = net.places.iter().chain(&net.transitions);
        names.by_id = !nodes.all(|node| {
            let name = names.text(node.name.as_deref());
            name.is_some_and(|name| seen.insert(name))
        });
        names
    }

    fn text<'a>(&self, text: Option<&'a str>) -> Option<&'a str> {
        let text = match self.verbatim {
            true => text,
            false => text.map(str::trim),
        };
        text.filter(|text| !text.is_empty())
    }

    fn of_node<'a>(&self, node: &'a RawNode<'a>) -> &'a str {
        match self.by_id {
            true => node.id,
            false => self.text(node.name.as_deref()).unwrap_or(node.id),
        }
    }
}
