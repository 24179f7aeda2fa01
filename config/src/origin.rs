//! Where each value was written, so that a problem found long after parsing
//! still names its line.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnostic::{Problem, ProblemKind};
use crate::node::{Entry, Node, Value};
use crate::spot::{Source, Spot, join, line_of};

#[derive(Clone, Debug)]
struct Spots {
    key: Spot,
    value: Spot,
}

/// Where each key of a loaded file was written.
///
/// A caller that finds something wrong only later (a core that this machine
/// does not have, say) can report it like the loader would:
///
/// ```
/// use config::ProblemKind;
/// let robot = config::load_robot("robots/amr-1.toml", &[]).unwrap();
/// let problem = robot.origin.problem(
///     ProblemKind::OutOfRange,
///     "threads.fieldbus.core",
///     "core 9",
///     "a core of this machine, 0 to 3",
/// );
/// assert!(problem.to_string().contains("amr-1.toml:"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Origin {
    sources: Arc<Vec<Source>>,
    places: Arc<BTreeMap<String, Spots>>,
}

impl Origin {
    pub(crate) fn new(sources: Vec<Source>, entries: &[Entry]) -> Self {
        let mut places = BTreeMap::new();
        index_table("", entries, &mut places);
        Self {
            sources: Arc::new(sources),
            places: Arc::new(places),
        }
    }

    /// The same texts with the places of a tree.
    pub(crate) fn with_places(&self, entries: &[Entry]) -> Self {
        Self::new(self.sources.to_vec(), entries)
    }

    /// The file's name, as it was given.
    #[must_use]
    pub fn file(&self) -> &str {
        self.sources.first().map_or("", |source| source.text.name())
    }

    /// Whether the key was written at all, in the file or by an override.
    #[must_use]
    pub fn is_written(&self, key: &str) -> bool {
        self.places.contains_key(key)
    }

    /// The line on which the key's value stands; none for an override or a default.
    #[must_use]
    pub fn line(&self, key: &str) -> Option<usize> {
        let place = self.places.get(key)?;
        let source = self.sources.get(place.value.source)?;
        source
            .is_file
            .then(|| line_of(source.text.inner(), place.value.span.start))
    }

    /// A problem with the value of this key, or with its absence: then it points
    /// at the section that should hold it.
    pub fn problem(
        &self,
        kind: ProblemKind,
        key: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Problem {
        let at_key = matches!(kind, ProblemKind::UnknownKey | ProblemKind::Duplicate);
        let spot = self.nearest(key).map(|(place, exact)| {
            if at_key || !exact {
                place.key.clone()
            } else {
                place.value.clone()
            }
        });
        self.problem_at(kind, key, spot, found.into(), expected.into())
    }

    pub(crate) fn problem_at(
        &self,
        kind: ProblemKind,
        key: &str,
        spot: Option<Spot>,
        found: String,
        expected: String,
    ) -> Problem {
        let spot = spot.unwrap_or(Spot {
            source: 0,
            span: 0..0,
        });
        let mut problem = Problem::new(kind, key, found, expected);
        if let Some(source) = self.sources.get(spot.source) {
            problem.place(source, spot.span);
        }
        problem
    }

    /// Adds a second place to a problem, when it lies in the same text.
    pub(crate) fn also(&self, problem: Problem, key: &str, label: &str) -> Problem {
        match self.places.get(key).and_then(|place| {
            let source = self.sources.get(place.key.source)?;
            Some((source, place.key.span.clone()))
        }) {
            Some((source, span)) => problem.with_also(source, span, label),
            None => problem,
        }
    }

    /// The place of the key or of the nearest section around it, and whether it is the key's own.
    fn nearest(&self, key: &str) -> Option<(&Spots, bool)> {
        let mut path = key;
        loop {
            if let Some(place) = self.places.get(path) {
                return Some((place, path.len() == key.len()));
            }
            path = &path[..path.rfind(['.', '['])?];
        }
    }
}

fn index_table(path: &str, entries: &[Entry], places: &mut BTreeMap<String, Spots>) {
    for entry in entries {
        index_node(join(path, &entry.key), &entry.spot, &entry.node, places);
    }
}

fn index_node(path: String, key: &Spot, node: &Node, places: &mut BTreeMap<String, Spots>) {
    match &node.value {
        Value::Table(entries) => index_table(&path, entries, places),
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                index_node(format!("{path}[{index}]"), &item.spot, item, places);
            }
        }
        _ => {}
    }
    // A table's own span is its header or all of its text: its key says it better.
    let value = match node.value {
        Value::Table(_) => key.clone(),
        _ => node.spot.clone(),
    };
    places.insert(
        path,
        Spots {
            key: key.clone(),
            value,
        },
    );
}
