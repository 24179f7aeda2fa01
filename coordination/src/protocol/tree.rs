//! The compiled protocol: a tree of positions in flat arrays.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;

/// One of the two parties of a protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Party {
    /// The party that the model names first.
    First,
    /// The party that the model names second.
    Second,
}

impl Party {
    /// The one across.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }

    /// 0 or 1, as an index into an array with one entry per party.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// A dense flag id, valid in the [`Protocol`] that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FlagId(pub u16);

impl FlagId {
    /// The id as an index into an array with one entry per flag.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// How far a run has come: which flags are set, in which order. Valid in the [`Protocol`] that gave
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Position(pub(super) u16);

impl Position {
    /// No flag is set.
    pub const START: Self = Self(0);

    /// The position as an index into an array with one entry per position.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// What an abort is called where flags are named, so that no flag may have this name.
pub const ABORTED: &str = "aborted";

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Flag {
    pub(super) name: Box<str>,
    pub(super) owner: Party,
}

/// Nodes are numbered so that those below node n are n + 1 ..= last; the first child of n is
/// n + 1, and the next sibling of a child c is the one behind its last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Node {
    /// The flag whose setting leads here; without meaning at the start.
    pub(super) flag: u16,
    /// The position before; the start is its own.
    pub(super) parent: u16,
    /// How many flags are set.
    pub(super) depth: u16,
    /// The last node below, or the node itself.
    pub(super) last: u16,
    /// The first path that leads through here.
    pub(super) path: u16,
}

/// A protocol that two parties can run; see [the module](super). It never changes, so that any
/// number of channels and replicas share one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Protocol {
    name: Box<str>,
    parties: [Box<str>; 2],
    keeper: Option<Party>,
    flags: Box<[Flag]>,
    nodes: Box<[Node]>,
    /// The end of each path.
    paths: Box<[u16]>,
}

impl Protocol {
    /// The most positions that a protocol has, the start included.
    pub const LIMIT: usize = 4096;

    /// `nodes` come parents first, in the order of [`Node`]; `last` and `path` are filled in here.
    pub(super) fn new(
        name: Box<str>,
        parties: [Box<str>; 2],
        keeper: Option<Party>,
        flags: Box<[Flag]>,
        mut nodes: Box<[Node]>,
    ) -> Self {
        for index in (1..nodes.len()).rev() {
            let (parent, last) = (usize::from(nodes[index].parent), nodes[index].last);
            nodes[parent].last = nodes[parent].last.max(last);
        }
        let mut paths = Vec::new();
        for (index, node) in nodes.iter_mut().enumerate() {
            node.path = paths.len() as u16;
            if usize::from(node.last) == index {
                paths.push(index as u16);
            }
        }
        Self {
            name,
            parties,
            keeper,
            flags,
            nodes,
            paths: paths.into(),
        }
    }

    /// The protocol's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of the two parties, [`Party::First`] first.
    #[must_use]
    pub fn parties(&self) -> [&str; 2] {
        [&self.parties[0], &self.parties[1]]
    }

    /// The party called `name`.
    #[must_use]
    pub fn party(&self, name: &str) -> Option<Party> {
        [Party::First, Party::Second]
            .into_iter()
            .find(|&party| self.party_name(party) == name)
    }

    /// The name of a party.
    #[must_use]
    pub fn party_name(&self, party: Party) -> &str {
        &self.parties[party.index()]
    }

    /// The party that may abort a run, if the model declares one.
    #[must_use]
    pub fn keeper(&self) -> Option<Party> {
        self.keeper
    }

    /// The flag called `name`. Searches; meant for start-up.
    #[must_use]
    pub fn flag(&self, name: &str) -> Option<FlagId> {
        let index = self.flags.iter().position(|flag| *flag.name == *name)?;
        Some(FlagId(index as u16))
    }

    /// The name of a flag, or `?` for an id of another protocol.
    #[must_use]
    pub fn flag_name(&self, flag: FlagId) -> &str {
        self.flags.get(flag.index()).map_or("?", |flag| &flag.name)
    }

    /// The party that may set a flag; nothing for an id of another protocol.
    #[must_use]
    pub fn owner(&self, flag: FlagId) -> Option<Party> {
        self.flags.get(flag.index()).map(|flag| flag.owner)
    }

