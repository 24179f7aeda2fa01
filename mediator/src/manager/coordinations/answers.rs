//! Robots that do not answer `acquire`: they must not hold those that do.

use contract::protocols::ACQUIRE;
use contract::timing::ACQUIRED_WITHIN_NS;
use contract::wire::Control;
use coordination::protocol::Side;

use super::answer::Answer;
use super::running::Coordinations;
use super::surroundings::Surroundings;
use crate::manager::alarm::Alarm;
use crate::nets::Instance;

/// A robot that has not answered takes part in nothing for this time.
const MUTE_NS: u64 = 60_000_000_000;

/// Every path of protocol 2 begins with `acquire` and `acquired`.
const ACQUIRED_PROGRESS: u32 = 2;

/// The robot has handed its discrete control over. One that is stuck repeats for ever that it was asked to, and so do reports that
/// are late.
fn says_acquired(control: &Control) -> bool {
    let progress = control.level.as_ref().map_or(0, |level| level.progress);
    progress >= ACQUIRED_PROGRESS
}

impl Coordinations {
    /// The robot has not answered of late.
    pub(super) fn is_mute(&self, robot: usize, now_ns: u64) -> bool {
        now_ns < self.answers[robot].mute_until_ns
    }

    /// A robot that answers late may be asked again. What it says of another coordination than that which it did not answer is no
    /// answer: it may repeat for ever what it said in an earlier one, or make up numbers.
    pub(crate) fn take_answer(&mut self, robot: usize, control: &Control) {
        let own = self.answers[robot];
        if own.mute_until_ns > 0 && own.mute_in == control.coordination && says_acquired(control) {
            self.may_answer(robot);
        }
    }

    /// A robot that was out of reach, or has answered, may be asked again.
    pub(crate) fn may_answer(&mut self, robot: usize) {
        self.answers[robot].mute_until_ns = 0;
        self.look_again_at(robot);
    }

    /// Nobody could be asked, or answer, for so long.
    pub(crate) fn put_off(&mut self, by_ns: u64) {
        for (_, since_ns) in self.answers.iter_mut().filter_map(|own| own.asked.as_mut()) {
            *since_ns = since_ns.saturating_add(by_ns);
        }
        for instance in self.instances_mut() {
            instance.progress_ns = instance.progress_ns.saturating_add(by_ns);
        }
    }

    /// Ends coordinations that a robot has not answered for too long.
    pub(super) fn listen(&mut self, around: &mut Surroundings<'_>) {
        let mut asked = vec![None; self.answers.len()];
        for instance in self.instances() {
            for (role, participant) in instance.participants().iter().enumerate() {
                if instance.waits_for_acquired(role) {
                    asked[participant.robot] = Some(instance.number);
                }
            }
        }
        for (robot, number) in asked.into_iter().enumerate() {
            let answer = &mut self.answers[robot];
            let Some(number) = number else {
                answer.asked = None;
                continue;
            };
            let since_ns = { answer.asked }
                .filter(|asked| asked.0 == number)
                .map_or(around.now_ns, |asked| asked.1);
            answer.asked = Some((number, since_ns));
            if around.now_ns < since_ns.saturating_add(ACQUIRED_WITHIN_NS) {
                continue;
            }
            *answer = Answer {
                asked: None,
                mute_until_ns: around.now_ns.saturating_add(MUTE_NS),
                mute_in: number,
            };
            self.candidates.note_mute(robot);
            let plans = self.plans_that_run();
            let plan = { plans.into_iter() }
                .find(|&plan| self.get(plan).is_some_and(|own| own.number == number));
            if let Some(plan) = plan {
                around.effects.alarms.push(Alarm::Mute {
                    robot: self.names.robot_id(robot),
                    coordination: self.name(plan),
                });
                self.end(plan, around);
            }
        }
    }
}

impl Instance {
    /// The robot of a role is told `acquire`, and has not said `acquired`.
    fn waits_for_acquired(&self, role: usize) -> bool {
        let participant = &self.participants()[role];
        let protocol = participant.protocol();
        let acquire = protocol.flag(ACQUIRE);
        let told =
            { protocol.set_flags(participant.read_to()) }.any(|(flag, _)| Some(flag) == acquire);
        self.controls(participant.robot) == Some(role) && told && !self.is_known_to(role)
    }
}
