//! The navigator's discrete side: monitors, the machine, and the exchange of schedules.

use super::control::Control;
use super::instruction::{Instruction, Parameters};
use super::output::EventList;
use super::state::{Navigator, end_wall};
use crate::monitors::Situation;
use crate::schedule::Controller;
use crate::tubes::turning_back_m;
use coordination::fsm::StateId;

impl Navigator {
    /// Steps the schedule's monitors.
    pub(super) fn watch(&mut self, control: &Control, events: &mut EventList) {
        let schedule = &mut self.schedules[self.machine.state().index()];
        let situation = Situation {
            pose: self.pose.pose(),
            corridor: self
                .corridor
                .estimate()
                .filter(|_| schedule.features.corridor),
            lane_end: self
                .lane_end
                .estimate()
                .filter(|_| schedule.features.lane_end),
            manoeuvre_done: control.done,
            lateral_error_m: control.steer.error.lateral_m,
            turning_back_m: turning_back_m(
                control.steer.error.lateral_m,
                control.steer.error.heading_rad,
                self.gains.max_curvature_1_m,
            ),
            deviation_limit_m: schedule.deviation_limit_m,
            in_state_s: self.in_state_s,
        };
        for monitor in &mut schedule.monitors {
            if let Some(event) = monitor.step(&situation)
                && !events.push(event)
            {
                self.counters.events_lost += 1;
            }
        }
    }

    /// Steps the machine with what was posted, then with what fired here.
    pub(super) fn coordinate(&mut self, fired: &EventList, outputs: &mut EventList) {
        let state = self.machine.state();
        while let Some(instruction) = self.inbox.pop_front() {
            let stood = matches!(self.schedule_now().controller, Controller::Stop);
            if self.trigger(instruction, outputs) && stood {
                self.let_return();
            }
        }
        for &event in fired.as_slice() {
            if self.machine.state() != state {
                // What else fired belongs to the schedule that has just ended.
                break;
            }
            self.trigger(Instruction::plain(event), outputs);
        }
    }

    /// Steps the machine; whether it is in another state now.
    fn trigger(&mut self, instruction: Instruction, outputs: &mut EventList) -> bool {
        let step = self.machine.step(instruction.event);
        let (from, to, ignored) = (step.from, step.to, step.ignored);
        for &output in step.outputs {
            if !outputs.push(output) {
                self.counters.events_lost += 1;
            }
        }
        let parameters = instruction.with_event(());
        if from != to {
            self.parameters = parameters;
            self.activate(Some(from));
        } else if !ignored && parameters != Parameters::default() {
            // The state goes on, its path as well.
            self.parameters = parameters;
            self.begin_parameters();
        }
        from != to
    }

    /// The robot was sent on from where it stood, possibly off its path.
    pub(super) fn let_return(&mut self) {
        let state = self.machine.state().index();
        for monitor in &mut self.schedules[state].monitors {
            monitor.reset_for_return();
        }
    }

    /// Exchanges the schedule for that of the machine's state.
    pub(super) fn activate(&mut self, from: Option<StateId>) {
        self.in_state_s = 0.0;
        let (std_m, std_rad) = (self.pose.position_std_m(), self.pose.heading_std_rad());
        let pose = self.pose.pose();
        let before = from.map(|state| &self.schedules[state.index()]);
        let present = &self.schedules[self.machine.state().index()];
        let keeps_corridor = before.is_some_and(|before| {
            before.features.corridor
                && before.lane == present.lane
                && self.corridor.estimate().is_some()
        });
        let keeps_end = before.is_some_and(|before| {
            before.features.lane_end
                && end_wall(&self.map, before).map(|wall| wall.index)
                    == end_wall(&self.map, present).map(|wall| wall.index)
        });
        if !keeps_end {
            self.lane_end.clear();
        }
        match present.lane.filter(|_| present.features.corridor) {
            None => self.corridor.clear(),
            Some(_) if keeps_corridor => {}
            Some(lane) => {
                let lane = &self.map.lanes()[lane];
                let across_m = self.std_across_m(lane.direction_rad);
                self.corridor
                    .start(lane, pose, across_m.min(std_m), std_rad);
            }
        }
        self.begin_motion();
        let state = self.machine.state().index();
        for monitor in &mut self.schedules[state].monitors {
            monitor.reset();
        }
    }
}
