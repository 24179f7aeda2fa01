//! The run-time object: what it holds between two scans or commands.

use super::detour::Detour;
use super::outcome::{Adapted, Counters, Reason, Verdict};
use super::retreat::Retreat;
use super::room::Room;
use super::select::{Selection, Selector};
use super::sight::Sight;
use super::stop_rules::StopRules;
use crate::tubes::error::TubeError;
use crate::tubes::memory::checkpoint::FloorCheckpoint;
use crate::tubes::memory::floor::Floor;
use crate::tubes::memory::known::KnownRanges;
use crate::tubes::memory::moving::Moving;
use crate::tubes::memory::seen::Memory;
use crate::tubes::set::tube_set::{Surroundings, TubeId, TubeSet};
use description::geometry::{MotionCommand, Pose2};
use description::keys::Section;
use description::robot::AdaptPolicy;

/// A stop because no tube was free.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// It wanted to go backward.
    pub(super) backward: bool,
    pub(super) since_ns: u64,
    pub(super) free_since_ns: Option<u64>,
}

/// The motion tubes of a running robot.
#[derive(Clone, Debug)]
pub struct MotionTubes {
    pub(super) set: TubeSet,
    pub(super) policy: AdaptPolicy,
    pub(super) stop_deceleration_m_s2: f64,
    pub(super) known: KnownRanges,
    pub(super) memory: Memory,
    pub(super) floor: Floor,
    pub(super) moving: Moving,
    pub(super) streaks: Box<[u8]>,
    /// The same of the narrow tubes; counted while somebody drives by hand.
    pub(super) narrow_streaks: Box<[u8]>,
    pub(super) clearance_m: f64,
    pub(super) sight: Sight,
    /// `base_link` in `odom` on the newest scan.
    pub(super) odom_pose: Pose2,
    pub(super) block: Option<Block>,
    pub(super) detour: Detour,
    pub(super) retreat: Retreat,
    pub(super) room: Option<Room>,
    /// Somebody drives by hand: no way around, and none back, is looked for.
    pub(super) by_hand: bool,
    pub(super) driven: Option<Selection>,
    /// The highest speed allowed until the next scan.
    pub(super) ceiling_m_s: f64,
    pub(super) last_curvature_1_m: f64,
    pub(super) moving_since_ns: Option<u64>,
    pub(super) counters: Counters,
}

impl MotionTubes {
    /// Takes a set of tubes into operation. It begins stopped, until scans have been good for long enough.
    ///
    /// # Errors
    /// [`TubeError::Key`] for the first value out of its range.
    pub fn new(set: TubeSet, policy: AdaptPolicy, rules: StopRules) -> Result<Self, TubeError> {
        Section::check(&policy).map_err(|error| error.below("tubes"))?;
        rules.check()?;
        let fastest_m_s = set.parameters().fastest_m_s();
        let memory_s = set.parameters().memory_s;
        let floor = Floor::new(
            set.grid(),
            *set.footprint(),
            *set.geometry(),
            &set.floor_mask(),
            set.parameters().floor_memory_m,
        );
        let near_m = set.footprint().length_m().max(set.footprint().width_m());
        Ok(Self {
            known: KnownRanges::new(set.geometry(), set.parameters().sample_step_m),
            memory: Memory::new(
                set.grid(),
                memory_s,
                2.0 * near_m + fastest_m_s * memory_s,
                fastest_m_s,
            ),
            floor,
            moving: Moving::new(set.geometry(), &policy.moving),
            streaks: vec![0; set.len()].into_boxed_slice(),
            narrow_streaks: vec![0; set.narrow.as_ref().map_or(0, |narrow| narrow.len())].into(),
            set,
            clearance_m: f64::INFINITY,
            sight: Sight::new(&rules),
            policy,
            stop_deceleration_m_s2: rules.deceleration_m_s2,
            odom_pose: Pose2::IDENTITY,
            block: None,
            detour: Detour::default(),
            retreat: Retreat::default(),
            room: None,
            by_hand: false,
            driven: None,
            ceiling_m_s: f64::INFINITY,
            last_curvature_1_m: 0.0,
            moving_since_ns: None,
            counters: Counters::default(),
        })
    }

