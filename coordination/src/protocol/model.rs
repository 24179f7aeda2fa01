//! The symbolic model of a protocol, and its checks.

use alloc::borrow::ToOwned;
use alloc::boxed::Box;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use super::error::{ModelError, Problem};
use super::graph::{Array, Graph};
use super::tree::{ABORTED, Flag, FlagId, Party, Protocol};
use crate::listed::listed;

#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
struct NamedArray {
    name: String,
    /// Flags and their owners.
    entries: Vec<(String, String)>,
}

/// A protocol in names. Adding to it never fails; [`check`](Self::check) and
/// [`compile`](Self::compile) say what is wrong with the whole.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ProtocolModel {
    name: String,
    parties: [String; 2],
    #[cfg_attr(feature = "serde", serde(default))]
    keepers: Vec<String>,
    #[cfg_attr(feature = "serde", serde(default))]
    starts: Vec<String>,
    arrays: Vec<NamedArray>,
    #[cfg_attr(feature = "serde", serde(default))]
    follows: Vec<(String, String)>,
}

impl ProtocolModel {
    /// A model without arrays, between two parties.
    pub fn new(
        name: impl Into<String>,
        first_party: impl Into<String>,
        second_party: impl Into<String>,
    ) -> Self {
        Self {
            name: name.into(),
            parties: [first_party.into(), second_party.into()],
            keepers: Vec::new(),
            starts: Vec::new(),
            arrays: Vec::new(),
            follows: Vec::new(),
        }
    }

    /// The protocol's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Makes `party` the one that may abort a run; without this nobody may.
    pub fn keeper(&mut self, party: impl Into<String>) -> &mut Self {
        self.keepers.push(party.into());
        self
    }

    /// Adds an array of entries, each a flag and the party that may set it. A flag may be in several
    /// arrays, but not twice on one path.
    pub fn array(&mut self, name: impl Into<String>, entries: &[(&str, &str)]) -> &mut Self {
        let entries = entries.iter();
        self.arrays.push(NamedArray {
            name: name.into(),
            entries: entries
                .map(|&(flag, owner)| (flag.to_owned(), owner.to_owned()))
                .collect(),
        });
        self
    }

    /// Lets a run begin with array `name`; said of several, they are alternatives. If it is said of
    /// none, a run begins with the first array added.
    pub fn start(&mut self, name: impl Into<String>) -> &mut Self {
        self.starts.push(name.into());
        self
    }

    /// Lets array `next` follow array `array`; said of several, they are alternatives. A run ends
    /// with an array that none follows.
    pub fn follow(&mut self, array: impl Into<String>, next: impl Into<String>) -> &mut Self {
        self.follows.push((array.into(), next.into()));
        self
    }

    /// Everything that is wrong with the model; nothing if it compiles.
    #[must_use]
    pub fn check(&self) -> Vec<ModelError> {
        let mut problems = Vec::new();
        let graph = self.graph(&mut problems);
        if problems.is_empty() {
            problems.extend(graph.expand().err());
        }
        problems
            .into_iter()
            .map(|problem| self.error(problem))
            .collect()
    }

    /// Checks the model and makes the protocol. Not for real-time threads.
    ///
    /// # Errors
    /// The first problem that [`check`](Self::check) finds.
    pub fn compile(&self) -> Result<Protocol, ModelError> {
        let mut problems = Vec::new();
        let graph = self.graph(&mut problems);
        if let Some(problem) = problems.into_iter().next() {
            return Err(self.error(problem));
        }
        let nodes = graph.expand().map_err(|problem| self.error(problem))?;
        Ok(Protocol::new(
            self.name.as_str().into(),
            self.parties.clone().map(String::into_boxed_str),
            self.keepers.first().and_then(|keeper| self.party(keeper)),
            graph.flags.into(),
            nodes.into(),
        ))
    }

