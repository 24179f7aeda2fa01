//! A navigator replaces another while the robot drives: new gains or a new map.

use super::instruction::Instruction;
use super::state::Navigator;

impl Navigator {
    /// Goes on where `other`, of the same robot, is: its pose with the covariance, its state (by name), what an
    /// instruction brought, events that wait, and, where the state's controller and lanes are the same here, the
    /// manoeuvre under way. The trackers of features start again.
    ///
    /// `false`: this machine has no such state, and nothing changes. Real time.
    pub fn take_over(&mut self, other: &Self) -> bool {
        let name = other.machine.state_name(other.machine.state());
        let Some(state) = self.machine.state_id(name) else {
            return false;
        };
        self.machine.restart_in(state);
        self.pose.adopt(&other.pose);
        self.parameters = other.parameters;
        self.counters = other.counters;
        (self.last_step_ns, self.last_scan_ns) = (other.last_step_ns, other.last_scan_ns);
        (self.blind, self.check) = (other.blind, other.check);
        self.by_hand = other.by_hand;
        self.last_curvature_1_m = other.last_curvature_1_m;
        self.take_events(other);
        self.activate(None);
        if self.has_same_task(other) {
            (self.motion, self.began) = (other.motion, other.began);
            (self.stopping, self.halting) = (other.stopping, other.halting);
            self.instructed = other.instructed;
            self.in_state_s = other.in_state_s;
        }
        true
    }

    /// Events by their names: the machines may number them differently.
    fn take_events(&mut self, other: &Self) {
        let mut inbox = other.inbox.clone();
        while let Some(instruction) = inbox.pop_front() {
            let name = other.machine.input_name(instruction.event);
            let taken = self.machine.input(name).is_some_and(|event| {
                self.inbox.push(Instruction {
                    event,
                    ..instruction
                })
            });
            self.counters.events_lost += u64::from(!taken);
        }
    }

    fn has_same_task(&self, other: &Self) -> bool {
        let (ours, theirs) = (self.schedule_now(), other.schedule_now());
        let line = |navigator: &Self, lane: Option<usize>| {
            lane.map(|lane| navigator.map.lanes()[lane].line)
        };
        ours.controller == theirs.controller
            && line(self, ours.lane) == line(other, theirs.lane)
            && line(self, ours.from_lane) == line(other, theirs.from_lane)
    }
}
