//! What reference nodes stand for in the end.

use super::super::error::ReadError;
use super::element::{at, shortened};
use super::net::{RawNet, Reference, Target};
use roxmltree::Node;

/// By reference node: the place or transition that it stands for.
pub(super) fn resolve(net: &RawNet<'_, '_>) -> Result<Vec<Target>, ReadError> {
    let mut known: Vec<Option<Target>> = vec![None; net.references.len()];
    // By reference node: from which walk it was passed, counted from one.
    let mut passed = vec![0; net.references.len()];
    let mut way = Vec::new();
    for start in 0..net.references.len() {
        let mut number = start;
        let target = loop {
            if let Some(target) = known[number] {
                break target;
            }
            let reference = &net.references[number];
            if std::mem::replace(&mut passed[number], start + 1) == start + 1 {
                return Err(ReadError::Circle {
                    at: at(reference.node),
                });
            }
            way.push(number);
            match next(net, reference)? {
                Target::Reference(next) => number = next,
                target => break target,
            }
        };
        for number in way.drain(..) {
            known[number] = Some(target);
        }
    }
    Ok(known.into_iter().flatten().collect())
}

fn next(net: &RawNet<'_, '_>, reference: &Reference<'_, '_>) -> Result<Target, ReadError> {
    let (expected, place, transition) = match reference.is_place {
        true => ("a place or reference place of this net", true, false),
        false => (
            "a transition or reference transition of this net",
            false,
            true,
        ),
    };
    match net.targets.get(reference.to).copied() {
        Some(target @ Target::Place(_)) if place => Ok(target),
        Some(target @ Target::Transition(_)) if transition => Ok(target),
        Some(target @ Target::Reference(number))
            if net.references[number].is_place == reference.is_place =>
        {
            Ok(target)
        }
        found => Err(wrong(net, reference.node, reference.to, found, expected)),
    }
}

/// That `name` does not stand for what is expected.
pub(super) fn wrong(
    net: &RawNet<'_, '_>,
    node: Node<'_, '_>,
    name: &str,
    found: Option<Target>,
    expected: &'static str,
) -> ReadError {
    ReadError::WrongReference {
        at: at(node),
        name: shortened(name),
        found: match found {
            None => "no node of this net",
            Some(Target::Place(_)) => "a place",
            Some(Target::Transition(_)) => "a transition",
            Some(Target::Reference(number)) if net.references[number].is_place => {
                "a reference place"
            }
            Some(Target::Reference(_)) => "a reference transition",
        },
        expected,
    }
}
