//! `onboard ctl reload`: new gains, limits, tubes and map for a running robot, all or nothing.
//!
//! The files are read, checked and made into new parts on a thread of their own, while the robot drives on. Only then is
//! it paused: navigation first; once it stands, motion tube and control as well. When all three are paused they are told
//! to reconfigure, and only when all three *are* reconfiguring, the parts are handed over: from there on nothing can fail.
//! Whatever goes wrong before changes nothing, and is told.
//!
//! The activities swap the parts and hand the old ones back, so that no real-time thread allocates or releases anything.

use std::thread::JoinHandle;

use rtrb::{Consumer, Producer, RingBuffer};
use skills::drive::WheelController;
use skills::tubes::MotionTubes;

use crate::activities::navigation::{self, MachineNames};
use crate::cli::{Failure, Files};
use crate::composition::plan::Plan;
use crate::process::ctl::Pending;
use crate::realtime::clock::SECOND_NS;

/// How long a robot may take to stand, and activities to pause, before the reload is given up.
const PATIENCE_NS: u64 = 8 * SECOND_NS;

/// Activities that are reconfigured.
pub const RECONFIGURED: [&str; 3] = ["navigation", "motion-tube", "control"];

/// An activity's end: takes a new part and gives the old one back.
pub struct Exchange<T> {
    new: Consumer<Box<T>>,
    old: Producer<Box<T>>,
}

impl<T> Exchange<T> {
    /// The new part, if there is one.
    pub fn take(&mut self) -> Option<Box<T>> {
        self.new.pop().ok()
    }

    /// Gives the old part back. There is room: parts are handed out one at a time.
    pub fn give_back(&mut self, old: Box<T>) {
        if let Err(rtrb::PushError::Full(old)) = self.old.push(old) {
            // Never released on this thread.
            std::mem::forget(old);
        }
    }
}

/// The supervisor's end.
struct Hand<T> {
    new: Producer<Box<T>>,
    old: Consumer<Box<T>>,
}

impl<T> Hand<T> {
    fn pair() -> (Self, Exchange<T>) {
        let (new, new_end) = RingBuffer::new(1);
        let (old_end, old) = RingBuffer::new(2);
        (
            Self { new, old },
            Exchange {
                new: new_end,
                old: old_end,
            },
        )
    }

    fn hand_over(&mut self, part: Box<T>) {
        // Empty: one reload at a time, and each waits until its part was taken.
        let _ = self.new.push(part);
    }

    /// Whether the part was taken: the old one is back.
    fn taken(&self) -> bool {
        !self.old.is_empty()
    }

    fn release_old(&mut self) {
        while self.old.pop().is_ok() {}
    }
}

/// The activities' ends.
pub struct ReloadEnds {
    /// Of navigation.
    pub navigator: Exchange<navigation::Part>,
    /// Of the motion tube.
    pub tubes: Exchange<MotionTubes>,
    /// Of control.
    pub controller: Exchange<WheelController>,
}

/// What the files were made into.
struct Parts {
    plan: Plan,
    navigator: Box<navigation::Part>,
    tubes: Box<MotionTubes>,
    controller: Box<WheelController>,
    names: MachineNames,
}

impl Parts {
    /// Reads and checks the files and builds everything; the reason why not.
    fn prepare(files: &Files, present: &Plan) -> Result<Self, String> {
        let plan = Plan::load(files).map_err(|failure| match failure {
            Failure::Refused(report) | Failure::Failed(report) => format!("{report:?}"),
        })?;
        if let Some(key) = present.first_fixed_difference(&plan) {
            return Err(format!(
                "`{key}` has changed, which takes a restart; [navigation], [tubes], gains in [control], limits of \
                 speed, steering and acceleration in [drive], and the site can be reloaded"
            ));
        }
        let state = |name: &str| plan.fsm.state(name).is_some();
        if let Some(gone) = present.fsm.states.iter().find(|own| !state(&own.name)) {
            return Err(format!(
                "the robot may be in state `{}`, which the new state machine does not have",
                gone.name
            ));
        }
        let text = |error: crate::composition::plan::PlanError| error.to_string();
        let navigator = plan.navigator().map_err(text)?;
        let start = plan.start(navigator.machine().state());
        let names = MachineNames::of(&navigator);
        Ok(Self {
            navigator: Box::new(navigation::Part::new(Box::new(navigator), start)),
            tubes: Box::new(plan.motion_tubes().map_err(text)?),
            controller: Box::new(plan.wheel_controller().map_err(text)?),
            names,
            plan,
        })
    }
}

/// How far a reload is.
enum Stage {
    /// The files are read and the parts built.
    Preparing(JoinHandle<Result<Parts, String>>),
    /// Navigation pauses, the robot comes to a stand.
    Stopping(Parts),
    /// The others pause as well.
    Pausing(Parts),
    /// All are told to reconfigure.
    Reconfiguring(Parts),
    /// The parts were handed over.
    HandedOver(Plan, MachineNames),
}

/// What the supervisor has to do for a reload.
#[derive(Debug)]
pub enum Step {
    /// Nothing but to hold who is to be held.
    Wait,
    /// Tell [`RECONFIGURED`] to reconfigure.
    Reconfigure,
    /// The files are bad, or somebody was too slow: nothing has changed. Those that reconfigure are to go on.
    GiveUp,
    /// It is done; the machine's names may be others now.
    Done(MachineNames),
}

