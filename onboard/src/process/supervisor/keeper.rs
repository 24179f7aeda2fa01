//! Keeps the robot's checkpoint while it runs.

use skills::odometry::Odometry;
use skills::tubes::FloorCheckpoint;

use crate::composition::checkpoint::Checkpoint;
use crate::composition::plan::Plan;
use crate::process::checkpoints::{CheckpointStore, Left};
use crate::symbols::values::{Mode, Whereabouts};
use crate::symbols::wiring::SupervisorSymbols;

/// The newest checkpoint, and where it is kept.
pub struct Keeper {
    store: Box<dyn CheckpointStore>,
    checkpoint: Box<Checkpoint>,
    /// A mediator manages the areas, and remembers where the robot was.
    managed: bool,
    /// It could not be kept the last time.
    fails: bool,
}

impl Keeper {
    /// Keeps checkpoints of a plan's robot. That the robot waits for an operator is kept from the beginning.
    #[must_use]
    pub fn new(store: Box<dyn CheckpointStore>, plan: &Plan, left: &Left) -> Self {
        let mut keeper = Self {
            store,
            checkpoint: Checkpoint::of(plan),
            managed: plan.site.value.areas_managed,
            fails: false,
        };
        if left.stopped {
            keeper.checkpoint.mode = Mode::Stopped as u64;
            keeper.checkpoint.navigator.uncertain = 1;
            keeper.save();
        }
        keeper
    }

    /// Keeps where the robot is now, once it knows.
    pub(super) fn keep(&mut self, symbols: &mut SupervisorSymbols, mode: u64, now_ns: u64) {
        let odometry = symbols.odometry.read();
        let whereabouts = symbols.whereabouts.read();
        let floor = symbols.floor.read();
        if odometry.stamp_ns == 0 || whereabouts.stamp_ns == 0 {
            return;
        }
        self.write(mode, &odometry.value, &whereabouts.value, &floor.value);
        self.checkpoint.written_ns = now_ns;
        self.save();
    }

    fn write(
        &mut self,
        mode: u64,
        odometry: &Odometry,
        whereabouts: &Whereabouts,
        floor: &FloorCheckpoint,
    ) {
        let checkpoint = &mut *self.checkpoint;
        checkpoint.mode = mode;
        checkpoint.odometry = *odometry;
        checkpoint.navigator = whereabouts.at;
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

    /// The robot has ended as it was asked to.
    pub(super) fn arrive(&mut self) {
        let at = &self.checkpoint.navigator;
        let knows = self.managed && self.checkpoint.written_ns != 0 && at.uncertain == 0;
        // What cannot be taken out is of this process, which is said to have crashed then.
        if let Err(error) = self.store.arrive(knows.then_some(at.pose)) {
            tracing::warn!("the checkpoint cannot be removed: {error}");
        }
    }
}
