//! A new scan: updates the trackers of features and corrects the pose.

use super::output::NavigationInput;
use super::state::{Navigator, end_wall};
use crate::localisation::{PoseFilter, ScanVerdict};
use crate::perception::WallFit;
use crate::scan::AlignedScan;
use description::geometry::{Pose2, Segment};
use std::f64::consts::FRAC_PI_2;

/// A scan taken farther than this from the present odometry pose is refused.
const SCAN_REACH_M: f64 = 1.0;
/// The search for a lost corridor starts with at least this uncertainty.
const RESTART_STD_M: f64 = 0.15;
const RESTART_STD_RAD: f64 = 0.10;

impl Navigator {
    /// Uses a scan that was not seen before.
    pub(super) fn look(&mut self, input: &NavigationInput) {
        let Some(scan) = input.scan.filter(|scan| scan.is_valid()) else {
            return;
        };
        let reference_ns = scan.reference_ns();
        if reference_ns == self.last_scan_ns {
            return;
        }
        let since = input.odometry.pose.between(scan.odom_pose());
        let near = since.is_finite() && since.position().norm_m() < SCAN_REACH_M;
        if reference_ns < self.last_scan_ns || !near {
            self.counters.scans_refused += 1;
            // A clock that was set back must not blind the robot for good.
            self.last_scan_ns = reference_ns;
            return;
        }
        self.last_scan_ns = reference_ns;
        self.counters.scans += 1;
        let room = self.points.capacity();
        self.points.clear();
        self.points
            .extend(scan.hits().take(room).map(|point| since.transform(point)));
        self.see(scan, since);
    }

    /// Looks for the schedule's features and corrects the pose by those that it tracks: by all walls in view, or else by
    /// those of corridor and lane end. The same points never correct twice.
    fn see(&mut self, scan: &AlignedScan, since: Pose2) {
        let tracks = self.schedule_now().tracks;
        if tracks.walls {
            self.pose.see_walls(&mut self.matcher, scan, since);
        }
        let mut best = ScanVerdict::Blind;
        self.see_corridor(&mut best, tracks.corridor && !tracks.walls);
        self.see_lane_end(&mut best, tracks.lane_end && !tracks.walls);
        if !tracks.walls && (tracks.corridor || tracks.lane_end) {
            self.pose.scan_done(best);
        }
    }

    fn see_corridor(&mut self, best: &mut ScanVerdict, corrects: bool) {
        let schedule = &self.schedules[self.machine.state().index()];
        let Some(lane) = schedule.lane.filter(|_| schedule.features.corridor) else {
            return;
        };
        let lane = &self.map.lanes()[lane];
        let along_m = lane.line.along_m(self.pose.pose().position());
        let walls = self
            .corridor
            .observe(&mut self.fitter, &self.points, lane, along_m);
        if corrects {
            for (wall, fit) in walls.fits() {
                correct(&mut self.pose, &wall.line, fit, best);
            }
        }
        if self.corridor.is_lost() {
            self.counters.corridor_restarts += 1;
            let std_m = self.pose.position_std_m().max(RESTART_STD_M);
            let std_rad = self.pose.heading_std_rad().max(RESTART_STD_RAD);
            self.corridor.start(lane, self.pose.pose(), std_m, std_rad);
        }
    }

    fn see_lane_end(&mut self, best: &mut ScanVerdict, corrects: bool) {
        let schedule = &self.schedules[self.machine.state().index()];
        let end = end_wall(&self.map, schedule);
        let Some(wall) = end.filter(|_| schedule.features.lane_end) else {
            return;
        };
        let std_m = self.pose.std_along_m(wall.direction_rad + FRAC_PI_2);
        let fit = self.lane_end.observe(
            &mut self.fitter,
            &self.points,
            &wall.line,
            self.pose.pose(),
            std_m,
        );
        if let Some(fit) = fit.filter(|_| corrects) {
            correct(&mut self.pose, &wall.line, &fit, best);
        }
    }
}

fn correct(pose: &mut PoseFilter, line: &Segment, fit: &WallFit, best: &mut ScanVerdict) {
    if pose.correct(line, fit) {
        *best = ScanVerdict::Corrected;
    } else if *best == ScanVerdict::Blind {
        *best = ScanVerdict::Refused;
    }
}