    /// All flags with names and owners, in the order of their ids.
    pub fn flags(&self) -> impl Iterator<Item = (FlagId, &str, Party)> {
        let numbered = self.flags.iter().enumerate();
        numbered.map(|(index, flag)| (FlagId(index as u16), &*flag.name, flag.owner))
    }

    /// All positions, the start first, each behind the one that it follows.
    pub fn positions(&self) -> impl Iterator<Item = Position> + use<> {
        (0..self.nodes.len() as u16).map(Position)
    }

    /// How many paths a run can take.
    #[must_use]
    pub fn paths(&self) -> usize {
        self.paths.len()
    }

    /// Whether a run is complete here.
    #[must_use]
    pub fn is_end(&self, position: Position) -> bool {
        self.node(position)
            .is_none_or(|node| node.last == position.0)
    }

    /// The flags that may be set next, each with the position that it leads to; none at an end.
    /// All of them belong to the party whose [turn](Self::turn) it is.
    pub fn next(&self, position: Position) -> impl Iterator<Item = (FlagId, Position)> {
        let end = self.node(position).map_or(0, |node| node.last);
        let mut child = position.0.saturating_add(1);
        core::iter::from_fn(move || {
            let node = self.nodes.get(usize::from(child))?;
            let found = (child <= end).then_some((FlagId(node.flag), Position(child)))?;
            child = node.last + 1;
            Some(found)
        })
    }

    /// The party whose flag comes next; nothing at an end.
    #[must_use]
    pub fn turn(&self, position: Position) -> Option<Party> {
        self.next(position)
            .next()
            .and_then(|(flag, _)| self.owner(flag))
    }

    /// Where setting `flag` leads from `position`, if it is next there.
    #[must_use]
    pub fn after(&self, position: Position, flag: FlagId) -> Option<Position> {
        let mut next = self.next(position);
        next.find_map(|(found, to)| (found == flag).then_some(to))
    }

    /// The flag that was set last, and the position before; nothing at the start.
    #[must_use]
    pub fn before(&self, position: Position) -> Option<(FlagId, Position)> {
        let node = self.node(position).filter(|node| node.depth > 0)?;
        Some((FlagId(node.flag), Position(node.parent)))
    }

    /// How many flags are set at a position.
    #[must_use]
    pub fn progress(&self, position: Position) -> u16 {
        self.node(position).map_or(0, |node| node.depth)
    }

    /// The first of the paths, in the model's order, that lead through a position.
    #[must_use]
    pub fn path(&self, position: Position) -> u16 {
        self.node(position).map_or(0, |node| node.path)
    }

    /// The position with `progress` flags set on path number `path`, if there is one.
    #[must_use]
    pub fn position(&self, path: u16, progress: u16) -> Option<Position> {
        let mut at = *self.paths.get(usize::from(path))?;
        let mut node = self.nodes[usize::from(at)];
        if progress > node.depth {
            return None;
        }
        while node.depth > progress {
            at = node.parent;
            node = self.nodes[usize::from(at)];
        }
        Some(Position(at))
    }

    /// Whether `to` is `from` or can follow it within a run.
    #[must_use]
    pub fn leads(&self, from: Position, to: Position) -> bool {
        self.node(from)
            .is_some_and(|node| from <= to && to.0 <= node.last)
    }

    /// The flag set at `from`, and where it leads, on the way to `to`; nothing if `to` does not
    /// come later.
    #[must_use]
    pub fn towards(&self, from: Position, to: Position) -> Option<(FlagId, Position)> {
        self.next(from).find(|&(_, child)| self.leads(child, to))
    }

    /// The flags set at a position, in their order, with the position each led to.
    pub fn set_flags(&self, position: Position) -> impl Iterator<Item = (FlagId, Position)> {
        let mut at = Position::START;
        core::iter::from_fn(move || {
            let step = self.towards(at, position)?;
            at = step.1;
            Some(step)
        })
    }

    /// A position as people read it: `request, granted`, or `nothing set`.
    #[must_use]
    pub fn describe(&self, position: Position) -> impl fmt::Display {
        Described(self, position)
    }

    fn node(&self, position: Position) -> Option<Node> {
        self.nodes.get(position.index()).copied()
    }
}

struct Described<'a>(&'a Protocol, Position);

impl fmt::Display for Described<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (flag, _) in self.0.set_flags(self.1) {
            write!(formatter, "{separator}{}", self.0.flag_name(flag))?;
            separator = ", ";
        }
        if separator.is_empty() {
            formatter.write_str("nothing set")?;
        }
        Ok(())
    }
}
