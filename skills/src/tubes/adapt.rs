//! The run-time object: scans and wanted commands in, safe commands out.
//!
//! [`MotionTubes::observe`] judges all tubes on a scan. [`MotionTubes::adapt`] may be asked as often as one likes; between
//! two scans the speed it allows only falls. A command it returns can always be stopped inside a free tube:
//! v·(scan age + reaction) + v² / (2·a) stays within the tube's length. Neither allocates, locks or fails.
//!
//! It stops for one of the reasons in [`Reason`], says which and since when, and drives on by itself when the
//! reason has been gone for the time that the policy names.

use super::known::KnownRanges;
use super::memory::Memory;
use super::outcome::{Adapted, Counters, ObserveError, Reason, Verdict};
use super::parameters::{AdaptPolicy, TubeError};
use super::select::{Search, Selection, Selector};
use super::set::{TubeId, TubeSet};
use crate::geometry::{MotionCommand, Twist2};
use crate::scan::AlignedScan;

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
    streaks: Box<[u8]>,
    clearance_m: f64,
    /// Reference and arrival of the newest scan.
    newest: Option<(u64, u64)>,
    /// Since when scans have come without a gap.
    good_since_ns: Option<u64>,
    blind_since_ns: Option<u64>,
    block: Option<Block>,
    driven: Option<Selection>,
    /// The highest speed allowed until the next scan.
    ceiling_m_s: f64,
    last_curvature_1_m: f64,
    counters: Counters,
}

fn ns(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}

impl MotionTubes {
    /// Takes a set of tubes into operation. It begins stopped, until scans have been good for long enough.
    pub fn new(set: TubeSet, policy: AdaptPolicy) -> Result<Self, TubeError> {
        policy.validate()?;
        let fastest_m_s = set
            .parameters()
            .horizons
            .iter()
            .map(|horizon| horizon.speed_m_s)
            .fold(0.0, f64::max);
        let memory_s = set.parameters().memory_s;
        let near_m = set.footprint().length_m().max(set.footprint().width_m());
        Ok(Self {
            known: KnownRanges::new(set.geometry(), set.parameters().d_sample_m),
            memory: Memory::new(set.grid(), memory_s, 2.0 * near_m + fastest_m_s * memory_s),
            streaks: vec![0; set.len()].into_boxed_slice(),
            set,
            policy,
            clearance_m: f64::INFINITY,
            newest: None,
            good_since_ns: None,
            blind_since_ns: None,
            block: None,
            driven: None,
            ceiling_m_s: f64::INFINITY,
            last_curvature_1_m: 0.0,
            counters: Counters::default(),
        })
    }

