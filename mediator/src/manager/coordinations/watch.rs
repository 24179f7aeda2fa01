//! The monitor: finds coordinations that stand still.

use super::running::Coordinations;
use super::surroundings::Surroundings;
use crate::manager::alarm::Alarm;
use crate::nets::{Instance, Phase};

/// What runs is let go on this often without news as well.
const LOOK_AGAIN_NS: u64 = 200_000_000;

impl Coordinations {
    /// Raises the alarm for what stands still, and has robots get out of the way.
    pub(crate) fn watch(&mut self, around: &mut Surroundings<'_>) {
        self.listen(around);
        self.look_again_at_what_runs(around.now_ns);
        for plan in self.plans_that_run() {
            let everybody_is_here = around.sessions.awaited().is_empty();
            let Some(instance) = self.get_mut(plan) else {
                continue;
            };
            if instance.is_idle() || !everybody_is_here {
                instance.progress_ns = around.now_ns;
                continue;
            }
            let still_ns = around.now_ns.saturating_sub(instance.progress_ns);
            if still_ns < instance.plan.alarm_after_ns {
                continue;
            }
            let was_alarmed = std::mem::replace(&mut instance.alarmed, true);
            let runs = matches!(instance.phase, Phase::Running { .. });
            let preempt = instance.plan.preempt.as_ref();
            let is_due = preempt.is_some_and(|preempt| still_ns >= preempt.after_ns);
            if !was_alarmed && let Some(instance) = self.get(plan) {
                around.effects.alarms.push(Alarm::Still {
                    coordination: self.name(plan),
                    since_s: still_ns / 1_000_000_000,
                    what: self.what_each_waits_for(instance),
                });
            }
            if is_due && !runs {
                // Areas keep them apart, wherever they are.
                around.effects.alarms.push(Alarm::LetGo {
                    coordination: self.name(plan),
                });
                self.end(plan, around);
            } else if is_due {
                around.effects.alarms.push(Alarm::Preempted {
                    coordination: self.name(plan),
                });
                self.break_off(plan, around);
            }
        }
    }

    /// That time has passed is no news of anybody.
    fn look_again_at_what_runs(&mut self, now_ns: u64) {
        if now_ns >= self.look_again_ns && self.instances().next().is_some() {
            self.look_again_ns = now_ns.saturating_add(LOOK_AGAIN_NS);
            self.note_all_running();
        }
    }

    fn what_each_waits_for(&self, instance: &Instance) -> String {
        let name = |robot: usize| self.names.robot_id(robot);
        let sentences =
            { instance.participants().iter().enumerate() }.map(|(role, participant)| {
                format!("{}: {}", name(participant.robot), instance.why(role, name))
            });
        sentences.collect::<Vec<_>>().join("; ")
    }
}
