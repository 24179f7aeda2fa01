//! Circles: modules that depend on themselves through others.
//!
//! Two graphs are looked at. Between files, where a re-export counts as the file that defines the name. And between the
//! parts of each folder, where a part is a file, or a folder with all that is in it: this graph gives the levels that a
//! reader sees.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::{Crate, Use};

/// One sentence for each circle.
#[must_use]
pub fn findings(member: &str, krate: &Crate) -> Vec<String> {
    let uses = krate.uses();
    let mut findings: Vec<String> = Vec::new();
    let mut seen = BTreeSet::new();
    for depth in 0..=krate.depth() {
        for circle in between_parts(&uses, depth) {
            if seen.insert(circle.clone()) {
                findings.push(sentence(member, &circle, &uses));
            }
        }
    }
    findings
}

/// Modules from the root, such as `["petri", "net"]`, as a reader writes them.
fn shown(part: &[String]) -> String {
    if part.is_empty() {
        "the root".to_owned()
    } else {
        part.join("::")
    }
}

/// The circles between the parts of all folders at one depth: paths are cut behind the first segment in which they differ.
fn between_parts(uses: &[Use], depth: usize) -> Vec<BTreeSet<Vec<String>>> {
    let mut graph: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
    for one in uses {
        let common = { one.from.iter().zip(&one.to) }
            .take_while(|(from, to)| from == to)
            .count();
        if common != depth {
            continue;
        }
        let part = |path: &[String]| path[..path.len().min(depth + 1)].to_vec();
        let (from, to) = (part(&one.from), part(&one.to));
        if from != to {
            graph.entry(from).or_default().insert(to);
        }
    }
    components(&graph)
}

/// Sets of nodes that reach each other.
fn components(graph: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>) -> Vec<BTreeSet<Vec<String>>> {
    let reach = |start: &Vec<String>| {
        let mut found = BTreeSet::new();
        let mut open = vec![start];
        while let Some(node) = open.pop() {
            for next in graph.get(node).into_iter().flatten() {
                if found.insert(next.clone()) {
                    open.push(next);
                }
            }
        }
        found
    };
    let reached: BTreeMap<_, _> = graph.keys().map(|node| (node, reach(node))).collect();
    let mut circles = BTreeSet::new();
    for (node, found) in &reached {
        if found.contains(*node) {
            let same = found
                .iter()
                .filter(|other| reached.get(other).is_some_and(|back| back.contains(*node)));
            circles.insert(same.cloned().collect::<BTreeSet<_>>());
        }
    }
    circles.into_iter().collect()
}

fn sentence(member: &str, circle: &BTreeSet<Vec<String>>, uses: &[Use]) -> String {
    let parts: Vec<String> = circle.iter().map(|part| shown(part)).collect();
    let mut text = format!("{member}: circle of {}", parts.join(", "));
    let part_of = |path: &[String]| {
        let longest = { circle.iter() }.filter(|part| path.starts_with(part));
        longest.max_by_key(|part| part.len())
    };
    let mut ties: BTreeMap<(Vec<String>, Vec<String>), BTreeSet<&str>> = BTreeMap::new();
    for one in uses {
        if let (Some(from), Some(to)) = (part_of(&one.from), part_of(&one.to))
            && from != to
        {
            let tie = ties.entry((one.from.clone(), one.to.clone())).or_default();
            tie.insert(&one.name);
        }
    }
    for ((from, to), names) in ties {
        let names: Vec<&str> = names.into_iter().collect();
        text += &format!(
            "\n    {} uses {}: {}",
            shown(&from),
            shown(&to),
            names.join(", ")
        );
    }
    text
}