    /// Judges all tubes on a scan that arrived at `now_ns`.
    pub fn observe(&mut self, scan: &AlignedScan, now_ns: u64) -> Result<(), ObserveError> {
        let checked = self.check(scan, now_ns);
        if checked.is_err() {
            self.counters.refused += 1;
            return checked;
        }
        let timeout_ns = ns(self.policy.scan_timeout_s);
        let gap = self
            .newest
            .is_none_or(|(_, arrival_ns)| now_ns.saturating_sub(arrival_ns) > timeout_ns);
        if gap || self.good_since_ns.is_none() {
            self.good_since_ns = Some(now_ns);
            self.streaks.fill(0);
        }
        self.newest = Some((scan.reference_ns(), now_ns));
        self.memory.observe(scan);
        self.known.load(scan.ranges_m());
        for (id, streak) in self.set.ids().zip(self.streaks.iter_mut()) {
            let free = self.set.is_free(id, &self.known, self.memory.occupied());
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
        let reference_ns = scan.reference_ns();
        if let Some((previous_ns, _)) = self.newest
            && reference_ns <= previous_ns
        {
            return Err(ObserveError::NotAfter {
                reference_ns,
                previous_ns,
            });
        }
        let timeout_ns = ns(self.policy.scan_timeout_s);
        if reference_ns.abs_diff(now_ns) > timeout_ns {
            return Err(ObserveError::NotOfNow {
                reference_ns,
                now_ns,
            });
        }
        Ok(())
    }

    /// What to drive instead of `wanted`, while the robot moves at `current`.
    pub fn adapt(&mut self, wanted: MotionCommand, current: Twist2, now_ns: u64) -> Adapted {
        if !wanted.is_finite() || !current.is_finite() {
            return self.stop(Reason::NotFinite, None, now_ns, now_ns);
        }
        if let Some((reason, since_ns)) = self.look_for_sight(now_ns) {
            return self.stop(reason, None, since_ns, now_ns);
        }
        if wanted.speed_m_s < 0.0 {
            return self.stop(Reason::Backwards, None, now_ns, now_ns);
        }
        let selector = Selector {
            set: &self.set,
            policy: &self.policy,
            streaks: &self.streaks,
        };
        let search = selector.search(wanted, self.driven);
        let selection = match (
            search,
            self.settle_block(search, wanted.speed_m_s > 0.0, now_ns),
        ) {
            (Search::Found(selection), None) => selection,
            // Who does not want to move is not stopped.
            (_, _) if wanted.speed_m_s == 0.0 => return self.rest(wanted, now_ns),
            (Search::Found(_), Some(since_ns)) => {
                return self.stop(Reason::Resuming, None, since_ns, now_ns);
            }
            (Search::Blocked, since_ns) => {
                return self.stop(Reason::Blocked, None, since_ns.unwrap_or(now_ns), now_ns);
            }
            (Search::BeyondTubes, since_ns) => {
                return self.stop(
                    Reason::BeyondTubes,
                    None,
                    since_ns.unwrap_or(now_ns),
                    now_ns,
                );
            }
        };
        self.drive(wanted, current, selection, now_ns)
    }

    fn drive(
        &mut self,
        wanted: MotionCommand,
        current: Twist2,
        selection: Selection,
        now_ns: u64,
    ) -> Adapted {
        let horizon = self.set.rows[selection.row].horizon;
        let length_m = selection.length_m;
        let decel = self.policy.stop_deceleration_m_s2;
        let delay_s = self.age_ns(now_ns) as f64 * 1e-9 + self.policy.reaction_s;
        let stop_within = |speed_m_s: f64| {
            speed_m_s * delay_s + speed_m_s * speed_m_s / (2.0 * decel) <= length_m
        };
        if !stop_within(current.v_m_s.abs()) {
            self.driven = None;
            return self.stop(Reason::TooFast, Some(selection), now_ns, now_ns);
        }
        let lag_m_s = decel * delay_s;
        let stoppable_m_s = (lag_m_s * lag_m_s + 2.0 * decel * length_m).sqrt() - lag_m_s;
        let speed_m_s = wanted
            .speed_m_s
            .min(horizon.speed_m_s)
            .min(stoppable_m_s)
            .min(self.ceiling_m_s);
        self.ceiling_m_s = speed_m_s;
        self.driven = Some(selection);
        self.last_curvature_1_m = selection.curvature_1_m;
        let (verdict, reason) = if selection.shift_1_m != 0.0 {
            (Verdict::Shifted, Reason::Blocked)
        } else if speed_m_s < wanted.speed_m_s {
            (Verdict::Slowed, Reason::Blocked)
        } else {
            (Verdict::Free, Reason::None)
        };
        Adapted {
            command: MotionCommand::new(speed_m_s, selection.curvature_1_m),
            verdict,
            reason,
            tube: Some(selection.tube),
            length_m,
            clearance_m: self.clearance_m,
            scan_age_ns: self.age_ns(now_ns),
            stopped_since_ns: 0,
        }
    }

    /// A reason to stop for want of sight, and since when.
    fn look_for_sight(&mut self, now_ns: u64) -> Option<(Reason, u64)> {
        let timeout_ns = ns(self.policy.scan_timeout_s);
        let fresh = self
            .newest
            .is_some_and(|(_, arrival_ns)| now_ns.saturating_sub(arrival_ns) <= timeout_ns);
        if !fresh {
            if self.blind_since_ns.is_none() {
                self.counters.blind_stops += 1;
            }
            self.good_since_ns = None;
            self.driven = None;
            let since_ns = *self.blind_since_ns.get_or_insert(now_ns);
            return Some((Reason::NoScan, since_ns));
        }
        let good_ns = self
            .good_since_ns
            .map_or(0, |since_ns| now_ns.saturating_sub(since_ns));
        if good_ns < ns(self.policy.good_scans_s) {
            self.driven = None;
            let since_ns = *self.blind_since_ns.get_or_insert(now_ns);
            return Some((Reason::AwaitingScans, since_ns));
        }
        self.blind_since_ns = None;
        None
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
        Adapted {
            command: wanted,
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
            scan_age_ns: self.age_ns(now_ns),
            stopped_since_ns: since_ns,
        }
    }

    fn age_ns(&self, now_ns: u64) -> u64 {
        self.newest.map_or(u64::MAX, |(reference_ns, _)| {
            now_ns.saturating_sub(reference_ns)
        })
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
        self.counters
    }

    /// Forgets scans and memory, as when the odometry frame jumps; counters stay. It begins stopped.
    pub fn reset(&mut self) {
        self.memory.clear();
        self.streaks.fill(0);
        self.newest = None;
        self.good_since_ns = None;
        self.blind_since_ns = None;
        self.block = None;
        self.driven = None;
        self.ceiling_m_s = f64::INFINITY;
        self.clearance_m = f64::INFINITY;
    }
}
