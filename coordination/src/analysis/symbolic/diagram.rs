//! Sets of states as zero-suppressed decision diagrams, in as much memory as is allowed.

use std::collections::HashMap;

use std::hash::BuildHasherDefault;

use oxidd::util::num::Saturating;
use oxidd::util::{FxHasher, OutOfMemory, SatCountCache};
use oxidd::zbdd::{ZBDDFunction, ZBDDManagerRef, new_manager};
use oxidd::{
    BooleanFunction, BooleanVecSet, Function, HasLevel, Manager, ManagerRef, Node, NodeID,
};

use super::super::kept::{HERE, Kept, NOWHERE};

/// The time or the memory is used up, or there is none for a stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exhausted {
    Nodes,
    Time,
    Stack,
}

impl From<OutOfMemory> for Exhausted {
    fn from(_: OutOfMemory) -> Self {
        Self::Nodes
    }
}

/// What an operation on sets gives.
pub(super) type Grown<T> = Result<T, Exhausted>;

/// The most nodes: memory for all of them is reserved, though not used, from the beginning.
const MOST_NODES: usize = if cfg!(target_pointer_width = "64") {
    1 << 28
} else {
    1 << 24
};

/// The most results that are cached.
const MOST_CACHED: usize = 1 << 20;

/// How often nodes were counted already; shared between counts of sets that have nodes in common.
pub(super) type Counts = SatCountCache<Saturating<u128>, BuildHasherDefault<FxHasher>>;

/// A set of states, each being the variables that are true in it.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct Set(ZBDDFunction);

/// Where the nodes of all sets are.
pub(super) struct Diagram {
    manager: ZBDDManagerRef,
    capacity: usize,
}

impl Diagram {
    /// A diagram of up to `nodes` nodes over `variables` variables, the first on top.
    pub(super) fn new(variables: u32, nodes: usize) -> Self {
        let cached = nodes.clamp(1 << 10, MOST_CACHED);
        let capacity = nodes.min(MOST_NODES).max(variables as usize * 2);
        let manager = new_manager(capacity, cached, 1);
        manager.with_manager_exclusive(|manager| manager.add_vars(variables));
        Self { manager, capacity }
    }

    pub(super) fn empty(&self) -> Set {
        { &self.manager }.with_manager_shared(|manager| Set(ZBDDFunction::empty(manager)))
    }

    /// The one state in which exactly these variables are true.
    pub(super) fn only(&self, variables: impl Iterator<Item = u32>) -> Grown<Set> {
        let base = { &self.manager }.with_manager_shared(|manager| ZBDDFunction::base(manager));
        let mut variables: Vec<u32> = variables.collect();
        variables.sort_unstable();
        let mut set = Set(base);
        for &variable in variables.iter().rev() {
            set = set.toggled(variable)?;
        }
        Ok(set)
    }

    /// Gives nodes back that no set needs any more, once half of the memory is used.
    pub(super) fn tidy(&self) {
        self.manager.with_manager_shared(|manager| {
            if manager.approx_num_inner_nodes() > self.capacity / 2 {
                manager.gc();
            }
        });
    }
}

impl Set {
    pub(super) fn is_empty(&self) -> bool {
        self.0
            .with_manager_shared(|manager, edge| match manager.get_node(edge) {
                Node::Inner(_) => false,
                Node::Terminal(_) => {
                    edge.node_id() == ZBDDFunction::empty(manager).as_edge(manager).node_id()
                }
            })
    }

    /// How many nodes its diagram has.
    pub(super) fn nodes(&self) -> usize {
        self.0.node_count()
    }

    /// How many states; the largest number if there are more.
    pub(super) fn count(&self, counts: &mut Counts) -> u128 {
        let variables = self
            .0
            .with_manager_shared(|manager, _| manager.num_levels());
        self.0.sat_count(variables, counts).0
    }

