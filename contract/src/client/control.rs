//! Protocol 2, the discrete control of the robot, from its own side.

use std::collections::VecDeque;
use std::sync::Arc;

use coordination::protocol::{Change, FlagId, Party, Position, Protocol, Replica, Side};
use description::instruction::Instruction;

use super::access::BadLevel;
use crate::level;
use crate::protocols::{RELEASE, ROBOT_PARTY, begin, control_paths};
use crate::wire;

/// What the mediator wants the robot to do, by a flag of a coordination.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Which coordination.
    pub coordination: u64,
    /// The flag.
    pub flag: String,
    /// Its event, if there is one, is for the state machine, as soon as its state has a transition on it.
    pub instruction: Instruction<Option<String>>,
    /// Given again because the robot's process has restarted: the state machine may have taken the event before.
    pub repeated: bool,
}

impl Order {
    /// By which a robot goes on that had restarted when its coordination let it go.
    pub(super) fn release(instruction: &wire::Instruction) -> Self {
        Self {
            coordination: 0,
            flag: RELEASE.to_owned(),
            instruction: instruction.into(),
            repeated: true,
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Control {
    pub(super) coordination: u64,
    pub(super) net: String,
    robot: Party,
    replica: Replica,
    /// What the message says of each flag, by flag.
    flags: Vec<wire::ControlFlag>,
    /// Not handed out yet; never more than there are flags.
    orders: VecDeque<Order>,
    /// Areas of this run's orders.
    areas: Vec<String>,
    /// Those of them that the robot has left again before it has answered their order: it may have been wrong about where it is,
    /// and have to enter them once more.
    left: Vec<String>,
}

impl Control {
    /// Joins a coordination. A robot that `registers` goes on where it was before it restarted.
    pub(super) fn join(message: &wire::Control, registers: bool) -> Result<Self, BadLevel> {
        let protocol = Arc::new(control_paths(&message.flags, &message.paths)?);
        let level = level::decode(message.level.as_ref())?;
        let robot = ROBOT_PARTY;
        let said = |name: &str| message.flags.iter().find(|flag| flag.name == name);
        let replica = if registers {
            Replica::resume(&protocol, robot, level)?
        } else {
            begin(&protocol, robot)
        };
        let mut control = Self {
            coordination: message.coordination,
            net: message.net.clone(),
            robot,
            replica,
            flags: protocol
                .flags()
                .map(|(_, name, _)| said(name).cloned().unwrap_or_default())
                .collect(),
            orders: VecDeque::new(),
            areas: Vec::new(),
            left: Vec::new(),
        };
        if registers {
            control.repeat(&protocol);
        } else {
            control.learn(message)?;
        }
        Ok(control)
    }

    /// Gives the last order again, and asks for all its run's areas again.
    fn repeat(&mut self, protocol: &Protocol) {
        let set: Vec<FlagId> = protocol
            .set_flags(self.replica.position())
            .map(|(flag, _)| flag)
            .filter(|&flag| protocol.owner(flag) != Some(self.robot))
            .collect();
        for flag in set {
            self.order(flag, true);
        }
        let last = self.orders.pop_back();
        self.orders.clear();
        self.orders.extend(last);
    }

    /// Takes in a level of the same coordination.
    pub(super) fn learn(&mut self, message: &wire::Control) -> Result<(), BadLevel> {
        self.replica.merge(level::decode(message.level.as_ref())?)?;
        while let Some(change) = self.replica.poll() {
            if let Change::Flag(flag) = change {
                self.order(flag, false);
            }
        }
        Ok(())
    }

    fn order(&mut self, flag: FlagId, repeated: bool) {
        let Some(said) = self.flags.get(flag.index()) else {
            return;
        };
        if said.name == RELEASE {
            self.areas.clear();
        }
        let Some(instruction) = &said.instruction else {
            return;
        };
        for area in &instruction.areas {
            if !self.areas.contains(area) {
                self.areas.push(area.clone());
            }
        }
        self.orders.push_back(Order {
            coordination: self.coordination,
            flag: said.name.clone(),
            instruction: instruction.into(),
            repeated,
        });
    }

    pub(super) fn next_order(&mut self) -> Option<Order> {
        self.orders.pop_front()
    }

    /// What the mediator would order at the end, for a robot that it lets go without.
    pub(super) fn let_go(&mut self) -> Option<Order> {
        let at = self.replica.position();
        let protocol = self.replica.protocol();
        let release = protocol.flag(RELEASE)?;
        let begun = at != Position::START && !protocol.is_end(at);
        let released = protocol.set_flags(at).any(|(flag, _)| flag == release);
        if !begun || released {
            return None;
        }
        self.orders.clear();
        self.order(release, false);
        self.orders.pop_back()
    }

    /// Sets the robot's next flags that wait for no output of its machine, once it has taken all orders.
    pub(super) fn advance(&mut self) -> bool {
        let mut news = false;
        if !self.orders.is_empty() {
            return news;
        }
        while let Some(flag) = self.next_flag(|said| said.on_output.is_empty()) {
            if !self.answer(flag) {
                break;
            }
            news = true;
        }
        news
    }

    /// The machine has fired an output.
    pub(super) fn output(&mut self, output: &str) -> bool {
        let flag = self.next_flag(|said| !output.is_empty() && said.on_output == output);
        flag.is_some_and(|flag| self.answer(flag))
    }

    /// Sets a flag of the robot's: what it has left is done with.
    fn answer(&mut self, flag: FlagId) -> bool {
        let is_set = self.replica.set(flag).is_ok();
        if is_set {
            let left = std::mem::take(&mut self.left);
            self.areas.retain(|area| !left.contains(area));
        }
        is_set
    }

    /// The last order of an area was not answered.
    fn is_on_the_way(&self, area: &str) -> bool {
        let protocol = self.replica.protocol();
        let mut on_the_way = false;
        for (flag, _) in protocol.set_flags(self.replica.position()) {
            let orders = |said: &wire::ControlFlag| {
                { said.instruction.iter() }.any(|own| own.areas.iter().any(|own| own == area))
            };
            if protocol.owner(flag) == Some(self.robot) {
                on_the_way = false;
            } else if self.flags.get(flag.index()).is_some_and(orders) {
                on_the_way = true;
            }
        }
        on_the_way
    }

    fn next_flag(&self, fits: impl Fn(&wire::ControlFlag) -> bool) -> Option<FlagId> {
        let protocol = self.replica.protocol();
        let at = self.replica.position();
        if protocol.turn(at) != Some(self.robot) {
            return None;
        }
        let mut next = protocol.next(at).map(|(flag, _)| flag);
        next.find(|flag| self.flags.get(flag.index()).is_some_and(&fits))
    }

    /// From the mediator's first flag to the robot's last one.
    pub(super) fn is_acquired(&self) -> bool {
        let at = self.replica.position();
        self.replica.run() == 0 && at != Position::START && !self.replica.protocol().is_end(at)
    }

    /// Areas that the orders so far need.
    pub(super) fn areas(&self) -> &[String] {
        &self.areas
    }

    /// The robot has left an area again: it is not asked for any more, unless its order still waits for an answer.
    pub(super) fn left(&mut self, area: &str) {
        if !self.is_on_the_way(area) {
            self.areas.retain(|other| other != area);
        } else if !{ self.left.iter() }.any(|other| other == area) {
            self.left.push(area.to_owned());
        }
    }

    /// The flags set so far, for people.
    pub(super) fn describe(&self) -> String {
        let protocol = self.replica.protocol();
        protocol.describe(self.replica.position()).to_string()
    }

    pub(super) fn report(&self) -> wire::Control {
        wire::Control {
            coordination: self.coordination,
            level: Some(level::encode(self.replica.level())),
            ..wire::Control::default()
        }
    }
}
