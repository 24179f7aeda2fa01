//! A new scan: every tube is judged on it.

use super::motion_tubes::MotionTubes;
use super::outcome::ObserveError;
use crate::scan::AlignedScan;
use crate::tubes::set::tube_set::{Surroundings, TubeSet};

/// Odometry has jumped when it moves this much farther between two scans than the robot can drive.
const JUMP_M: f64 = 0.3;

impl MotionTubes {
    /// Judges all tubes on a scan that arrived at `now_ns`.
    ///
    /// # Errors
    /// [`ObserveError`]: why the scan was not judged. It is counted, and changes nothing.
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
            self.narrow_streaks.fill(0);
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
        let judge = |set: &TubeSet, streaks: &mut [u8]| {
            for (id, streak) in set.ids().zip(streaks) {
                let free = set.is_free(id, &self.known, near);
                *streak = if free { streak.saturating_add(1) } else { 0 };
            }
        };
        judge(&self.set, &mut self.streaks);
        if let Some(narrow) = self.set.narrow.as_deref().filter(|_| self.by_hand) {
            judge(narrow, &mut self.narrow_streaks);
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

    /// Forgets what is remembered in the odometry frame when that frame has jumped.
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
}
