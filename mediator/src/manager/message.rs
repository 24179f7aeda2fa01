//! What the manager says to a robot.

use super::run::Run;
use super::{LEVEL_NS, Manager};
use contract::wire::{AccessGrant, Control, MediatorReport, RobotReport, TakeUp};
use contract::{VERSION, level};

/// So many refusals wait to be sent; of more, the oldest is left out and comes again with the next report.
const STRANGERS: usize = 32;

impl Manager {
    /// The whole of what the robot must know, as of now.
    pub(super) fn message(
        &mut self,
        robot: usize,
        boot_epoch: u64,
        session: u64,
        now_ns: u64,
    ) -> MediatorReport {
        self.robots[robot].sent += 1;
        self.explain_waits(robot, now_ns);
        let state = &self.robots[robot];
        let refusal = state.refusal(boot_epoch);
        let refused = !refusal.is_empty();
        let mut access = Vec::with_capacity(state.runs.len());
        let known = { state.runs.iter() }.filter(|(_, run)| run.is_known() && !refused);
        access.extend(known.map(|(area, run)| AccessGrant {
            area: self.areas[area].id.clone(),
            level: Some(level::encode(run.level())),
            fence: run.fence,
            waits_for: if run.waits() {
                run.why.1.clone()
            } else {
                String::new()
            },
        }));
        MediatorReport {
            version: Some(VERSION.into()),
            mediator_epoch: self.epoch,
            sequence: state.sent,
            robot_id: state.id.clone(),
            boot_epoch,
            session: if refused { 0 } else { session },
            refusal: refusal.to_owned(),
            role: state.role.clone(),
            access,
            revocations: self.revocations_of(robot),
            control: self.control(robot).filter(|_| !refused),
            take_up: self.take_up(robot, session),
        }
    }

    /// Says why the robot waits. That is for people, and may be as old as a level.
    fn explain_waits(&mut self, robot: usize, now_ns: u64) {
        let old = |run: &Run| run.why.0 == 0 || now_ns >= run.why.0.saturating_add(LEVEL_NS);
        let runs = self.robots[robot].runs.iter();
        let due: Vec<usize> = runs
            .filter(|(_, run)| run.waits() && old(run))
            .map(|(area, _)| area)
            .collect();
        for area in due {
            let why = self.explain(robot, area, now_ns);
            if let Some(run) = self.robots[robot].runs.get_mut(area) {
                run.why = (now_ns.max(1), why);
            }
        }
    }

    /// Protocol 2, for a robot that a coordination has acquired or is about to.
    fn control(&self, robot: usize) -> Option<Control> {
        let (instance, role) = self.coordinator.control_of(robot)?;
        let script = instance.script(role);
        Some(Control {
            coordination: instance.number,
            level: Some(level::encode(instance.parts[role].level())),
            net: instance.plan.net.clone(),
            flags: script.flags.clone(),
            paths: script.paths.clone(),
        })
    }

    /// Tells a robot that the site does not list why nobody answers it.
    pub(super) fn refuse_stranger(&mut self, report: &RobotReport, refusal: String) {
        if self.strangers.len() == STRANGERS {
            self.strangers.remove(0);
        }
        self.strangers.push(MediatorReport {
            version: Some(VERSION.into()),
            mediator_epoch: self.epoch,
            // The robot's own number grows, so it takes the next refusal for news too.
            sequence: report.sequence,
            robot_id: report.robot_id.clone(),
            boot_epoch: report.boot_epoch,
            refusal,
            ..MediatorReport::default()
        });
    }

    /// For a robot that has not yet said where it is, and that left something behind when it restarted.
    fn take_up(&self, robot: usize, session: u64) -> Option<TakeUp> {
        let state = &self.robots[robot];
        let was_there = !state.fsm_state.is_empty();
        (was_there && (session != state.session || !state.placed)).then(|| TakeUp {
            // Known only if this mediator has heard it: from a journal the pose would be too old.
            pose: state.pose,
            fsm_state: state.fsm_state.clone(),
        })
    }
}
