//! Where everybody is: one placement of robots and nets.

use coordination::protocol::Position;

use super::tokens::{Marks, Progress};

/// Areas by number, sorted.
pub(super) type Areas = Vec<u16>;

/// Adds areas to a sorted list.
pub(super) fn join(areas: &mut Areas, more: impl IntoIterator<Item = u16>) {
    areas.extend(more);
    areas.sort_unstable();
    areas.dedup();
}

/// Where a robot is: the node of its route, the way on that it will go, and what it was granted beyond the present one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct RobotState {
    pub(super) node: u16,
    /// Where it still stands, when an order has sent its machine on to a node whose areas it does not have yet.
    pub(super) behind: Option<Areas>,
    /// By number; none until that is decided, and where it has nowhere to go.
    pub(super) way: Option<u16>,
    pub(super) ahead: Areas,
    /// Orders that its machine has not taken.
    pub(super) orders: Vec<Order>,
}

/// An event for a robot's machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Order {
    pub(super) event: u16,
    /// It comes with the robot's release, and is dropped where the machine has no use for it.
    pub(super) releases: bool,
}

impl RobotState {
    pub(super) fn at(node: u16) -> Self {
        Self {
            node,
            behind: None,
            way: None,
            ahead: Areas::new(),
            orders: Vec::new(),
        }
    }
}

/// A standing net, with its side of each protocol.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct GateState {
    /// It begins once its areas are empty.
    pub(super) begun: bool,
    pub(super) marks: Marks,
    pub(super) roles: Vec<RoleState>,
}

/// The protocol of a role. The robot's flags are set as protocol 1 says, and read as far as one waits for a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct RoleState {
    pub(super) robot: u16,
    pub(super) at: Progress,
}

impl RoleState {
    pub(super) fn begin(robot: u16) -> Self {
        Self {
            robot,
            at: Progress::START,
        }
    }

    pub(super) fn is_open(self) -> bool {
        self.at == Progress::START
    }
}

impl GateState {
    /// Somebody plays each of its roles.
    pub(super) fn may_begin(&self) -> bool {
        !self.roles.is_empty()
    }
}

/// A coordination that takes the discrete control of robots.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct ControlState {
    pub(super) phase: Phase,
    /// By role, while it runs.
    pub(super) roles: Vec<Controlled>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Phase {
    Idle,
    /// Its net runs, since this situation.
    Running {
        situation: u16,
        marks: Marks,
    },
    /// Its robots are told to get out of the way.
    Yielding,
}

/// A robot whose discrete control is taken.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Controlled {
    pub(super) robot: u16,
    pub(super) at: Progress,
    /// What the robot has heard of that.
    pub(super) heard: Position,
    /// It has its discrete control back.
    pub(super) over: bool,
    pub(super) kept: Vec<Kept>,
}

impl Controlled {
    pub(super) fn begin(robot: u16) -> Self {
        Self {
            robot,
            at: Progress::START,
            heard: Position::START,
            over: false,
            kept: Vec::new(),
        }
    }

    pub(super) fn keeps(&self, area: u16) -> bool {
        self.kept.iter().any(|kept| kept.area == area)
    }

    pub(super) fn granted(&mut self, area: u16) {
        for kept in self.kept.iter_mut().filter(|kept| kept.area == area) {
            (kept.granted, kept.left) = (true, false);
        }
    }
}

/// An area that is kept for a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Kept {
    pub(super) area: u16,
    /// It was granted since.
    pub(super) granted: bool,
    /// The robot was in it and has left, before it has answered the flag that let it in.
    pub(super) left: bool,
}

/// All of it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct State {
    pub(super) robots: Vec<RobotState>,
    pub(super) gates: Vec<GateState>,
    pub(super) controls: Vec<ControlState>,
}

impl State {
    /// What the net of this number has marked, while it runs.
    pub(super) fn marks_mut(&mut self, number: usize) -> Option<&mut Marks> {
        let Some(control) = number.checked_sub(self.gates.len()) else {
            return Some(&mut self.gates[number].marks);
        };
        match &mut self.controls[control].phase {
            Phase::Running { marks, .. } => Some(marks),
            Phase::Idle | Phase::Yielding => None,
        }
    }
}
