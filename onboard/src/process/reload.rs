//! `onboard ctl reload`: new gains, limits, tubes and map for a running robot, all or nothing.
//!
//! The files are read, checked and made into new parts on a thread of their own, while the robot drives on. Only then is
//! it paused: navigation first; once it stands, motion tube and control as well. When all three are paused they are told
//! to reconfigure, and only when all three *are* reconfiguring, the parts are handed over: from there on nothing can fail.
//! Whatever goes wrong before changes nothing, and is told.
//!
//! The activities swap the parts and hand the old ones back, so that no real-time thread allocates or releases anything.

use std::thread::JoinHandle;

use coordination::fsm::Machine;
use description::threads::ActivityKind;

use super::ctl::{Done, Pending, Refusal};
use crate::composition::files::Files;
use crate::composition::plan::Plan;
use crate::composition::replacement::{ReloadEnds, ReloadHands, Replacement};
use crate::realtime::clock::SECOND_NS;
use crate::realtime::memory::populate_new_memory;

/// How long a robot may take to stand, and activities to pause, before the reload is given up.
const PATIENCE_NS: u64 = 8 * SECOND_NS;

/// Activities that are reconfigured.
pub const RECONFIGURED: [ActivityKind; 3] = [
    ActivityKind::Navigation,
    ActivityKind::MotionTube,
    ActivityKind::Control,
];

/// How far a reload is.
enum Stage {
    /// The files are read and the parts built.
    Preparing(JoinHandle<Result<Replacement, String>>),
    /// Navigation pauses, the robot comes to a stand.
    Stopping(Replacement),
    /// The others pause as well.
    Pausing(Replacement),
    /// All are told to reconfigure.
    Reconfiguring(Replacement),
    /// The parts were handed over.
    HandedOver(Plan, Machine),
}

/// What the supervisor has to do for a reload.
#[derive(Debug)]
pub enum Step {
    /// Nothing, but those that [`Reload::holds`] names stay paused.
    Wait,
    /// Tell [`RECONFIGURED`] to reconfigure.
    Reconfigure,
    /// The files are bad, or somebody was too slow: nothing has changed. Those that reconfigure are to go on.
    GiveUp,
    /// It is done; this machine runs now.
    Done(Machine),
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
    hands: ReloadHands,
    under_way: Option<UnderWay>,
    /// Whoever steps this waits for the thread that reads the files.
    waits: bool,
}

impl Reload {
    /// For a robot that runs `plan`, read from `files`.
    #[must_use]
    pub fn new(files: Files, plan: &Plan) -> (Self, ReloadEnds) {
        let (hands, ends) = ReloadHands::pair();
        let reload = Self {
            files,
            plan: plan.clone(),
            hands,
            under_way: None,
            waits: false,
        };
        (reload, ends)
    }

    /// Whoever steps this waits until the files are read: on a simulated clock that takes no time.
    #[must_use]
    pub fn waiting(self) -> Self {
        Self {
            waits: true,
            ..self
        }
    }

    /// From now on these are the files.
    pub(super) fn read_from(&mut self, files: Files) {
        self.files = files;
    }

    /// The plan that runs.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Begins to read and check the files and to build new parts. `pending` is answered when it is over.
    pub fn begin(&mut self, pending: Pending, now_ns: u64) {
        if self.in_progress() {
            pending.answer(&Err(Refusal::AnotherReload));
            return;
        }
        let (files, plan) = (self.files.clone(), self.plan.clone());
        let thread = std::thread::Builder::new()
            .name("reload".into())
            .spawn(move || {
                let made = Replacement::prepare(&files, &plan);
                populate_new_memory();
                made
            });
        match thread {
            Ok(thread) => {
                self.under_way = Some(UnderWay {
                    stage: Stage::Preparing(thread),
                    pending,
                    deadline_ns: now_ns + PATIENCE_NS,
                });
            }
            Err(error) => {
                let why = format!("no thread could be started to read the files: {error}");
                pending.answer(&Err(Refusal::Files(why)));
            }
        }
    }

    /// Whether a reload is under way.
    #[must_use]
    pub fn in_progress(&self) -> bool {
        self.under_way.is_some()
    }

    /// Whether this activity is to pause for it.
    #[must_use]
    pub fn holds(&self, activity: ActivityKind) -> bool {
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
            Stage::Preparing(thread) if self.waits || thread.is_finished() => match thread.join() {
                Ok(Ok(parts)) => {
                    tracing::info!("operator: reload: the files are good; pausing");
                    (Stage::Stopping(parts), Step::Wait)
                }
                Ok(Err(why)) => return give_up(pending, Refusal::Files(why)),
                Err(_) => {
                    let why = "reading the files failed; see the robot's log".to_owned();
                    return give_up(pending, Refusal::Files(why));
                }
            },
            // The robot drives on meanwhile: no hurry, but somebody waits for the answer.
            Stage::Preparing(_) if late => {
                return give_up(
                    pending,
                    Refusal::ReloadTooSlow("reading the files takes too long"),
                );
            }
            Stage::Stopping(parts) if view.standing => (Stage::Pausing(parts), Step::Wait),
            Stage::Pausing(parts) if view.paused => {
                (Stage::Reconfiguring(parts), Step::Reconfigure)
            }
            Stage::Reconfiguring(parts) if view.reconfiguring => {
                let (plan, machine) = self.hands.hand_over(parts);
                (Stage::HandedOver(plan, machine), Step::Wait)
            }
            Stage::Stopping(_) if late => {
                return give_up(
                    pending,
                    Refusal::ReloadTooSlow("the robot does not come to a stand"),
                );
            }
            Stage::Pausing(_) | Stage::Reconfiguring(_) if late => {
                return give_up(
                    pending,
                    Refusal::ReloadTooSlow("not every activity has paused"),
                );
            }
            Stage::HandedOver(plan, machine) if self.hands.taken() => {
                self.hands.release_old();
                self.plan = plan;
                pending.answer(&Ok(Done::Reloaded));
                return Step::Done(machine);
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
}

fn give_up(pending: Pending, why: Refusal) -> Step {
    tracing::warn!("operator: reload refused, nothing changes: {why}");
    pending.answer(&Err(why));
    Step::GiveUp
}
