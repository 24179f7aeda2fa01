//! The run-time object: scans and wanted commands in, safe commands out.
//!
//! [`MotionTubes::observe`] judges all tubes on a scan. [`MotionTubes::adapt`] may be asked as often as one likes; between
//! two scans the speed it allows only falls. A command it returns can always be stopped inside a free tube:
//! v·(scan age + reaction) + v² / (2·a) stays within the tube's length; and before something that moves arrives, see
//! `moving`. Neither allocates, locks or fails.
//!
//! It stops for one of the reasons in [`Reason`], says which and since when, and drives on by itself when the
//! reason has been gone for the time that the policy names.

use super::detour::{Detour, Moment};
use super::outcome::{Adapted, Counters, ObserveError, Reason, Verdict};
use super::retreat::{self, Retreat};
use super::room::Room;
use super::select::{Search, Selection, Selector};
use crate::scan::AlignedScan;
use crate::tubes::error::TubeError;
use crate::tubes::memory::floor::Floor;
use crate::tubes::memory::known::KnownRanges;
use crate::tubes::memory::moving::{Moving, highest_speed_m_s};
use crate::tubes::memory::seen::Memory;
use crate::tubes::parameters::AdaptPolicy;
use crate::tubes::set::tube_set::{Surroundings, TubeId, TubeSet};
use description::geometry::{MotionCommand, Pose2, Twist2};

use super::sight::Sight;

/// No detour begins while something moves this near.
const CROWDED_M: f64 = 1.5;
/// Below this the robot may turn back.
const AT_REST_M_S: f64 = 0.02;
/// Slower than this a curvature cannot be told from the twist.
const STEERED_M_S: f64 = 0.1;
/// A curvature this far from the selected one is judged by itself until it is steered away.
const STEERED_AWAY_1_M: f64 = 0.5;
/// Odometry that moves farther between two scans, beyond what is possible, has jumped.
const JUMP_M: f64 = 0.3;
/// Towards something that moves it slows down at this share of the deceleration that it could have.
const GENTLE_SHARE: f64 = 0.5;
/// This much above the speed that something that moves allows is a reason to stop.
const OVERSPEED_M_S: f64 = 0.03;

/// A stop because no tube was free.
#[derive(Clone, Copy, Debug)]
struct Block {
    since_ns: u64,
    free_since_ns: Option<u64>,
}

/// The motion tubes of a running robot.
#[derive(Clone, Debug)]
pub struct MotionTubes {
    set: TubeSet,
    policy: AdaptPolicy,
    known: KnownRanges,
    memory: Memory,
    floor: Floor,
    moving: Moving,
    streaks: Box<[u8]>,
    clearance_m: f64,
    sight: Sight,
    /// `base_link` in `odom` on the newest scan.
    odom_pose: Pose2,
    block: Option<Block>,
    detour: Detour,
    retreat: Retreat,
    room: Option<Room>,
    driven: Option<Selection>,
    /// The highest speed allowed until the next scan.
    ceiling_m_s: f64,
    last_curvature_1_m: f64,
    moving_since_ns: Option<u64>,
    counters: Counters,
}

fn ns(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}

