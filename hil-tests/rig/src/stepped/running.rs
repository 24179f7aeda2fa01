//! What has a thread of its own in the robot file.

use std::sync::Arc;

use coordination::symbols::Writer;
use description::threads::{ThreadConfig, Trigger as ConfigTrigger};
use drivers::Clock as _;
use onboard::activities::news::Alarm;
use onboard::activities::robot_activity::ThreadActivities;
use onboard::process::runner::{EventLoop, Trigger};
use onboard::realtime::panic::Panicked;
use onboard::symbols::values::ThreadReport;
use sim::world::Random;

use super::asynchronous::Asynchronous;
use super::clock::STEP_NS;
use super::late::Lateness;
use super::late::{Late, late_ns};
use super::panics::Panicking;
use super::thread::{Step, ThreadClock};

/// A thread of a robot, with its name.
pub(super) struct Running {
    pub(super) name: String,
    /// It has ended by a panic.
    dead: bool,
    what: What,
}

enum What {
    /// A thread as it is.
    Thread(Panicking),
    /// The asynchronous one: tokio cannot run here.
    Asynchronous(Box<Asynchronous>),
}

impl Running {
    /// A thread of the thread table.
    pub(super) fn new(
        thread: &ThreadConfig,
        (trigger, clock): (Trigger, Arc<ThreadClock>),
        parts: (ThreadActivities, Writer<ThreadReport>),
        (alarm, panicked): (&Alarm, &Panicked),
        boot_epoch: u64,
    ) -> Self {
        let what = if thread.trigger == ConfigTrigger::Async {
            let (begin_ns, late) = (clock.now_ns(), Late::new(boot_epoch ^ 1));
            let own = Asynchronous::new(parts, &trigger, (alarm, late), begin_ns);
            What::Asynchronous(Box::new(own))
        } else {
            let (activities, report) = parts;
            let make = move |clock| EventLoop::new(trigger, activities, report, clock);
            What::Thread(Panicking::new(clock, make, panicked.clone()))
        };
        Self {
            name: thread.name.clone(),
            dead: false,
            what,
        }
    }

    /// It panics, by the end of its present turn.
    pub(super) fn panic(&mut self, panicked: &Panicked) {
        match &self.what {
            What::Thread(own) => own.panic(),
            // Nothing is left of it to stop the robot.
            What::Asynchronous(_) => {
                self.dead = true;
                panicked.raise();
            }
        }
    }

    /// Lets it go on through a step.
    pub(super) fn go_on(&mut self, step: Step, late: &[Lateness], random: &mut Random) {
        match &mut self.what {
            What::Thread(own) => own.thread.go_on(step, || late_ns(late, &self.name, random)),
            What::Asynchronous(own) if !self.dead => own.go_on((late, &self.name), step.begin_ns),
            What::Asynchronous(_) => {}
        }
    }
}

/// How long after the robot a thread starts: less than a period, in whole steps.
pub(super) fn phase_ns(trigger: &Trigger, random: &mut Random) -> u64 {
    let Trigger::Period(period_ns) = trigger else {
        return 0;
    };
    let slots = (period_ns / STEP_NS).max(1);
    (random.unit() * slots as f64) as u64 * STEP_NS
}
