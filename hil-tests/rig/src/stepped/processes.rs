//! Processes of a stepped fleet that faults kill and start: robots, their clones, and the mediator.

use description::threads::ActivityKind;
use onboard::cli::Failure;
use onboard::symbols::faults::Fault;

use super::clock::{START_NS, ahead_after_boot_ns};
use super::clones::{ClonedRobot, store};
use super::fleet::Stepped;
use super::member::Member;
use super::start::Start;
use crate::scenario::{STARTED_AGAIN_S, ScriptedKind};

/// A process that ends is started again so much later.
const STARTED_AGAIN_NS: u64 = (STARTED_AGAIN_S * 1e9) as u64;

impl Stepped<'_> {
    /// A robot's process is killed, or its computer loses its power, in the step that is to come.
    pub(super) fn kill_robot(&mut self, number: usize, what: ScriptedKind) {
        let killed = &mut self.robots[number].killed;
        // Who loses power loses more than who is killed.
        *killed = killed
            .filter(|own| *own == ScriptedKind::RebootRobot)
            .or(Some(what));
    }

    /// The process of a robot that was killed by this has had its last turn.
    pub(super) fn lose_process(&mut self, number: usize, what: ScriptedKind, now_ns: u64) {
        self.remember_state(number);
        let member = &mut self.robots[number];
        if what != ScriptedKind::KillRobot {
            member.checkpoints.lose_memory();
        }
        member.end_process();
        if what == ScriptedKind::RebootRobot {
            member.ahead_ns = ahead_after_boot_ns(now_ns);
        }
    }

    /// A robot's process is killed, and its service starts the next one.
    pub(super) fn restart_robot(&mut self, number: usize, now_ns: u64) {
        self.kill_robot(number, ScriptedKind::KillRobot);
        let member = &mut self.robots[number];
        member.starts_ns = { member.starts_ns }.max(now_ns + STARTED_AGAIN_NS);
    }

    /// The state of a robot's machine, as people heard it last.
    pub(super) fn remember_state(&mut self, number: usize) {
        let member = &mut self.robots[number];
        let said = self.observations.said(&member.id);
        let said = said.filter(|said| !said.state.fsm_state.is_empty());
        if let Some(said) = said
            && (member.has_driven || member.faults.state(Fault::PlaceUnknown).active == 0)
        {
            member.was_in = Some(said.state.fsm_state.clone());
        }
    }

    /// What runs on this thread of a robot panics; without one what runs its drive.
    pub(super) fn have_panic(&mut self, number: usize, thread: Option<&str>) {
        let (_, plan) = &self.plans.robots[number];
        let drives =
            { plan.robot.threads.iter() }.find(|own| own.activities.contains(&ActivityKind::Drive));
        let thread = thread.or_else(|| drives.map(|own| own.name.as_str()));
        let robot = self.robots[number].robot.as_mut();
        if let (Some(robot), Some(thread)) = (robot, thread) {
            robot.ends().expect_panic();
            robot.panic(thread);
        }
    }

    /// Processes that panic although no fault of the scenario has them do so: that is the program's own fault.
    pub(super) fn note_panicked(&mut self, now_ns: u64) {
        let at_s = now_ns.saturating_sub(START_NS) as f64 / 1e9;
        let robots = { self.robots.iter_mut() }
            .filter_map(|member| Some((member.robot.as_mut()?, &member.id)));
        let clones = self.clones.iter_mut().filter_map(ClonedRobot::running);
        for (robot, id) in robots.chain(clones) {
            if robot.ends().panics_by_itself() {
                let detail =
                    format!("a thread of its program panicked at {at_s:.1} s, and it ended");
                self.panicked.push((id.clone(), detail));
            }
        }
    }

    /// Robots whose processes have ended after a panic, or because they were told to.
    pub(super) fn note_ended(&mut self) {
        for number in 0..self.robots.len() {
            let robot = self.robots[number].robot.as_ref();
            if robot.is_some_and(|robot| robot.has_ended()) {
                self.remember_state(number);
                self.robots[number].end_process();
            }
        }
    }

    /// Whether a robot that does not run is to be started.
    pub(super) fn may_start(&self, number: usize, now_ns: u64) -> bool {
        let member = &self.robots[number];
        let lasts = |what| self.faults.lasts(what, Some(number));
        let off = [
            ScriptedKind::KillRobot,
            ScriptedKind::RebootRobot,
            ScriptedKind::Sleep,
            ScriptedKind::Panic,
            ScriptedKind::EndRobot,
        ];
        // Nor does a fault let one start that has not run yet.
        let kept = off.into_iter().any(lasts) || member.gone;
        member.robot.is_none() && !kept && now_ns >= member.starts_ns
    }

    /// A robot is switched off and carried away.
    ///
    /// # Errors
    /// [`Failure`] when something is in the store, where nothing comes.
    pub(super) fn carry_away(&mut self, number: usize) -> Result<(), Failure> {
        let member = &mut self.robots[number];
        member.checkpoints.lose_memory();
        member.end_process();
        member.gone = true;
        let site = &self.plans.robots[number].1.site;
        let carried = self.world.lock().carry(number, store(site, 1, number));
        carried.map_err(Failure::failed)
    }

    /// Tells the mediator again and again that robots are absent which were carried away, until it has understood.
    pub(super) fn say_who_is_absent(&mut self) {
        let Some(mediator) = &mut self.mediator else {
            return;
        };
        for (number, member) in self.robots.iter().enumerate() {
            if self.faults.lasts(ScriptedKind::Absent, Some(number)) {
                mediator.say_absent(&member.id);
            }
        }
    }

    /// Switches on the clone of this fault, with the identity of robot `number`.
    pub(super) fn start_clone(
        &mut self,
        fault: usize,
        number: usize,
        now_ns: u64,
    ) -> Result<(), Failure> {
        let start = Start {
            ahead_ns: ahead_after_boot_ns(now_ns),
            ..self.start_of(number, now_ns)
        };
        let folder = self.plans.folder.below()?;
        let plan = &self.plans.robots[number];
        if let Some(clone) = self.clones.iter_mut().find(|own| own.fault == fault) {
            let robot = clone.begin(&self.world, plan, start, folder)?;
            robot.allow(&self.robots[number].allowed);
        }
        Ok(())
    }
}

impl Member {
    /// Its process is gone, without a farewell.
    fn end_process(&mut self) {
        self.devices.hang_up();
        self.has_driven = false;
        self.motors_off.forget_process();
        let Some(mut robot) = self.robot.take() else {
            return;
        };
        self.ahead_ns = robot.clock().ahead_ns();
        let faults = robot.insight().faults();
        for (count, fault) in self.raised_before.iter_mut().zip(Fault::ALL) {
            *count += faults.state(fault).count;
        }
    }
}
