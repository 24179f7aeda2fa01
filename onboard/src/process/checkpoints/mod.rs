//! Where checkpoints are kept: a file beside the robot's control socket, in memory on most machines. And a note beside it, on
//! disk: that the robot is under way, or where it has ended. A machine that is switched off while its robot drives leaves the
//! note, and no checkpoint.

mod background;
mod journey;
#[cfg(test)]
mod tests;

use std::fmt::Display;
use std::fs;
use std::io::{self, Read};
use std::path::PathBuf;

use contract::private;
use skills::navigator::Navigator;

use crate::composition::checkpoint::{Checkpoint, Unusable};
use crate::composition::failure::Failure;
use crate::composition::plan::Plan;
use crate::fleet::{Began, Stood};
use crate::process::runtime::Runtime;
use crate::realtime::log::LogSender;
use crate::symbols::faults::Fault;

pub use background::{Background, UNATTENDED};
pub use journey::{Ended, Journey, Waited};

const STAYS_STOPPED: &str = "the robot was stopped when the process before ended: it stays stopped until `onboard ctl reset`";

/// Tells the starts of a machine apart.
const BOOT_ID: &str = "/proc/sys/kernel/random/boot_id";

/// Keeps the newest checkpoint of one robot.
pub trait CheckpointStore: Send {
    /// Keeps this one instead of the last: the robot is under way.
    ///
    /// # Errors
    /// The operating system's.
    fn save(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// The robot has ended as it was asked to, and the last checkpoint goes; how it ended stays.
    ///
    /// # Errors
    /// The operating system's.
    fn arrive(&mut self, ended: Ended) -> io::Result<()>;

    /// That the robot is under way is noted on disk: a computer that is switched off now knows of it when it starts.
    fn is_noted(&self) -> bool;
}

/// What the process before has left.
pub trait Inheritance: CheckpointStore {
    /// Where its journey is.
    ///
    /// # Errors
    /// The operating system's, or what is wrong with the note.
    fn journey(&mut self) -> io::Result<Journey>;

    /// Takes out the last one. The next process finds none: one that makes a process fail does so once.
    ///
    /// # Errors
    /// The operating system's.
    fn take(&mut self) -> io::Result<Option<Vec<u8>>>;
}

/// A file in the runtime folder. It counts only until the machine starts again, as the clock of its times does.
#[derive(Debug)]
pub struct CheckpointFile {
    path: PathBuf,
    boot_id: String,
    note: PathBuf,
    /// The note says that the robot is under way.
    noted: bool,
}

impl CheckpointFile {
    /// The file of a robot.
    ///
    /// # Errors
    /// [`Failure::Refused`] when the folder on disk cannot be used.
    pub fn of(runtime: &Runtime, robot_id: &str) -> Result<Self, Failure> {
        Ok(Self {
            path: runtime.folder().join(format!("{robot_id}.checkpoint")),
            boot_id: fs::read_to_string(BOOT_ID).unwrap_or_default(),
            note: runtime.lasting()?.join(format!("{robot_id}.journey")),
            noted: false,
        })
    }
}

impl CheckpointStore for CheckpointFile {
    fn save(&mut self, bytes: &[u8]) -> io::Result<()> {
        // First, since without it a checkpoint that cannot be kept looks like a robot that has not begun.
        if !self.noted {
            Journey::UnderWay.note(&self.note)?;
            self.noted = true;
        }
        // There as a whole or not at all: the process may be killed at any moment.
        let written =
            private::write_unsynced(&self.path, &[self.boot_id.as_bytes(), bytes].concat());
        if written.is_err() {
            // The last one is not where the robot is any more. What has no room to be written has room to go.
            journey::remove(&self.path)?;
        }
        Ok(written?)
    }

    fn is_noted(&self) -> bool {
        self.noted
    }

    fn arrive(&mut self, ended: Ended) -> io::Result<()> {
        Journey::from(ended).note(&self.note)?;
        self.noted = false;
        journey::remove(&self.path)
    }
}

impl Inheritance for CheckpointFile {
    fn journey(&mut self) -> io::Result<Journey> {
        Journey::noted(&self.note)
    }