    /// The same set without its diagram.
    pub(super) fn keep(&self) -> Kept {
        self.0.with_manager_shared(|manager, edge| {
            let mut kept = Kept::default();
            let empty = ZBDDFunction::empty(manager).as_edge(manager).node_id();
            let base = ZBDDFunction::base(manager).as_edge(manager).node_id();
            let mut known = HashMap::from([(empty, NOWHERE), (base, HERE)]);
            kept.root = copy(manager, edge, &mut kept, &mut known);
            kept
        })
    }

    /// The variables that are true in one of the states.
    pub(super) fn any(&self) -> Option<Vec<u32>> {
        self.0.with_manager_shared(|manager, edge| {
            let empty = ZBDDFunction::empty(manager).as_edge(manager).node_id();
            if edge.node_id() == empty {
                return None;
            }
            let (mut edge, mut found) = (edge, Vec::new());
            while let Node::Inner(node) = manager.get_node(edge) {
                let (with, without) = ZBDDFunction::cofactors_node((), node);
                if without.node_id() == empty {
                    found.push(node.level());
                    edge = with;
                } else {
                    edge = without;
                }
            }
            Some(found)
        })
    }

    /// The states without this variable.
    pub(super) fn without(&self, variable: u32) -> Grown<Self> {
        Ok(Self(self.0.subset0(variable)?))
    }

    /// The states with this variable, which is then taken out of them.
    pub(super) fn taken(&self, variable: u32) -> Grown<Self> {
        Ok(Self(self.0.subset1(variable)?))
    }

    /// All states with this variable turned round.
    pub(super) fn toggled(&self, variable: u32) -> Grown<Self> {
        Ok(Self(self.0.change(variable)?))
    }

    /// The first variable that is true in one of the states.
    pub(super) fn top(&self) -> Option<u32> {
        self.0
            .with_manager_shared(|manager, edge| match manager.get_node(edge) {
                Node::Inner(node) => Some(node.level()),
                Node::Terminal(_) => None,
            })
    }

    /// The states with the first variable, which is taken out of them, and those without it.
    pub(super) fn split(&self) -> (Self, Self) {
        match self.0.cofactors() {
            Some((with, without)) => (Self(with), Self(without)),
            None => (self.clone(), self.clone()),
        }
    }

    /// These states with this variable put in, and others `without` it; neither has it or one before it.
    pub(super) fn on_top(&self, variable: u32, without: &Self) -> Grown<Self> {
        if self.is_empty() {
            return Ok(without.clone());
        }
        self.toggled(variable)?.union(without)
    }

    /// The states with this variable.
    pub(super) fn with(&self, variable: u32) -> Grown<Self> {
        self.taken(variable)?.toggled(variable)
    }

    pub(super) fn union(&self, other: &Self) -> Grown<Self> {
        Ok(Self(self.0.union(&other.0)?))
    }

    pub(super) fn and(&self, other: &Self) -> Grown<Self> {
        Ok(Self(self.0.intsec(&other.0)?))
    }

    pub(super) fn minus(&self, other: &Self) -> Grown<Self> {
        Ok(Self(self.0.diff(&other.0)?))
    }
}

/// Copies what hangs on an edge, and says where it is in the copy.
fn copy<'id>(
    manager: &<ZBDDFunction as Function>::Manager<'id>,
    edge: oxidd::util::Ref<'_, <<ZBDDFunction as Function>::Manager<'id> as Manager>::Edge>,
    kept: &mut Kept,
    known: &mut HashMap<NodeID, u32>,
) -> u32 {
    if let Some(&at) = known.get(&edge.node_id()) {
        return at;
    }
    let Node::Inner(node) = manager.get_node(edge) else {
        return NOWHERE;
    };
    let (with, without) = ZBDDFunction::cofactors_node((), node);
    let with = copy(manager, with, kept, known);
    let without = copy(manager, without, kept, known);
    let at = kept.add(node.level(), with, without);
    known.insert(edge.node_id(), at);
    at
}
