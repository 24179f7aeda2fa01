//! Where checkpoints are kept: a file beside the robot's control socket, in memory on most machines. And a note beside it, on
//! disk: that the robot is under way, or where it has ended. A machine that is switched off while its robot drives leaves the
//! note, and no checkpoint.

mod background;
mod journey;

use std::fmt::Display;
use std::fs;
use std::io::{self, Read};
use std::path::PathBuf;

use contract::private;
use description::geometry::Pose2;

use crate::composition::checkpoint::Checkpoint;
use crate::composition::failure::Failure;
use crate::composition::plan::Plan;
use crate::fleet::Began;
use crate::process::runtime::Runtime;
use crate::realtime::log::LogSender;

pub use background::Background;
pub use journey::Journey;

/// Tells the starts of a machine apart.
const BOOT_ID: &str = "/proc/sys/kernel/random/boot_id";

/// Keeps the newest checkpoint of one robot.
pub trait CheckpointStore: Send {
    /// Keeps this one instead of the last: the robot is under way.
    ///
    /// # Errors
    /// The operating system's.
    fn save(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// The robot has ended as it was asked to, and the last checkpoint goes; where it ended stays, if the next process is to know.
    ///
    /// # Errors
    /// The operating system's.
    fn arrive(&mut self, at: Option<Pose2>) -> io::Result<()>;
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
        // There as a whole or not at all: the process may be killed at any moment.
        private::write_unsynced(&self.path, &[self.boot_id.as_bytes(), bytes].concat())?;
        if !self.noted {
            Journey::UnderWay.note(&self.note)?;
            self.noted = true;
        }
        Ok(())
    }

