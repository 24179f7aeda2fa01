//! What a robot's process leaves in case it ends without being asked to: where the robot is, what it does there, and the
//! floor around it. The next process goes on from there, as long as the drive has counted the wheels' turns meanwhile.
//!
//! It is of one program, robot file and site file: another one does not know where it is. Whether people had stopped the robot is heeded
//! whatever else has changed; if that cannot be told, it counts as stopped.

use std::hash::{DefaultHasher, Hash, Hasher};

use skills::navigator::NavigatorCheckpoint;
use skills::odometry::Odometry;
use skills::tubes::FloorCheckpoint;

use crate::composition::plan::Plan;
use crate::realtime::clock::SECOND_NS;
use crate::symbols::faults::{FAULTS, Fault};
use crate::symbols::values::Mode;

/// Older, the floor around the robot may have changed.
const KEPT_NS: u64 = 60 * SECOND_NS;
// A bit for each.
const _: () = assert!(FAULTS <= 64);
/// What the bytes begin with.
const MARK: [u8; 8] = *b"onboard1";

/// Where a robot is, what it does there, and the floor around it.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Checkpoint {
    mark: [u8; 8],
    /// Of all bytes that follow.
    checksum: u64,
    /// Of program, robot file and site file.
    fingerprint: u64,
    /// When it was written, monotonic.
    pub written_ns: u64,
    /// A [`Mode`].
    pub mode: u64,
    /// An operator has paused the robot, whatever else stops it.
    pub paused: u64,
    /// Faults that waited for an operator, a bit for each number.
    pub stopped_by: u64,
    /// Dead reckoning, with the encoders' angles.
    pub odometry: Odometry,
    /// Pose in `map`, state, and how far its path is driven.
    pub navigator: NavigatorCheckpoint,
    /// The floor around it.
    pub floor: FloorCheckpoint,
}

/// Why bytes are no checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// Another number of bytes, or another beginning.
    #[error("it is not one of this program")]
    Foreign,
    /// The checksum is wrong.
    #[error("it is damaged")]
    Damaged,
}

/// Why a robot does not go on from a checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unusable {
    /// Program, robot file or site file are others.
    #[error("the program, the robot file or the site file has changed since")]
    OtherPlan,
    /// The floor around the robot may have changed since.
    #[error("it is {age_s:.0} s old, expected at most {} s", KEPT_NS / SECOND_NS)]
    Old {
        /// How old it is.
        age_s: f64,
    },
    /// It is from later than now.
    #[error("it is of another clock")]
    OtherClock,
    /// The pose was uncertain, or is none.
    #[error("the robot did not know where it was")]
    Lost,
}

impl Checkpoint {
    /// An empty one for a plan.
    #[must_use]
    pub fn of(plan: &Plan) -> Box<Self> {
        let mut checkpoint = Box::<Self>::new(bytemuck::Zeroable::zeroed());
        checkpoint.mark = MARK;
        checkpoint.is_of(plan);
        checkpoint
    }

    /// It is of a robot that goes by this plan.
    pub fn is_of(&mut self, plan: &Plan) {
        self.fingerprint = fingerprint(plan);
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`CheckpointError`]: the bytes are none.
    pub fn from_bytes(bytes: &[u8]) -> Result<Box<Self>, CheckpointError> {
        let mut checkpoint = Box::<Self>::new(bytemuck::Zeroable::zeroed());
        let whole = bytemuck::bytes_of_mut(&mut *checkpoint);
        if bytes.len() != whole.len() {
            return Err(CheckpointError::Foreign);
        }
        whole.copy_from_slice(bytes);
        if checkpoint.mark != MARK {
            return Err(CheckpointError::Foreign);
        }
        if checkpoint.checksum != checkpoint.sum() {
            return Err(CheckpointError::Damaged);
        }
        Ok(checkpoint)
    }

    /// Its bytes, to be kept.
    pub fn to_bytes(&mut self) -> &[u8] {
        self.checksum = self.sum();
        bytemuck::bytes_of(self)
    }

    /// What becomes of one that no other followed in time: the process that comes next waits for an operator, as after a fault of which
    /// its supervisor could not hear. Nothing, if it is none.
    #[must_use]
    pub fn unattended(bytes: &[u8]) -> Option<Vec<u8>> {
        let mut own = Self::from_bytes(bytes).ok()?;
        own.mode = Mode::Stopped as u64;
        own.stopped_by |= 1 << Fault::SupervisorSilent as u64;
        Some(own.to_bytes().to_vec())
    }

    /// Whether a robot of this plan may go on from it.
    ///
    /// # Errors
    /// [`Unusable`]: why not.
    pub fn check(&self, plan: &Plan, now_ns: u64) -> Result<(), Unusable> {
        if self.fingerprint != fingerprint(plan) {
            return Err(Unusable::OtherPlan);
        }
        let Some(age_ns) = now_ns.checked_sub(self.written_ns) else {
            return Err(Unusable::OtherClock);
        };
        if age_ns > KEPT_NS {
            let age_s = age_ns as f64 / SECOND_NS as f64;
            return Err(Unusable::Old { age_s });
        }
        if self.navigator.uncertain != 0 {
            return Err(Unusable::Lost);
        }
        Ok(())
    }

    /// People, or a fault that waits for them, had stopped the robot.
    #[must_use]
    pub fn was_stopped(&self) -> bool {
        self.mode == Mode::Stopped as u64
    }

    /// By which faults, then.
    pub fn stopped_by(&self) -> impl Iterator<Item = Fault> + '_ {
        { Fault::ALL.into_iter() }.filter(|&fault| self.stopped_by >> fault as u64 & 1 == 1)
    }

    /// An operator had paused the robot.
    #[must_use]
    pub fn was_paused(&self) -> bool {
        self.paused != 0
    }

    /// Quick: it is drawn ten times a second.
    fn sum(&self) -> u64 {
        let words: &[u64] = bytemuck::cast_slice(std::slice::from_ref(self));
        let skipped = (size_of_val(&self.mark) + size_of_val(&self.checksum)) / size_of::<u64>();
        let words = words[skipped..].iter();
        words.fold(0xcbf2_9ce4_8422_2325, |sum: u64, word| {
            (sum.rotate_left(5) ^ word).wrapping_mul(0x0100_0000_01b3)
        })
    }
}

/// Of all that decides what the numbers of a checkpoint mean.
fn fingerprint(plan: &Plan) -> u64 {
    let mut hasher = DefaultHasher::new();
    env!("CARGO_PKG_VERSION").hash(&mut hasher);
    format!("{:?} {:?}", plan.robot, plan.site.value).hash(&mut hasher);
    hasher.finish()
}
