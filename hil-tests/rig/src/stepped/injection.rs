//! What faults do to a stepped fleet, and the operator who helps it afterwards.

use onboard::cli::Failure;
use onboard::process::ctl::Request;
use onboard::symbols::faults::Resumes;
use sim::world::Obstacle;

use super::faults::Change;
use super::fleet::Stepped;
use super::mediator::SteppedMediator;
use crate::scenario::ScriptedKind;

/// Where faults are injected, an operator resets a robot that has latched for this long.
const RESET_AFTER_NS: u64 = 3_000_000_000;
/// People step this far ahead of a robot's `base_link`,
const AHEAD_M: f64 = 1.5;
/// no nearer than this to another one's,
const APART_M: f64 = 1.0;
/// and have this radius.
const PERSON_M: f64 = 0.15;

impl Stepped<'_> {
    /// What a fault does when it begins or ends.
    pub(super) fn apply(&mut self, change: Change, now_ns: u64) -> Result<(), Failure> {
        let Change {
            what,
            begins,
            robot,
        } = change;
        let again = !begins && !self.faults.lasts(what, robot);
        match (what, robot) {
            (ScriptedKind::KillRobot, Some(number)) => {
                let member = &mut self.robots[number];
                if begins {
                    member.robot = None;
                }
                member.killed = !again;
            }
            (ScriptedKind::KillMediator, _) if begins => {
                // What it has not written by now is gone.
                self.disk = self.disk.copy();
                self.mediator = None;
                if let Some((_, end_ns)) = self.mediator_spans_ns.last_mut() {
                    end_ns.get_or_insert(now_ns);
                }
            }
            (ScriptedKind::KillMediator, _) if again => {
                if let Some(plan) = &self.plans.mediator {
                    self.mediator = Some(SteppedMediator::start(plan, self.disk.clone(), now_ns)?);
                    self.mediator_spans_ns.push((now_ns, None));
                }
            }
            (ScriptedKind::Person, Some(number)) if begins => self.place_person(number),
            (ScriptedKind::Person, Some(number)) if again => {
                let world = &mut self.world;
                self.people.retain(|(robot, person)| {
                    let leaves = *robot == number;
                    if leaves {
                        world.remove_obstacle(*person);
                    }
                    !leaves
                });
            }
            (ScriptedKind::Pause, Some(number)) => {
                let end = again.then_some(Request::Resume);
                self.ask(number, if begins { Some(Request::Pause) } else { end });
            }
            (ScriptedKind::Stop, Some(number)) => {
                let end = again.then_some(Request::Reset);
                self.ask(number, if begins { Some(Request::Stop) } else { end });
            }
            _ => {}
        }
        Ok(())
    }

    /// Somebody steps into a robot's way, unless another robot is there.
    fn place_person(&mut self, number: usize) {
        let Some(pose) = self.world.truth(number).map(|truth| truth.pose) else {
            return;
        };
        let (sin, cos) = pose.theta_rad.sin_cos();
        let at_m = [pose.x_m + AHEAD_M * cos, pose.y_m + AHEAD_M * sin];
        let taken = (0..self.robots.len())
            .filter_map(|other| self.world.truth(other))
            .any(|truth| (truth.pose.x_m - at_m[0]).hypot(truth.pose.y_m - at_m[1]) < APART_M);
        if !taken && let Ok(person) = self.world.add_obstacle(Obstacle::disc(at_m, PERSON_M)) {
            self.people.push((number, person));
        }
    }

    fn ask(&mut self, number: usize, request: Option<Request>) {
        if let (Some(robot), Some(request)) = (&mut self.robots[number].robot, request) {
            robot.ask(request);
        }
    }

    /// An operator resets robots that have latched for a while, where faults are injected.
    pub(super) fn reset_latched(&mut self, now_ns: u64) {
        if self.faults.is_empty() {
            return;
        }
        for number in 0..self.robots.len() {
            let member = &mut self.robots[number];
            let faults = &member.faults;
            let latched = { faults.active() }
                .filter(|fault| fault.resumes() == Resumes::Operator)
                .any(|fault| now_ns > faults.state(fault).since_ns + RESET_AFTER_NS);
            let stopped = self.faults.lasts(ScriptedKind::Stop, Some(number));
            if latched && !stopped && now_ns > member.reset_ns + RESET_AFTER_NS {
                member.reset_ns = now_ns;
                self.ask(number, Some(Request::Reset));
            }
        }
    }
}