    /// The arrays in numbers. Names that mean nothing are reported and left out.
    fn graph(&self, problems: &mut Vec<Problem>) -> Graph {
        self.check_parties(problems);
        let mut graph = Graph::default();
        let mut flag_ids: BTreeMap<&str, FlagId> = BTreeMap::new();
        let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
        if self.arrays.is_empty() {
            problems.push(Problem::NoArrays);
        }
        for (number, array) in self.arrays.iter().enumerate() {
            if array.name.is_empty() {
                problems.push(Problem::EmptyName { what: "an array" });
            } else if numbers.insert(&array.name, number).is_some() {
                let array = array.name.clone();
                problems.push(Problem::DuplicateArray { array });
            }
            if array.entries.is_empty() {
                let array = array.name.clone();
                problems.push(Problem::EmptyArray { array });
            }
            let entries = array.entries.iter();
            graph.arrays.push(Array {
                name: array.name.clone(),
                flags: entries
                    .filter_map(|(flag, owner)| {
                        self.entry(flag, owner, &mut graph.flags, &mut flag_ids, problems)
                    })
                    .collect(),
                next: Vec::new(),
            });
        }
        let mut find = |name: &str, place: &dyn Fn() -> String| {
            let found = numbers.get(name).copied();
            if found.is_none() {
                problems.push(Problem::UnknownArray {
                    place: place(),
                    found: name.to_owned(),
                    known: listed(self.arrays.iter().map(|array| array.name.as_str())),
                });
            }
            found
        };
        for start in &self.starts {
            let found = find(start, &|| "the start".to_owned());
            graph
                .starts
                .extend(found.filter(|start| !graph.starts.contains(start)));
        }
        let mut seen = BTreeSet::new();
        for (array, next) in &self.follows {
            let from = find(array, &|| format!("what `{next}` follows"));
            let to = find(next, &|| format!("what follows `{array}`"));
            if let (Some(from), Some(to)) = (from, to)
                && seen.insert((from, to))
            {
                graph.arrays[from].next.push(to);
            }
        }
        if self.starts.is_empty() && !self.arrays.is_empty() {
            graph.starts.push(0);
        }
        if problems.is_empty() {
            graph.check(&self.parties, problems);
        }
        graph
    }

    fn check_parties(&self, problems: &mut Vec<Problem>) {
        if self.name.is_empty() {
            problems.push(Problem::NoName);
        }
        if self.parties.iter().any(String::is_empty) {
            problems.push(Problem::EmptyName { what: "a party" });
        }
        if self.parties[0] == self.parties[1] {
            let party = self.parties[0].clone();
            problems.push(Problem::SameParties { party });
        }
        for keeper in &self.keepers {
            if self.party(keeper).is_none() {
                problems.push(self.unknown_party("the keeper".to_owned(), keeper));
            }
        }
        if let Some((first, others)) = self.keepers.split_first()
            && let Some(second) = others.iter().find(|&other| other != first)
        {
            problems.push(Problem::TwoKeepers {
                first: first.clone(),
                second: second.clone(),
            });
        }
    }

    /// The id of an entry's flag, which is added to `flags` if it is new.
    fn entry<'a>(
        &'a self,
        name: &'a str,
        owner: &str,
        flags: &mut Vec<Flag>,
        ids: &mut BTreeMap<&'a str, FlagId>,
        problems: &mut Vec<Problem>,
    ) -> Option<FlagId> {
        let Some(party) = self.party(owner) else {
            problems.push(self.unknown_party(format!("flag `{name}`"), owner));
            return None;
        };
        if name.is_empty() {
            problems.push(Problem::EmptyName { what: "a flag" });
            return None;
        }
        if name == ABORTED {
            problems.push(Problem::ReservedName);
            return None;
        }
        if let Some(&id) = ids.get(name) {
            let first = flags[id.index()].owner;
            if first != party {
                problems.push(Problem::TwoOwners {
                    flag: name.to_owned(),
                    first: self.parties[first.index()].clone(),
                    second: owner.to_owned(),
                });
            }
            return Some(id);
        }
        if flags.len() >= Protocol::LIMIT {
            problems.push(Problem::TooLarge {
                limit: Protocol::LIMIT,
            });
            return None;
        }
        let id = FlagId(flags.len() as u16);
        flags.push(Flag {
            name: name.into(),
            owner: party,
        });
        ids.insert(name, id);
        Some(id)
    }

    fn party(&self, name: &str) -> Option<Party> {
        let mut parties = [Party::First, Party::Second].into_iter();
        parties.find(|party| self.parties[party.index()] == name)
    }

    fn unknown_party(&self, place: String, found: &str) -> Problem {
        Problem::UnknownParty {
            place,
            found: found.to_owned(),
            first: self.parties[0].clone(),
            second: self.parties[1].clone(),
        }
    }

    fn error(&self, problem: Problem) -> ModelError {
        ModelError {
            protocol: self.name.clone(),
            problem: Box::new(problem),
        }
    }
}