/// What the supervisor knows.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The robot stands.
    pub standing: bool,
    /// All of [`RECONFIGURED`] are paused, or have not run yet.
    pub paused: bool,
    /// All of [`RECONFIGURED`] are reconfiguring.
    pub reconfiguring: bool,
}

/// A reload that is under way.
struct UnderWay {
    stage: Stage,
    pending: Pending,
    deadline_ns: u64,
}

/// The supervisor's side of reloading.
pub struct Reload {
    files: Files,
    plan: Plan,
    navigator: Hand<navigation::Part>,
    tubes: Hand<MotionTubes>,
    controller: Hand<WheelController>,
    under_way: Option<UnderWay>,
}

impl Reload {
    /// For a robot that runs `plan`, read from `files`.
    #[must_use]
    pub fn new(files: Files, plan: &Plan) -> (Self, ReloadEnds) {
        let (navigator, navigator_end) = Hand::pair();
        let (tubes, tubes_end) = Hand::pair();
        let (controller, controller_end) = Hand::pair();
        let reload = Self {
            files,
            plan: plan.clone(),
            navigator,
            tubes,
            controller,
            under_way: None,
        };
        (
            reload,
            ReloadEnds {
                navigator: navigator_end,
                tubes: tubes_end,
                controller: controller_end,
            },
        )
    }

    /// The plan that runs.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Begins to read and check the files and to build new parts. `pending` is answered when it is over.
    pub fn begin(&mut self, pending: Pending, now_ns: u64) {
        if self.in_progress() {
            pending.answer(&Err("another reload is under way".into()));
            return;
        }
        let (files, plan) = (self.files.clone(), self.plan.clone());
        let thread = std::thread::Builder::new()
            .name("reload".into())
            .spawn(move || Parts::prepare(&files, &plan));
        match thread {
            Ok(thread) => {
                self.under_way = Some(UnderWay {
                    stage: Stage::Preparing(thread),
                    pending,
                    deadline_ns: now_ns + PATIENCE_NS,
                });
            }
            Err(error) => pending.answer(&Err(format!("no thread to read the files: {error}"))),
        }
    }

    /// Whether a reload is under way.
    #[must_use]
    pub fn in_progress(&self) -> bool {
        self.under_way.is_some()
    }

    /// Whether this activity is to pause for it.
    #[must_use]
    pub fn holds(&self, activity: &str) -> bool {
        match self.under_way.as_ref().map(|reload| &reload.stage) {
            None | Some(Stage::Preparing(_)) => false,
            Some(Stage::Stopping(_)) => activity == RECONFIGURED[0],
            Some(_) => RECONFIGURED.contains(&activity),
        }
    }

    /// Goes on with what is under way.
    pub fn step(&mut self, view: View, now_ns: u64) -> Step {
        let Some(UnderWay {
            stage,
            pending,
            deadline_ns,
        }) = self.under_way.take()
        else {
            return Step::Wait;
        };
        let late = now_ns > deadline_ns;
        let (stage, step) = match stage {
            Stage::Preparing(thread) if thread.is_finished() => match thread.join() {
                Ok(Ok(parts)) => {
                    tracing::info!("operator: reload: the files are good; pausing");
                    (Stage::Stopping(parts), Step::Wait)
                }
                Ok(Err(why)) => return give_up(pending, why),
                Err(_) => return give_up(pending, "reading the files failed".into()),
            },
            // The robot drives on meanwhile: no hurry, but somebody waits for the answer.
            Stage::Preparing(_) if late => {
                return give_up(pending, "reading the files takes too long".into());
            }
            Stage::Stopping(parts) if view.standing => (Stage::Pausing(parts), Step::Wait),
            Stage::Pausing(parts) if view.paused => {
                (Stage::Reconfiguring(parts), Step::Reconfigure)
            }
            Stage::Reconfiguring(parts) if view.reconfiguring => {
                self.navigator.hand_over(parts.navigator);
                self.tubes.hand_over(parts.tubes);
                self.controller.hand_over(parts.controller);
                (Stage::HandedOver(parts.plan, parts.names), Step::Wait)
            }
            Stage::Stopping(_) if late => {
                return give_up(pending, "the robot does not come to a stand".into());
            }
            Stage::Pausing(_) | Stage::Reconfiguring(_) if late => {
                return give_up(pending, "not every activity has paused".into());
            }
            Stage::HandedOver(plan, names) if self.taken() => {
                self.navigator.release_old();
                self.tubes.release_old();
                self.controller.release_old();
                self.plan = plan;
                pending.answer(&Ok("reloaded".into()));
                return Step::Done(names);
            }
            other => (other, Step::Wait),
        };
        self.under_way = Some(UnderWay {
            stage,
            pending,
            deadline_ns,
        });
        step
    }

    fn taken(&self) -> bool {
        self.navigator.taken() && self.tubes.taken() && self.controller.taken()
    }
}

fn give_up(pending: Pending, why: String) -> Step {
    tracing::warn!("operator: reload refused, nothing changes: {why}");
    pending.answer(&Err(why));
    Step::GiveUp
}