    fn arrive(&mut self, at: Option<Pose2>) -> io::Result<()> {
        at.map_or(Journey::None, Journey::Ended).note(&self.note)?;
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
    pub ended: Option<Pose2>,
}

impl Left {
    /// Where the next process begins, if it cannot use the checkpoint.
    #[must_use]
    pub fn began(&self) -> Began {
        if self.lost || self.place.is_some() {
            Began::Lost
        } else {
            Began::Afresh { ended: self.ended }
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
                Journey::None => None,
                Journey::Ended(at) => Some(at),
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
            return Ok(Self {
                ended,
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
            log.warn("the robot was stopped when the process before ended: it stays stopped until `onboard ctl reset`".to_owned());
        }
        let place = match checkpoint.check(plan, now_ns) {
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

#[cfg(test)]
mod tests {
    use description::geometry::Pose2;

    use super::*;
    use crate::composition::files::Files;
    use crate::realtime::clock::SECOND_NS;
    use crate::realtime::log;
    use crate::symbols::values::Mode;

    fn plan(set: &[&str]) -> Plan {
        let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");
        let files = Files {
            robot: format!("{config}/robots/amr-1.toml").into(),
            site: format!("{config}/sites/corridor.toml").into(),
            set: set.iter().map(|&one| one.to_owned()).collect(),
        };
        Plan::load(&files).expect("good files")
    }

    /// A folder, and the file of a robot in it.
    fn file() -> (tempfile::TempDir, CheckpointFile) {
        let folder = crate::process::runtime::temporary();
        let runtime = Runtime::new(Some(folder.path().to_owned()));
        let file = CheckpointFile::of(&runtime.unwrap_or_else(|_| unreachable!()), "amr-1");
        (folder, file.unwrap_or_else(|_| unreachable!()))
    }

    fn checkpoint(plan: &Plan, mode: Mode) -> Box<Checkpoint> {
        let mut checkpoint = Checkpoint::of(plan);
        checkpoint.written_ns = 100 * SECOND_NS;
        checkpoint.mode = mode as u64;
        checkpoint.navigator.pose = Pose2::new(1.0, 2.0, 0.5);
        checkpoint
    }

    fn left(file: &mut CheckpointFile, plan: &Plan, now_s: u64) -> Left {
        let (log, _drain) = log::queue();
        Left::take(file, plan, &log, now_s * SECOND_NS).expect("readable")
    }

    #[test]
    fn the_newest_one_is_taken_out_once() {
        let (folder, mut file) = file();
        let plan = plan(&[]);
        assert!(left(&mut file, &plan, 101).place.is_none(), "there is none");
        for x_m in [1.0, 7.0] {
            let mut one = checkpoint(&plan, Mode::Running);
            one.navigator.pose.x_m = x_m;
            file.save(one.to_bytes()).expect("kept");
        }
        let first = left(&mut file, &plan, 101);
        assert_eq!(first.place.map(|one| one.navigator.pose.x_m), Some(7.0));
        assert!(!first.stopped && !first.paused && !first.lost);
        // The note stays: a process that ends before it has left a checkpoint knows no place.
        let names = fs::read_dir(folder.path()).expect("there");
        let names: Vec<_> = names
            .map(|entry| entry.expect("readable").file_name())
            .collect();
        assert_eq!(names, ["amr-1.journey"]);
        let left = left(&mut file, &plan, 101);
        assert!(left.lost && left.stopped);
    }

    #[test]
    fn a_robot_that_ended_as_asked_is_where_it_ended_and_not_stopped() {
        let (folder, mut file) = file();
        let plan = plan(&[]);
        file.save(checkpoint(&plan, Mode::Running).to_bytes())
            .expect("kept");
        let at = Pose2::new(1.0, 2.0, 0.5);
        file.arrive(Some(at)).expect("noted");
        let left_once = left(&mut file, &plan, 101);
        assert_eq!(left_once.began(), Began::Afresh { ended: Some(at) });
        assert!(!left_once.lost && !left_once.stopped && left_once.place.is_none());
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 1);
        // Under way again, and the machine is switched off.
        file.save(checkpoint(&plan, Mode::Running).to_bytes())
            .expect("kept");
        fs::remove_file(&file.path).expect("there");
        assert_eq!(left(&mut file, &plan, 101).began(), Began::Lost);
    }

    #[test]
    fn where_the_robot_did_not_know_where_it_was_nobody_knows() {
        let (_folder, mut file) = file();
        let plan = plan(&[]);
        let mut unsure = checkpoint(&plan, Mode::Stopped);
        unsure.navigator.uncertain = 1;
        file.save(unsure.to_bytes()).expect("kept");
        let left = left(&mut file, &plan, 101);
        assert!(left.lost && left.stopped && left.place.is_none());
    }

    #[test]
    fn what_is_old_or_of_other_files_is_no_place_but_stays_stopped() {
        let (_folder, mut file) = file();
        let own = plan(&[]);
        let other = plan(&["tubes.floor_memory_m=4.0"]);
        for (plan, now_s, good) in [(&own, 159, true), (&own, 161, false), (&own, 99, false)]
            .into_iter()
            .chain([(&other, 101, false)])
        {
            file.save(checkpoint(&own, Mode::Stopped).to_bytes())
                .expect("kept");
            let left = left(&mut file, plan, now_s);
            assert_eq!((left.place.is_some(), left.stopped), (good, true));
            assert_eq!(left.lost, !good, "nobody else knows where it is");
        }
        file.save(checkpoint(&own, Mode::Paused).to_bytes())
            .expect("kept");
        assert!(left(&mut file, &own, 101).paused);
    }

    #[test]
    fn what_is_damaged_keeps_it_stopped_and_what_is_from_before_the_machine_started_is_none() {
        let (_folder, mut file) = file();
        let plan = plan(&[]);
        let good = checkpoint(&plan, Mode::Stopped).to_bytes().to_vec();
        for place in [0, 9, 40, good.len() - 1] {
            let mut bad = good.clone();
            bad[place] ^= 1;
            file.save(&bad).expect("kept");
            let left = left(&mut file, &plan, 101);
            assert!(left.place.is_none() && left.stopped, "byte {place}");
        }
        file.save(&good[..good.len() - 8]).expect("kept");
        assert!(left(&mut file, &plan, 101).stopped);
        file.boot_id = "another start of the machine".into();
        file.save(&good).expect("kept");
        file.boot_id = "this one".into();
        let none = left(&mut file, &plan, 101);
        assert!(none.place.is_none() && none.stopped && none.lost);
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        let (_folder, mut file) = file();
        fs::create_dir(&file.path).expect("made");
        let (log, _drain) = log::queue();
        let refused = Left::take(&mut file, &plan(&[]), &log, 0).expect_err("a folder");
        assert!(format!("{refused:?}").contains("amr-1"), "{refused:?}");
    }

    #[test]
    fn a_robot_that_was_stopped_stays_so_from_the_beginning() {
        use crate::process::supervisor::Keeper;
        let (_folder, mut file) = file();
        let plan = plan(&[]);
        file.save(checkpoint(&plan, Mode::Stopped).to_bytes())
            .expect("kept");
        let left_once = left(&mut file, &plan, 101);
        let again = CheckpointFile {
            path: file.path.clone(),
            boot_id: file.boot_id.clone(),
            note: file.note.clone(),
            noted: false,
        };
        // The process ends before it knows where the robot is.
        drop(Keeper::new(Box::new(again), &plan, &left_once));
        assert!(left(&mut file, &plan, 102).stopped);
    }
}
