//! Keeps the robot's checkpoint while it runs.

use coordination::fsm::Machine;
use skills::navigator::NavigatorCheckpoint;
use skills::odometry::Odometry;
use skills::tubes::FloorCheckpoint;

use crate::composition::checkpoint::Checkpoint;
use crate::composition::plan::Plan;
use crate::fleet::Stood;
use crate::process::checkpoints::{CheckpointStore, Ended, Left, Waited};
use crate::realtime::clock::SECOND_NS;
use crate::symbols::values::{Mode, Whereabouts};
use crate::symbols::wiring::SupervisorSymbols;

/// A note that is not on the disk by then makes people wait.
const NOTED_NS: u64 = SECOND_NS;

/// What the supervisor knows of a robot, besides what its symbols say.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    /// A [`Mode`].
    pub(super) mode: u64,
    /// An operator has paused it.
    pub(super) paused: bool,
    /// Nobody knows where it is, whatever its navigation takes for its pose.
    pub(super) lost: bool,
    /// Faults that wait for an operator, a bit for each number.
    pub(super) stopped_by: u64,
}

impl Known {
    fn waits(&self) -> Waited {
        Waited {
            for_reset: self.stopped_by != 0 || self.mode == Mode::Stopped as u64,
            to_resume: self.paused,
        }
    }
}

/// The newest checkpoint, and where it is kept.
pub struct Keeper {
    store: Box<dyn CheckpointStore>,
    checkpoint: Box<Checkpoint>,
    /// The site's name.
    site: String,
    /// Where the process before has ended as it was asked to,
    ended: Option<Stood>,
    /// or it has not, and this one goes on from its checkpoint.
    goes_on: bool,
    /// What a robot that has not begun waits for by what its next process would find.
    waits: Waited,
    /// It could not be kept the last time.
    fails: bool,
    /// When that the robot is under way was to be noted first.
    since_ns: Option<u64>,
}

impl Keeper {
    /// Keeps checkpoints of a plan's robot. That the robot waits for an operator is kept from the beginning.
    #[must_use]
    pub fn new(store: Box<dyn CheckpointStore>, plan: &Plan, left: &Left) -> Self {
        let mut keeper = Self {
            store,
            checkpoint: Checkpoint::of(plan),
            site: plan.site.value.name.clone(),
            ended: left.ended.clone(),
            goes_on: left.place.is_some(),
            waits: Waited {
                for_reset: left.stopped,
                to_resume: left.paused,
            },
            fails: false,
            since_ns: None,
        };
        // Of one that ended as it was asked to, its note says so.
        if left.stopped && (left.lost || left.place.is_some()) {
            keeper.save_waiting(Known {
                mode: Mode::Stopped as u64,
                paused: left.paused,
                ..Known::default()
            });
        }
        keeper
    }

    /// The robot goes by this plan from now on.
    pub(super) fn is_of(&mut self, plan: &Plan) {
        self.site.clone_from(&plan.site.value.name);
        self.checkpoint.is_of(plan);
    }

    /// That the robot is under way stands where it outlives the computer's being switched off.
    pub(super) fn is_noted(&self) -> bool {
        self.store.is_noted()
    }

    /// That should stand by now, and does not: it cannot be written, or the disk takes too long.
    pub(super) fn is_overdue(&self, now_ns: u64) -> bool {
        let late = |since_ns| now_ns.saturating_sub(since_ns) > NOTED_NS;
        !self.is_noted() && (self.fails || self.since_ns.is_some_and(late))
    }

    /// Keeps where the robot is now, once it knows; before, that it waits for an operator.
    pub(super) fn keep(&mut self, symbols: &mut SupervisorSymbols, known: Known, now_ns: u64) {
        let odometry = symbols.odometry.read();
        let whereabouts = symbols.whereabouts.read();
        let floor = symbols.floor.read();
        if odometry.stamp_ns == 0 || whereabouts.stamp_ns == 0 {
            let waits = known.waits();
            if self.is_noted() || self.waits != waits {
                self.waits = waits;
                self.since_ns.get_or_insert(now_ns);
                self.save_waiting(known);
            }
            return;
        }
        self.write(known, &odometry.value, &whereabouts.value, &floor.value);
        self.checkpoint.written_ns = now_ns;
        self.since_ns.get_or_insert(now_ns);
        self.save();
    }

    /// Keeps of a robot that has not begun what it waits for, and that nobody knows where it is.
    fn save_waiting(&mut self, known: Known) {
        self.know(known);
        if known.waits().for_reset {
            self.checkpoint.mode = Mode::Stopped as u64;
        }
        self.checkpoint.navigator.uncertain = 1;
        self.save();
    }

    fn know(&mut self, known: Known) {
        let checkpoint = &mut *self.checkpoint;
        (checkpoint.mode, checkpoint.stopped_by) = (known.mode, known.stopped_by);
        checkpoint.paused = u64::from(known.paused);
    }

    fn write(
        &mut self,
        known: Known,
        odometry: &Odometry,
        whereabouts: &Whereabouts,
        floor: &FloorCheckpoint,
    ) {
        self.know(known);
        let checkpoint = &mut *self.checkpoint;
        checkpoint.odometry = *odometry;
        checkpoint.navigator = whereabouts.at;
        // What navigation takes for its pose until somebody says where the robot stands, is none.
        checkpoint.navigator.uncertain |= u64::from(known.lost);
        checkpoint.floor = *floor;
    }