    /// Detours from now on stay in this room; `None`: the path is not known, and detours are not limited by it.
    pub fn keep_within(&mut self, room: Option<Room>) {
        self.room = room;
    }

    /// Whether somebody drives by hand from now on: then nothing but the wanted motion is driven, or a shifted one within
    /// the band, and with the smaller margin where it must be. Ways around things and back from them are for who sees them.
    pub fn drive_by_hand(&mut self, by_hand: bool) {
        if by_hand != self.by_hand {
            self.by_hand = by_hand;
            self.narrow_streaks.fill(0);
            self.detour.reset();
            self.retreat.reset();
        }
    }

    /// Whether a tube was free on the newest scan.
    #[must_use]
    pub fn is_free(&self, id: TubeId) -> bool {
        self.streaks
            .get(id.0 as usize)
            .is_some_and(|&streak| streak > 0)
    }

    /// The tubes.
    #[must_use]
    pub fn set(&self) -> &TubeSet {
        &self.set
    }

    /// What is remembered of the robot's surroundings.
    #[must_use]
    pub fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Counts since the start.
    #[must_use]
    pub fn counters(&self) -> Counters {
        Counters {
            blind_stops: self.sight.blind_stops,
            detours: self.detour.begun,
            detour_side_changes: self.detour.changed_sides,
            retreats: self.retreat.begun,
            ..self.counters
        }
    }

    /// Writes down what is remembered of the floor around the robot. Real time.
    pub fn save(&self, into: &mut FloorCheckpoint) {
        if !(self.floor.save(into) && self.memory.save(into)) {
            into.cell_m = 0.0;
        }
    }

    /// Remembers what other tubes of this robot remembered. `false`: it is of another kind of robot, and nothing changes.
    pub fn resume(&mut self, from: &FloorCheckpoint) -> bool {
        let known = self.floor.resume(from);
        if known {
            self.memory.resume(from);
            self.odom_pose = from.pose;
        }
        known
    }

    /// Nobody has put the robot where it is, and what it remembered is gone: nothing is assumed of the floor beside it until it is reset.
    pub fn assume_nothing(&mut self) {
        self.floor.assume_nothing();
    }

    /// Somebody sees that the floor straight behind the robot is free, so many metres from its rear. Real time.
    pub fn trust_behind(&mut self, way_m: f64) {
        self.floor.trust_behind(way_m);
    }

    /// Forgets scans and memory, as when the odometry frame jumps; counters stay. It begins stopped.
    pub fn reset(&mut self) {
        self.memory.clear();
        self.floor.clear();
        self.moving.clear();
        self.detour.reset();
        self.retreat.reset();
        self.sight.reset();
        self.streaks.fill(0);
        self.narrow_streaks.fill(0);
        self.block = None;
        self.driven = None;
        self.moving_since_ns = None;
        self.ceiling_m_s = f64::INFINITY;
        self.clearance_m = f64::INFINITY;
    }

    /// What is known of the floor around the robot, also where the sensor does not look.
    pub(super) fn surroundings(&self) -> Surroundings<'_> {
        Surroundings {
            occupied: self.memory.occupied(),
            unknown: self.floor.unknown(),
            unassumed: self.floor.unassumed(),
        }
    }

    pub(super) fn selector(&self) -> Selector<'_> {
        Selector {
            set: &self.set,
            policy: &self.policy,
            streaks: &self.streaks,
        }
    }

    /// The answer when the robot is not to move.
    pub(super) fn stop(
        &mut self,
        reason: Reason,
        selection: Option<Selection>,
        since_ns: u64,
        now_ns: u64,
    ) -> Adapted {
        self.ceiling_m_s = 0.0;
        Adapted {
            command: MotionCommand::new(0.0, self.last_curvature_1_m),
            verdict: Verdict::Stopped,
            reason,
            tube: selection.map(|selection| selection.tube),
            length_m: selection.map_or(0.0, |selection| selection.length_m),
            clearance_m: self.clearance_m,
            moving_m: self.moving.nearest_m(),
            scan_age_ns: self.sight.age_ns(now_ns),
            stopped_since_ns: since_ns,
        }
    }
}
