//! What faults do to a stepped fleet, and the operator who helps it afterwards.

use onboard::cli::Failure;
use onboard::process::ctl::{Request, Teleop};
use onboard::symbols::faults::{Fault, FaultTable};
use sim::world::{Obstacle, Pose, STANDING_M_S, Shape};

use super::apart::is_near_a_robot;
use super::clones::ClonedRobot;
use super::disk::Disk;
use super::faults::Change;
use super::fleet::Stepped;
use super::mediator::SteppedMediator;
use super::robot::SteppedRobot;
use crate::scenario::ScriptedKind;
use crate::stand_ins::caretaker::{Blame, Care, where_it_is, words};

/// People and boxes come this far ahead of a robot's `base_link`,
const AHEAD_M: f64 = 1.5;
/// and have this radius,
const PERSON_M: f64 = 0.15;
/// or this length and width.
const BOX_M: [f64; 2] = [0.3, 0.4];

impl Stepped<'_> {
    /// What a fault does when it begins or ends.
    pub(super) fn apply(&mut self, change: Change, now_ns: u64) -> Result<(), Failure> {
        let Change {
            fault,
            what,
            begins,
            robot,
        } = change;
        let again = !begins && !self.faults.lasts(what, robot);
        match (what, robot) {
            (ScriptedKind::KillRobot | ScriptedKind::RebootRobot, Some(number)) if begins => {
                self.kill_robot(number, what);
            }
            (ScriptedKind::LoseNetwork, Some(number)) => {
                self.network.lose_interface(number, !again);
                if begins {
                    self.restart_robot(number, now_ns);
                }
            }
            (ScriptedKind::FillDisk, Some(number)) => {
                self.robots[number].checkpoints.fill(!again);
                if begins {
                    self.restart_robot(number, now_ns);
                }
            }
            (ScriptedKind::Panic, Some(number)) if begins => {
                let thread = self.faults.thread(fault).map(str::to_owned);
                self.have_panic(number, thread.as_deref());
            }
            (ScriptedKind::EndRobot, Some(number)) if begins => {
                let robot = self.robots[number].robot.as_mut();
                robot.into_iter().for_each(SteppedRobot::tell_to_end);
            }
            (ScriptedKind::Absent, Some(number)) if begins => self.carry_away(number)?,
            (ScriptedKind::CloneRobot, Some(number)) if begins => {
                self.start_clone(fault, number, now_ns)?;
            }
            (ScriptedKind::CloneRobot, _) => {
                let mut own = self.clones.iter_mut().filter(|own| own.fault == fault);
                own.try_for_each(|clone| clone.end(&self.world))?;
            }
            (ScriptedKind::KillMediator | ScriptedKind::RebootMediator, _) if begins => {
                self.end_mediator(what == ScriptedKind::RebootMediator, now_ns);
            }
            (ScriptedKind::KillMediator | ScriptedKind::RebootMediator, _) if again => {
                self.start_mediator(now_ns)?;
            }
            (ScriptedKind::RestoreJournal, _) if begins => self.journal_copy = self.disk.copy(),
            (ScriptedKind::RestoreJournal, _) => {
                self.kill_mediator(self.journal_copy.copy(), now_ns);
                self.start_mediator(now_ns)?;
            }
            (ScriptedKind::LoseJournal, _) if begins => {
                self.kill_mediator(Disk::default(), now_ns);
            }
            (ScriptedKind::LoseJournal, _) if again => self.start_mediator(now_ns)?,
            (ScriptedKind::FullDisk, _) if again => {
                // One that could not start for want of room does so now.
                self.disk.fill(false);
                self.start_mediator(now_ns)?;
            }
            // There are never three.
            (ScriptedKind::SecondMediator | ScriptedKind::CopiedMediator, _) if begins => {
                let copied = what == ScriptedKind::CopiedMediator;
                let disk = || {
                    if copied {
                        self.disk.copy()
                    } else {
                        Disk::default()
                    }
                };
                let plan =
                    { self.plans.mediator.as_ref() }.filter(|_| self.second_mediator.is_none());
                let started = plan.map(|plan| SteppedMediator::start(plan, disk(), now_ns));
                self.second_mediator = started.transpose()?.or(self.second_mediator.take());
            }
            (ScriptedKind::SecondMediator | ScriptedKind::CopiedMediator, _) => {
                let lasts = [ScriptedKind::SecondMediator, ScriptedKind::CopiedMediator]
                    .into_iter()
                    .any(|kind| self.faults.lasts(kind, None));
                if !lasts {
                    self.second_mediator = None;
                }
            }
            (ScriptedKind::Person | ScriptedKind::Box, Some(number)) if begins => {
                self.put_in_the_way(what, number);
            }
            (ScriptedKind::Person | ScriptedKind::Box, Some(number)) if again => {
                let mut world = self.world.lock();
                self.in_the_way.retain(|(kind, robot, thing)| {
                    let leaves = (*kind, *robot) == (what, number);
                    if leaves {
                        world.remove_obstacle(*thing);
                    }
                    !leaves
                });
            }
            (ScriptedKind::DeadLink, Some(number)) if begins => self.network.kill_sessions(number),
            (ScriptedKind::Pause, Some(number)) => {
                self.ask(number, begins.then_some(Request::Pause));
                if again {
                    self.robots[number].sending_on.want();
                }
            }
            (ScriptedKind::Stop, Some(number)) => {
                let end = again.then_some(Request::Reset);
                self.ask(number, if begins { Some(Request::Stop) } else { end });
            }
            (ScriptedKind::Reset, Some(number)) => {
                let on_purpose = self.faults.lasts(ScriptedKind::Stop, robot);
                self.ask(number, (!on_purpose).then_some(Request::Reset));
            }
            (ScriptedKind::Place, Some(number)) => {
                let words = where_it_is(&self.world.lock(), number);
                if let Some(robot) = &mut self.robots[number].robot {
                    words.into_iter().for_each(|word| robot.ask_unwanted(word));
                }
            }
            (ScriptedKind::Reload, Some(number)) => self.robots[number].reloading.want(),
            (ScriptedKind::EndCoordination, _) if begins => self.end_coordinations(),
            (ScriptedKind::Drift, None) => {
                let drift = self.faults.drift(None);
                { self.mediator.iter_mut() }.for_each(|own| own.drift(drift));
            }
            (ScriptedKind::Teleop, Some(number)) if begins => {
                let [forward_m_s, turn_rad_s] = self.faults.motion(fault);
                let truth = self.world.lock().truth(number);
                let member = &mut self.robots[number];
                if let Some(robot) = &mut member.robot {
                    if let Some(truth) = truth {
                        let state = robot.insight().look().state;
                        member.driving_out.is_taken_from(truth.pose, state);
                    }
                    robot.desk().ask(Teleop::default());
                    // As while a reload is under way, it may be refused.
                    robot.ask_unwanted(Request::Teleop(Teleop::default()));
                    robot.desk().want(forward_m_s, turn_rad_s);
                }
            }
            (ScriptedKind::Teleop, Some(number)) if again => {
                let member = &mut self.robots[number];
                (member.robot.iter_mut()).for_each(SteppedRobot::let_go);
                member.sending_on.want();
            }
            (_, Some(number)) => self.disturb_devices(change, number, now_ns),
            _ => {}
        }
        Ok(())
    }

    /// Somebody steps into a robot's way, or puts a box there, unless another robot is there.
    fn put_in_the_way(&mut self, what: ScriptedKind, number: usize) {
        let mut world = self.world.lock();
        let Some(pose) = world.truth(number).map(|truth| truth.pose) else {
            return;
        };
        let (sin, cos) = pose.theta_rad.sin_cos();
        let at_m = [pose.x_m + AHEAD_M * cos, pose.y_m + AHEAD_M * sin];
        let taken = is_near_a_robot(&world, at_m);
        let thing = if what == ScriptedKind::Box {
            Obstacle::fixed(Shape::Box {
                pose: Pose::new(at_m[0], at_m[1], pose.theta_rad),
                length_m: BOX_M[0],
                width_m: BOX_M[1],
            })
        } else {
            Obstacle::disc(at_m, PERSON_M)
        };
        if !taken && let Ok(thing) = world.add_obstacle(thing) {
            self.in_the_way.push((what, number, thing));
        }
    }

    pub(super) fn ask(&mut self, number: usize, request: Option<Request>) {
        if let (Some(robot), Some(request)) = (&mut self.robots[number].robot, request) {
            robot.ask(request);
        }
    }

    /// Plays the operator: resets robots that have latched, drives those out that find no way once all faults are over, restarts
    /// those that are taken for a clone that is gone, and notes one that is not to be helped.
    pub(super) fn look_after(&mut self, now_ns: u64) {
        let over = self.faults.are_over();
        for number in 0..self.robots.len() {
            let member = &mut self.robots[number];
            // Who has carried it back has stopped it first, and has more to say.
            let is_spoken_to = { member.robot.iter() }.any(SteppedRobot::owes_an_answer);
            let on_purpose = self.faults.lasts(ScriptedKind::Stop, Some(number)) || is_spoken_to;
            // What a robot said before it was killed is over.
            let runs = member.robot.is_some();
            let faults = if runs {
                member.faults
            } else {
                FaultTable::default()
            };
            let truth = self.world.lock().truth(number);
            let speed_m_s = truth.map_or(0.0, |truth| truth.twist.v_m_s.abs());
            let is_lost = [Fault::PoseUncertain, Fault::PlaceUnknown]
                .into_iter()
                .any(|fault| faults.state(fault).active != 0);
            if runs && !is_lost && speed_m_s > STANDING_M_S {
                // From then on people would have to look.
                member.was_in = None;
                member.has_driven = true;
            }
            let lasts = self.faults.hinders(number);
            let blame = Blame::Faults {
                blamed: &|fault, since_ns| self.faults.are_blamed(number, fault, since_ns),
                lasts,
            };
            let before = member.caretaker;
            match member.caretaker.look(&faults, now_ns, on_purpose, blame) {
                Care::None => {}
                // Nobody asks twice before there is an answer.
                Care::Reset if { member.robot.iter() }.any(SteppedRobot::owes_an_answer) => {
                    member.caretaker.asks_nothing(before);
                }
                Care::Reset => {
                    let was_in = self.robots[number].was_in.clone();
                    let words = words(&faults, &self.world.lock(), number, was_in.as_deref());
                    for word in words {
                        self.ask(number, Some(word));
                    }
                }
                Care::GiveUp(fault) => self.stranded = Some((fault, faults.state(fault).since_ns)),
            }
            let member = &mut self.robots[number];
            if over && let Some(robot) = &mut member.robot {
                let mut world = self.world.lock();
                if (member.driving_out).look(robot, &faults, &mut world, number, now_ns) {
                    member.sending_on.want();
                }
            }
            let held = [ScriptedKind::Pause, ScriptedKind::Teleop]
                .into_iter()
                .any(|what| self.faults.lasts(what, Some(number)));
            let held = held || member.driving_out.lasts();
            if let Some(robot) = &mut member.robot {
                (member.sending_on).look(robot, &faults, held, now_ns);
                let share = self.faults.share(ScriptedKind::Reload, number);
                let (files, plan) = &self.plans.robots[number];
                (member.reloading).look(robot, (files, plan), (share, held), now_ns);
            }
            let clones = { self.clones.iter() }.filter(|own| own.begun && own.of == member.id);
            let clone = clones.map(ClonedRobot::is_running).max();
            if member.restarting.look(&faults, clone, now_ns) {
                self.restart_robot(number, now_ns);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::stepped::{Plans, Stepped};
    use crate::testing;

    #[test]
    fn a_clone_stands_on_the_floor_while_its_fault_lasts_and_answers_reach_both() {
        let mut scenario = testing::scenario("overtaking");
        let fault = |text: &str| toml::from_str(&text.replace(", ", "\n")).expect("a fault");
        scenario.faults = vec![fault(
            "at_s = 1.0, for_s = 2.0, what = \"clone-robot\", robot = \"amr-1\", pose = [4.0,1.0,180.0]",
        )];
        let plans = Plans::of(&scenario).expect("plans");
        let mut stepped = Stepped::new(&scenario, &plans, 1, true, false).expect("built");
        let at_m = |stepped: &Stepped<'_>| {
            let truth = stepped.world.lock().truth(2).expect("a body");
            [truth.pose.x_m, truth.pose.y_m]
        };
        let store = [20.0, -1.6];
        for (until_s, expected) in [(0.5, store), (1.5, [4.0, 1.0]), (3.5, store)] {
            while (stepped.now_ns() as f64) < (until_s + 1.0) * 1e9 {
                stepped.advance().expect("it runs");
            }
            assert_eq!(at_m(&stepped), expected, "at {until_s} s");
        }
        assert!(stepped.clones[0].begun);
    }

    #[test]
    fn each_robots_clock_counts_from_when_its_computer_was_switched_on() {
        let mut scenario = testing::scenario("overtaking");
        let reboot = "at_s = 4.0\nfor_s = 1.0\nwhat = \"reboot-robot\"\nrobot = \"amr-1\"";
        scenario.faults = vec![toml::from_str(reboot).expect("a fault")];
        let plans = Plans::of(&scenario).expect("plans");
        let mut stepped = Stepped::new(&scenario, &plans, 1, true, false).expect("built");
        let mut own_s = Vec::new();
        for until_s in [3.9, 7.0] {
            while (stepped.now_ns() as f64) < (until_s + 1.0) * 1e9 {
                stepped.advance().expect("it runs");
            }
            let now_s = stepped.now_ns() as f64 / 1e9;
            own_s.push([0, 1].map(|number: usize| {
                let robot = stepped.robots[number].robot.as_mut().expect("it runs");
                let stamp_ns = robot.insight().look().stamp_ns;
                let age_s = now_s - stamp_ns as f64 / 1e9;
                assert!(
                    (0.0..0.3).contains(&age_s),
                    "{age_s} s by the world's clock"
                );
                now_s + robot.clock().ahead_ns() / 1e9
            }));
        }
        let [[one_s, other_s], [rebooted_s, _]] = own_s[..] else {
            panic!("two looks");
        };
        assert!(one_s > 60.0 && (one_s - other_s).abs() > 60.0, "{own_s:?}");
        assert!((3.0..8.0).contains(&rebooted_s), "{own_s:?}");
    }
}