    fn save(&mut self) {
        let result = self.store.save(self.checkpoint.to_bytes());
        if let Err(error) = &result
            && !self.fails
        {
            tracing::warn!(
                "the checkpoint cannot be kept, so that after a crash the robot would not know where it is: {error}"
            );
        }
        self.fails = result.is_err();
    }

    /// The robot has ended as it was asked to, and waited for this.
    pub(super) fn arrive(&mut self, waited: Waited, machine: &Machine) {
        let at = &self.checkpoint.navigator;
        let at = match self.checkpoint.written_ns {
            // So early that nobody knows more than before.
            0 if self.goes_on => return,
            0 => self.ended.clone(),
            // Under way is what the note says already: the next one does not know where it is either.
            _ if at.uncertain != 0 => return,
            _ => Some(stood(at, machine)),
        };
        let at = at.map(|at| (self.site.clone(), at));
        // What cannot be taken out is of this process, which is said to have crashed then.
        if let Err(error) = self.store.arrive(Ended { at, waited }) {
            tracing::warn!("the checkpoint cannot be removed: {error}");
        }
    }
}

fn stood(at: &NavigatorCheckpoint, machine: &Machine) -> Stood {
    let state = machine.states().map(|(state, _)| state);
    let state = { state }.find(|state| state.index() as u64 == at.state);
    let std = |axis: usize| at.covariance[axis][axis].max(0.0).sqrt();
    Stood {
        pose: at.pose,
        std_m: std(0).max(std(1)),
        std_rad: std(2),
        state: state.map_or(String::new(), |state| machine.state_name(state).to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::mpsc::{Sender, channel};

    use coordination::fsm::StateId;
    use description::geometry::Pose2;

    use super::*;
    use crate::composition::files::Files;

    fn plan() -> Plan {
        let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");
        let plan = Plan::load(&Files {
            robot: format!("{config}/robots/amr-1.toml").into(),
            site: format!("{config}/sites/overtaking.toml").into(),
            set: Vec::new(),
        });
        plan.expect("good files")
    }

    /// Tells how a robot has ended.
    struct Told(Sender<Ended>);

    impl CheckpointStore for Told {
        fn save(&mut self, _bytes: &[u8]) -> io::Result<()> {
            Ok(())
        }

        fn arrive(&mut self, ended: Ended) -> io::Result<()> {
            self.0.send(ended).map_err(io::Error::other)
        }

        fn is_noted(&self) -> bool {
            true
        }
    }

    /// Whoever is not sure is not where it believes to be.
    #[test]
    fn one_that_is_sure_of_its_pose_says_where_it_has_ended_and_another_leaves_the_note() {
        let plan = plan();
        let navigator = plan.navigator().expect("one");
        for uncertain in [0, 1] {
            let (told, says) = channel();
            let mut keeper = Keeper::new(Box::new(Told(told)), &plan, &Left::default());
            keeper.checkpoint.written_ns = 1;
            keeper.checkpoint.navigator.pose = Pose2::new(1.0, 2.0, 0.5);
            keeper.checkpoint.navigator.covariance[1][1] = 0.04;
            keeper.checkpoint.navigator.uncertain = uncertain;
            keeper.arrive(Waited::default(), navigator.machine());
            let at = says.try_recv().ok().and_then(|ended| ended.at);
            let state = navigator.machine().state_name(StateId(0)).to_owned();
            let stood = Stood {
                pose: Pose2::new(1.0, 2.0, 0.5),
                std_m: 0.2,
                std_rad: 0.0,
                state,
            };
            let expected = ("overtaking".to_owned(), stood);
            assert_eq!(at, (uncertain == 0).then_some(expected));
        }
    }

    /// Takes all, and never gets it to the disk.
    struct Hangs;

    impl CheckpointStore for Hangs {
        fn save(&mut self, _bytes: &[u8]) -> io::Result<()> {
            Ok(())
        }

        fn arrive(&mut self, _ended: Ended) -> io::Result<()> {
            Ok(())
        }

        fn is_noted(&self) -> bool {
            false
        }
    }

    #[test]
    fn a_disk_that_takes_too_long_is_told_as_one_that_fails() {
        let mut keeper = Keeper::new(Box::new(Hangs), &plan(), &Left::default());
        assert!(
            !keeper.is_overdue(60 * SECOND_NS),
            "there was nothing to note"
        );
        keeper.since_ns = Some(60 * SECOND_NS);
        assert!(!keeper.is_overdue(61 * SECOND_NS));
        assert!(keeper.is_overdue(61 * SECOND_NS + 1));
    }

    /// Asked to end before any symbol was written: a restart that comes twice.
    #[test]
    fn one_that_ends_at_once_knows_what_the_one_before_knew() {
        let plan = plan();
        let at = Some(Stood {
            pose: Pose2::new(1.0, 2.0, 0.5),
            ..Stood::default()
        });
        let ended = Left {
            ended: at.clone(),
            ..Left::default()
        };
        let goes_on = Left {
            place: Some(Checkpoint::of(&plan)),
            ..Left::default()
        };
        let waited = Waited {
            for_reset: true,
            to_resume: true,
        };
        let navigator = plan.navigator().expect("one");
        let site = plan.site.value.name.clone();
        let at = Some(site).zip(at);
        for (left, expected) in [(ended, Some(Ended { at, waited })), (goes_on, None)] {
            let (told, says) = channel();
            Keeper::new(Box::new(Told(told)), &plan, &left).arrive(waited, navigator.machine());
            assert_eq!(says.try_recv().ok(), expected);
        }
    }
}