impl MotionTubes {
    /// Takes a set of tubes into operation. It begins stopped, until scans have been good for long enough.
    pub fn new(set: TubeSet, policy: AdaptPolicy) -> Result<Self, TubeError> {
        policy.validate()?;
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
            known: KnownRanges::new(set.geometry(), set.parameters().d_sample_m),
            memory: Memory::new(
                set.grid(),
                memory_s,
                2.0 * near_m + fastest_m_s * memory_s,
                fastest_m_s,
            ),
            floor,
            moving: Moving::new(set.geometry(), &policy.moving),
            streaks: vec![0; set.len()].into_boxed_slice(),
            set,
            clearance_m: f64::INFINITY,
            sight: Sight::new(&policy),
            policy,
            odom_pose: Pose2::IDENTITY,
            block: None,
            detour: Detour::default(),
            retreat: Retreat::default(),
            room: None,
            driven: None,
            ceiling_m_s: f64::INFINITY,
            last_curvature_1_m: 0.0,
            moving_since_ns: None,
            counters: Counters::default(),
        })
    }

    /// Judges all tubes on a scan that arrived at `now_ns`.
    pub fn observe(&mut self, scan: &AlignedScan, now_ns: u64) -> Result<(), ObserveError> {
        if self.sight.clock_ran_back(now_ns) {
            self.counters.jumps += 1;
            self.reset();
        }
        let checked = self.check(scan, now_ns);
        if checked.is_err() {
            self.counters.refused += 1;
            return checked;
        }
        self.look_for_jump(scan);
        if self.sight.take(scan.reference_ns(), now_ns) {
            self.streaks.fill(0);
        }
        self.odom_pose = scan.odom_pose();
        self.memory.observe(scan);
        self.known.load(scan.ranges_m());
        self.floor.observe(scan, &self.known);
        self.moving.observe(scan, &self.known, self.set.footprint());
        let near = Surroundings {
            occupied: self.memory.occupied(),
            unknown: self.floor.unknown(),
            unassumed: self.floor.unassumed(),
        };
        for (id, streak) in self.set.ids().zip(self.streaks.iter_mut()) {
            let free = self.set.is_free(id, &self.known, near);
            *streak = if free { streak.saturating_add(1) } else { 0 };
        }
        let footprint = *self.set.footprint();
        self.clearance_m = scan
            .hits()
            .map(|hit| footprint.distance_m(hit))
            .fold(f64::INFINITY, f64::min);
        self.ceiling_m_s = f64::INFINITY;
        self.counters.scans += 1;
        Ok(())
    }

    fn check(&self, scan: &AlignedScan, now_ns: u64) -> Result<(), ObserveError> {
        if !scan.is_valid() {
            return Err(ObserveError::Empty);
        }
        if scan.geometry() != self.set.geometry() {
            return Err(ObserveError::Geometry);
        }
        self.sight.check(scan.reference_ns(), now_ns)
    }

    /// What is remembered in the odometry frame is of no use when that frame has jumped.
    fn look_for_jump(&mut self, scan: &AlignedScan) {
        let Some(before_ns) = self.sight.newest_ns() else {
            return;
        };
        let passed_s = scan.reference_ns().saturating_sub(before_ns) as f64 * 1e-9;
        let possible_m = 2.0 * self.set.parameters().fastest_m_s() * passed_s + JUMP_M;
        let moved_m = self
            .odom_pose
            .position()
            .distance_m(scan.odom_pose().position());
        if moved_m > possible_m {
            self.counters.jumps += 1;
            self.memory.clear();
            self.floor.clear();
            self.moving.clear();
            self.detour.reset();
            self.retreat.reset();
        }
    }

    /// Detours from now on stay in this room; `None`: nobody knows the path, and none is kept to.
    pub fn keep_within(&mut self, room: Option<Room>) {
        self.room = room;
    }

    /// What to drive instead of `wanted`, while the robot moves at `current`.
    pub fn adapt(&mut self, wanted: MotionCommand, current: Twist2, now_ns: u64) -> Adapted {
        if !wanted.is_finite() || !current.is_finite() {
            return self.stop(Reason::NotFinite, None, now_ns, now_ns);
        }
        if let Some((reason, since_ns)) = self.sight.look(now_ns) {
            self.driven = None;
            return self.stop(reason, None, since_ns, now_ns);
        }
        let backward = wanted.speed_m_s < 0.0;
        if backward && !self.set.has_backward() {
            return self.stop(Reason::Backwards, None, now_ns, now_ns);
        }
        let search = self.search(wanted, now_ns);
        if let Some(adapted) = self.back_out(wanted, current, search, now_ns) {
            return adapted;
        }
        let blocked_ns = self.settle_block(search, wanted.speed_m_s != 0.0, now_ns);
        let selection = match (search, blocked_ns) {
            (Search::Found(selection), None) => selection,
            // Who does not want to move is not stopped.
            (_, _) if wanted.speed_m_s == 0.0 => return self.rest(wanted, now_ns),
            (Search::Found(_), Some(since_ns)) => {
                return self.stop(Reason::Resuming, None, since_ns, now_ns);
            }
            (Search::Blocked, since_ns) => {
                let since_ns = since_ns.unwrap_or(now_ns);
                let reason = if backward && self.lacks_floor(wanted) {
                    Reason::UnknownFloor
                } else {
                    Reason::Blocked
                };
                return self.stop(reason, None, since_ns, now_ns);
            }
            (Search::BeyondTubes, since_ns) => {
                let since_ns = since_ns.unwrap_or(now_ns);
                return self.stop(Reason::BeyondTubes, None, since_ns, now_ns);
            }
        };
        self.drive(wanted, current, selection, now_ns)
    }

    fn selector(&self) -> Selector<'_> {
        Selector {
            set: &self.set,
            policy: &self.policy,
            streaks: &self.streaks,
        }
    }

    fn search(&mut self, wanted: MotionCommand, now_ns: u64) -> Search {
        let selector = Selector {
            set: &self.set,
            policy: &self.policy,
            streaks: &self.streaks,
        };
        let moment = Moment {
            now_ns,
            heading_rad: self.odom_pose.theta_rad,
            crowded: self.moving.nearest_m() < CROWDED_M,
            room: self.room,
            known: &self.known,
        };
        let nominal = selector.search(wanted, self.driven);
        self.detour.search(&selector, nominal, wanted, moment)
    }

    /// What to drive while the robot backs out of where no way leads on; `None` while it does not.
    fn back_out(
        &mut self,
        wanted: MotionCommand,
        current: Twist2,
        search: Search,
        now_ns: u64,
    ) -> Option<Adapted> {
        let policy = self.policy.detour;
        let goes = policy.curvature_1_m > 0.0 && wanted.speed_m_s > 0.0 && self.set.has_backward();
        let blocked = matches!(search, Search::Blocked);
        let moment = retreat::Moment {
            now_ns,
            at: self.odom_pose.position(),
            blocked_since_ns: self.block.filter(|_| blocked).map(|block| block.since_ns),
            moving_m: self.moving.nearest_m(),
        };
        let was_active = self.retreat.is_active();
        if !(goes && self.retreat.goes(&policy, moment)) {
            self.retreat.end();
            return None;
        }
        if !was_active {
            // From there it chooses its way anew.
            self.detour.reset_way();
        }
        let slowest_m_s = self.set.rows[self.set.rows.len() - 1].horizon.speed_m_s;
        let left_m = self.retreat.left_m(&policy, moment.at);
        // Straight, or else as it came, no tighter than what was looked at.
        let tightest_1_m = self
            .room
            .map_or(policy.curvature_1_m, |room| room.tightest_1_m);
        let before_1_m = self.last_curvature_1_m;
        let back = [0.0, before_1_m.max(-tightest_1_m).min(tightest_1_m)].map(|back_1_m| {
            let back = MotionCommand::new(-slowest_m_s, back_1_m);
            let Search::Found(selection) = self.selector().search(back, None) else {
                return None;
            };
            let stays = |room: Room| room.holds_behind(selection.curvature_1_m, left_m);
            self.room.is_none_or(stays).then_some((back, selection))
        });
        let Some((back, selection)) = back[0].or(back[1]) else {
            self.retreat.end();
            return None;
        };
        let adapted = self.drive(back, current, selection, now_ns);
        // It is not what was wanted.
        let verdict = match adapted.verdict {
            Verdict::Stopped => Verdict::Stopped,
            _ => Verdict::Shifted,
        };
        let reason = match adapted.reason {
            Reason::None => Reason::Blocked,
            reason => reason,
        };
        Some(Adapted {
            verdict,
            reason,
            ..adapted
        })
    }

    /// Only the want of knowledge of the floor keeps the tube nearest to a wanted command from being free.
    fn lacks_floor(&self, wanted: MotionCommand) -> bool {
        let near = Surroundings {
            occupied: self.memory.occupied(),
            unknown: self.floor.unknown(),
            unassumed: self.floor.unassumed(),
        };
        self.selector()
            .nearest_behind(wanted.curvature_1_m)
            .is_some_and(|id| self.set.lacks_floor(id, &self.known, near))
    }

    fn drive(
        &mut self,
        wanted: MotionCommand,
        current: Twist2,
        selection: Selection,
        now_ns: u64,
    ) -> Adapted {
        let delay_s = self.sight.age_ns(now_ns) as f64 * 1e-9 + self.policy.reaction_s;
        if current.v_m_s.abs() > AT_REST_M_S && current.v_m_s * wanted.speed_m_s < 0.0 {
            self.driven = None;
            return self.stop(Reason::Reversing, None, now_ns, now_ns);
        }
        let length_m = self.length_m(&selection, current);
        let decel = self.policy.stop_deceleration_m_s2;
        let speed_m_s = current.v_m_s.abs();
        if speed_m_s * delay_s + speed_m_s * speed_m_s / (2.0 * decel) > length_m {
            self.driven = None;
            return self.stop(Reason::TooFast, Some(selection), now_ns, now_ns);
        }
        let lag_m_s = decel * delay_s;
        let stoppable_m_s = (lag_m_s * lag_m_s + 2.0 * decel * length_m).sqrt() - lag_m_s;
        let Some(unmet_m_s) = self.unmet_m_s(speed_m_s, delay_s) else {
            let since_ns = *self.moving_since_ns.get_or_insert_with(|| {
                self.counters.moving_stops += 1;
                now_ns
            });
            return self.stop(Reason::Moving, Some(selection), since_ns, now_ns);
        };
        self.moving_since_ns = None;
        let mut allowed_m_s = self.set.rows[selection.row].horizon.speed_m_s;
        if self.detour.is_active() {
            allowed_m_s = allowed_m_s.min(self.policy.detour.speed_m_s);
        }
        if self.detour.waits() {
            allowed_m_s = 0.0;
        }
        let wanted_m_s = wanted.speed_m_s.abs();
        let speed_m_s = wanted_m_s
            .min(allowed_m_s)
            .min(stoppable_m_s)
            .min(unmet_m_s)
            .min(self.ceiling_m_s);
        self.ceiling_m_s = speed_m_s;
        self.driven = Some(selection);
        self.last_curvature_1_m = selection.curvature_1_m;
        let slowed = speed_m_s < wanted_m_s;
        let (verdict, reason) = if selection.shift_1_m != 0.0 {
            (Verdict::Shifted, Reason::Blocked)
        } else if slowed && (unmet_m_s <= speed_m_s || self.detour.waits()) {
            (Verdict::Slowed, Reason::Moving)
        } else if slowed {
            (Verdict::Slowed, Reason::Blocked)
        } else {
            (Verdict::Free, Reason::None)
        };
        let sign = if wanted.speed_m_s < 0.0 { -1.0 } else { 1.0 };
        Adapted {
            command: MotionCommand::new(sign * speed_m_s, selection.curvature_1_m),
            verdict,
            reason,
            tube: Some(selection.tube),
            length_m,
            clearance_m: self.clearance_m,
            moving_m: self.moving.nearest_m(),
            scan_age_ns: self.sight.age_ns(now_ns),
            stopped_since_ns: 0,
        }
    }

    /// How far it is free: along the selected tube and, while the robot still turns otherwise, along that curve, too.
    fn length_m(&self, selection: &Selection, current: Twist2) -> f64 {
        if current.v_m_s.abs() < STEERED_M_S {
            return selection.length_m;
        }
        let curvature_1_m = current.omega_rad_s / current.v_m_s;
        if (curvature_1_m - selection.curvature_1_m).abs() < STEERED_AWAY_1_M {
            return selection.length_m;
        }
        self.selector()
            .free_length_m(curvature_1_m, current.v_m_s < 0.0)
            .map_or(selection.length_m, |free_m| free_m.min(selection.length_m))
    }

    /// The highest speed that lets the robot stand before something that moves arrives; `None` when it must stop.
    fn unmet_m_s(&self, speed_m_s: f64, delay_s: f64) -> Option<f64> {
        let decel = self.policy.stop_deceleration_m_s2;
        let away_m = self.moving.nearest_m();
        let highest =
            |decel_m_s2| highest_speed_m_s(&self.policy.moving, away_m, delay_s, decel_m_s2);
        let hardly_m_s = highest(decel);
        let too_fast = speed_m_s > hardly_m_s.max(0.0) + OVERSPEED_M_S;
        if hardly_m_s <= 0.0 || too_fast {
            return None;
        }
        Some(highest(GENTLE_SHARE * decel).max(0.0))
    }

    /// Follows the search into and out of a block; gives since when it has been blocked, while it is.
    fn settle_block(&mut self, search: Search, wants_to_move: bool, now_ns: u64) -> Option<u64> {
        let found = matches!(search, Search::Found(_));
        let Some(block) = &mut self.block else {
            if found || !wants_to_move {
                return None;
            }
            self.counters.blocked_stops += 1;
            self.driven = None;
            self.block = Some(Block {
                since_ns: now_ns,
                free_since_ns: None,
            });
            return Some(now_ns);
        };
        if !found {
            block.free_since_ns = None;
            return Some(block.since_ns);
        }
        let free_since_ns = *block.free_since_ns.get_or_insert(now_ns);
        if now_ns.saturating_sub(free_since_ns) >= ns(self.policy.resume_after_s) {
            self.block = None;
            return None;
        }
        Some(block.since_ns)
    }

    fn rest(&mut self, wanted: MotionCommand, now_ns: u64) -> Adapted {
        // Wheels are not turned farther than any tube would.
        let most_1_m = self.set.most_curvature_1_m();
        let curvature_1_m = wanted.curvature_1_m.clamp(-most_1_m, most_1_m);
        Adapted {
            command: MotionCommand::new(0.0, curvature_1_m),
            verdict: Verdict::Free,
            reason: Reason::None,
            stopped_since_ns: 0,
            ..self.stop(Reason::None, None, 0, now_ns)
        }
    }

    fn stop(
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

    /// What has happened so far.
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

    /// Forgets scans and memory, as when the odometry frame jumps; counters stay. It begins stopped.
    pub fn reset(&mut self) {
        self.memory.clear();
        self.floor.clear();
        self.moving.clear();
        self.detour.reset();
        self.retreat.reset();
        self.sight.reset();
        self.streaks.fill(0);
        self.block = None;
        self.driven = None;
        self.moving_since_ns = None;
        self.ceiling_m_s = f64::INFINITY;
        self.clearance_m = f64::INFINITY;
    }
}
