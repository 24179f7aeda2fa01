//! Where everybody is: one placement of robots and nets.

use coordination::protocol::Position;

/// Areas by number, sorted.
pub(super) type Areas = Vec<u16>;

/// Adds areas to a sorted list.
pub(super) fn join(areas: &mut Areas, more: impl IntoIterator<Item = u16>) {
    areas.extend(more);
    areas.sort_unstable();
    areas.dedup();
}

/// Where a robot is: the node of its route, the one that it will come to next, and what it was granted beyond the present one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct RobotState {
    pub(super) node: u16,
    /// None until that is decided, and where it has nowhere to go.
    pub(super) to: Option<u16>,
    pub(super) ahead: Areas,
}

impl RobotState {
    pub(super) fn at(node: u16) -> Self {
        Self {
            node,
            to: None,
            ahead: Areas::new(),
        }
    }
}

/// A standing net, with its side of each protocol.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct NetState {
    /// It begins once its areas are empty.
    pub(super) begun: bool,
    /// By place, one bit each.
    marks: Vec<u64>,
    pub(super) roles: Vec<RoleState>,
}

/// The protocol of a role. The robot's flags are set as protocol 1 says, and read when their source is empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct RoleState {
    pub(super) robot: u16,
    pub(super) set: Position,
    pub(super) read: Position,
}

impl RoleState {
    pub(super) fn begin(robot: u16) -> Self {
        Self {
            robot,
            set: Position::START,
            read: Position::START,
        }
    }

    pub(super) fn is_open(self) -> bool {
        self.set == Position::START && self.read == Position::START
    }
}

impl NetState {
    pub(super) fn new(marked: &[bool], roles: Vec<RoleState>) -> Self {
        let mut state = Self {
            begun: false,
            marks: vec![0; marked.len().div_ceil(64)],
            roles,
        };
        for (place, _) in marked.iter().enumerate().filter(|(_, marked)| **marked) {
            state.set_mark(place, true);
        }
        state
    }

    /// Somebody plays each of its roles.
    pub(super) fn may_begin(&self) -> bool {
        !self.roles.is_empty()
    }

    pub(super) fn has_mark(&self, place: usize) -> bool {
        self.marks[place / 64] >> (place % 64) & 1 == 1
    }

    pub(super) fn set_mark(&mut self, place: usize, marked: bool) {
        let bit = 1 << (place % 64);
        if marked {
            self.marks[place / 64] |= bit;
        } else {
            self.marks[place / 64] &= !bit;
        }
    }
}

/// All of it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct State {
    pub(super) robots: Vec<RobotState>,
    pub(super) nets: Vec<NetState>,
}