    fn take(&mut self) -> io::Result<Option<Vec<u8>>> {
        let named = |error: io::Error| {
            io::Error::new(error.kind(), format!("{}: {error}", self.path.display()))
        };
        let mut bytes = Vec::new();
        match private::open(&self.path) {
            Err(error) if error.is_missing() => return Ok(None),
            file => file?.read_to_end(&mut bytes).map_err(named)?,
        };
        fs::remove_file(&self.path).map_err(named)?;
        let own = bytes.strip_prefix(self.boot_id.as_bytes());
        Ok(own.map(<[u8]>::to_vec))
    }
}

/// Where a robot stands by such a note. On another site it begins at its start.
fn stood(at: Option<(String, Stood)>, plan: &Plan) -> Option<Stood> {
    at.filter(|(name, _)| *name == plan.site.value.name)
        .map(|(_, stood)| stood)
}

/// Whether nobody will say in which state a robot that ended there goes on; a mediator may know.
fn lacks_state(stood: &Stood, plan: &Plan) -> bool {
    let is_known = |own: Navigator| own.machine().state_id(&stood.state).is_some();
    !plan.site.value.areas_managed && !plan.navigator().is_ok_and(is_known)
}

/// What the process before has left.
#[derive(Debug, Default)]
pub struct Left {
    /// Where to go on.
    pub place: Option<Box<Checkpoint>>,
    /// The robot waits for an operator.
    pub stopped: bool,
    /// An operator had paused it.
    pub paused: bool,
    /// It ended somewhere, and nobody knows where.
    pub lost: bool,
    /// It ended here, as it was asked to.
    pub ended: Option<Stood>,
}

impl Left {
    /// Where the next process begins, if it cannot use the checkpoint.
    #[must_use]
    pub fn began(&self) -> Began {
        if self.lost || self.place.is_some() {
            Began::Lost
        } else {
            Began::Afresh {
                ended: self.ended.clone(),
            }
        }
    }

    /// Takes what the process before has left, and says in the log what becomes of it.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it is there and cannot be read: nobody knows whether the robot was stopped.
    pub fn take(
        store: &mut dyn Inheritance,
        plan: &Plan,
        log: &LogSender,
        now_ns: u64,
    ) -> Result<Self, Failure> {
        let cannot = |error: io::Error| {
            Failure::refused(format_args!(
                "the checkpoint of {} cannot be read: {error}",
                plan.robot.identity.id
            ))
        };
        let journey = store.journey().map_err(cannot)?;
        let before = "the process before ended without being asked to";
        let Some(bytes) = store.take().map_err(cannot)? else {
            let ended = match journey {
                Journey::None => Ended::default(),
                Journey::Ended(ended) => ended,
                // Power that comes back starts no robot: where it is, and whether it was stopped, people say.
                Journey::UnderWay => {
                    log.warn(format!(
                        "{before} and left no checkpoint, as when its computer is switched off: say where the robot stands with `onboard ctl place X,Y,THETA --state STATE`, then `onboard ctl reset`"
                    ));
                    return Ok(Self {
                        stopped: true,
                        lost: true,
                        ..Self::default()
                    });
                }
            };
            let stopped = ended.waited.for_reset;
            if stopped {
                log.warn(STAYS_STOPPED.to_owned());
            }
            let at = stood(ended.at, plan);
            let lost = at.as_ref().is_some_and(|at| lacks_state(at, plan));
            if lost {
                log.warn(
                    "nobody knows in which state the robot ended: say where it stands with `onboard ctl place X,Y,THETA --state STATE`".to_owned(),
                );
            }
            return Ok(Self {
                stopped,
                lost,
                paused: ended.waited.to_resume,
                ended: at,
                ..Self::default()
            });
        };
        let unused = |why: &dyn Display| {
            log.warn(format!("{before}, and its checkpoint is not used: {why}"));
        };
        let checkpoint = match Checkpoint::from_bytes(&bytes) {
            Ok(checkpoint) => checkpoint,
            Err(why) => {
                unused(&format_args!(
                    "{why}; nobody knows whether the robot was stopped, so it stays stopped until `onboard ctl reset`"
                ));
                return Ok(Self {
                    stopped: true,
                    lost: true,
                    ..Self::default()
                });
            }
        };
        let (stopped, paused) = (checkpoint.was_stopped(), checkpoint.was_paused());
        if stopped {
            let by: Vec<&str> = checkpoint.stopped_by().map(Fault::name).collect();
            let by = match &by[..] {
                [] => String::new(),
                names => format!(", by {}", names.join(", ")),
            };
            log.warn(format!("{STAYS_STOPPED}{by}"));
        }
        // What navigation would refuse is no place either.
        let goes_on = |checkpoint: &Checkpoint| {
            let navigator = plan.navigator().ok();
            navigator.is_some_and(|mut own| own.resume(&checkpoint.navigator))
        };
        let usable = { checkpoint.check(plan, now_ns) }.and_then(|()| {
            let refused = Unusable::Lost;
            goes_on(&checkpoint).then_some(()).ok_or(refused)
        });
        let place = match usable {
            Ok(()) => {
                let pose = checkpoint.navigator.pose;
                log.warn(format!(
                    "{before}: going on from ({:.2} m, {:.2} m, {:.2} rad)",
                    pose.x_m, pose.y_m, pose.theta_rad
                ));
                Some(checkpoint)
            }
            Err(why) => {
                unused(&why);
                None
            }
        };
        Ok(Self {
            lost: place.is_none(),
            place,
            stopped,
            paused,
            ended: None,
        })
    }
}
