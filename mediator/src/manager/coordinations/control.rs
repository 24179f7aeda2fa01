//! What robots report of their discrete control.

use contract::level;
use contract::wire::{Control, RobotReport};

use super::running::Coordinations;
use super::surroundings::Surroundings;
use crate::manager::alarm::{Alarm, BadReport};

/// No coordination gets a larger number. What is taken over from a robot leaves half of all to count on.
const LAST_NUMBER: u64 = 1 << 62;

impl Coordinations {
    /// Takes in how far a robot is with its discrete control.
    pub(crate) fn take_in(
        &mut self,
        robot: usize,
        report: &RobotReport,
        first: bool,
        around: &mut Surroundings<'_>,
    ) {
        if first {
            let number = report.control.as_ref().map_or(0, |own| own.coordination);
            self.miss_control(robot, number, around);
        }
        let Some(control) = &report.control else {
            return;
        };
        if control.coordination > self.number().max(LAST_NUMBER / 2) {
            self.complain(robot, BadReport::Number(control.coordination), around);
            return;
        }
        if control.coordination > self.number() {
            // The journal has lost its last entries: never give that number again.
            self.skip_to(control.coordination, around.effects);
        }
        let found = self.plans_that_run().into_iter().find(|&plan| {
            self.get(plan).is_some_and(|instance| {
                instance.number == control.coordination && instance.robots().contains(&robot)
            })
        });
        let Some(plan) = found else {
            // It is over, or another one has begun; the robot does not know yet.
            around.effects.tell(robot);
            return;
        };
        match self.merge(plan, robot, control, around) {
            Ok(()) => {}
            Err(BadReport::Merge(_)) if first => self.forgotten(plan, robot, around),
            Err(what) => self.complain(robot, what, around),
        }
    }

    /// A robot that was released before a power loss, which the journal does not know, never reports that coordination again.
    fn miss_control(&mut self, robot: usize, number: u64, around: &mut Surroundings<'_>) {
        let missing = self.control_of(robot).is_some_and(|(instance, role)| {
            instance.number != number && instance.is_known_to(role)
        });
        if missing && let Some(&plan) = self.plans_that_control(robot).first() {
            self.forgotten(plan, robot, around);
        }
    }

    /// A robot has other areas than was known: the nets that go by its areas would draw wrong conclusions.
    pub(crate) fn surprised_by(&mut self, robot: usize, around: &mut Surroundings<'_>) {
        for plan in self.plans_that_run() {
            if { self.get(plan) }.is_some_and(|own| own.robots().contains(&robot)) {
                self.forgotten(plan, robot, around);
            }
        }
    }

    /// The journal lacks what a robot was told in a coordination.
    fn forgotten(&mut self, plan: usize, robot: usize, around: &mut Surroundings<'_>) {
        around.effects.alarms.push(Alarm::Forgotten {
            coordination: self.name(plan),
            robot: self.names.robot_id(robot),
        });
        self.break_off(plan, around);
    }

    fn merge(
        &mut self,
        plan: usize,
        robot: usize,
        control: &Control,
        around: &mut Surroundings<'_>,
    ) -> Result<(), BadReport> {
        let level = level::decode(control.level.as_ref())?;
        let participants = self
            .get_mut(plan)
            .into_iter()
            .flat_map(|own| own.participants_mut());
        if let Some(participant) = { participants }.find(|participant| participant.robot == robot) {
            participant.merge(level)?;
            if participant.has_unread() {
                around.sessions.drop_candidate(robot);
            }
        }
        Ok(())
    }

    fn complain(&self, robot: usize, what: BadReport, around: &mut Surroundings<'_>) {
        around.effects.counters.bad += 1;
        around.effects.alarms.push(Alarm::BadControl {
            robot: self.names.robot_id(robot),
            what,
        });
    }
}
