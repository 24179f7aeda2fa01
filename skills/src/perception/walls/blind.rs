//! A scan without echoes where the map has walls: the sensor sees nothing, and its free floor is not to be believed.
//!
//! Beams without an echo are common: glass, black paint, walls at a slant, the open. A whole scan of them, where walls stand around
//! the robot, is a covered window or a broken sensor. A scan that sees some walls and misses others is none of this: the
//! matcher finds out whether it looks through them.

use super::matcher::WallMatcher;
use crate::scan::AlignedScan;
use description::geometry::{Point2, Pose2};

/// A blind sensor measures a length in this share of its beams at most: reflections of what covers it.
const MOST_ECHOES_SHARE: f64 = 0.05;
/// Walls should be in view of at least this share of the beams: 60° of the 240° of a URG-04LX, more than a glass door spans
/// from where a robot may stand before it.
const LEAST_EXPECTED_SHARE: f64 = 0.25;
/// Walls farther off than this share of the largest range may give no echo when they are dark.
const SURE_RANGE_SHARE: f64 = 0.75;

impl WallMatcher {
    /// Whether a scan shows nothing although walls are around: `since` is where the scan has `base_link`, seen from `base_link`
    /// now; `pose` is `base_link` in `map` now. Where it is not known, walls may be anywhere. Real time; little more than a count for a
    /// scan with echoes.
    pub fn is_blind(&mut self, scan: &AlignedScan, since: Pose2, pose: Option<Pose2>) -> bool {
        let geometry = scan.geometry();
        let share = |count: usize| count as f64 / geometry.beams as f64;
        let sees = !scan.is_valid() || share(scan.echoes()) > MOST_ECHOES_SHARE;
        if sees {
            return false;
        }
        let Some(pose) = pose else { return true };
        if !since.is_finite() || !pose.is_finite() {
            return false;
        }
        let eye = pose.compose(since.compose(geometry.mount));
        let reach_m = SURE_RANGE_SHARE * geometry.range_max_m;
        self.view.look(&self.walls, eye, reach_m);
        let hits_wall = |beam: &usize| {
            let (sin, cos) = (eye.theta_rad + geometry.beam_angle_rad(*beam)).sin_cos();
            let ray = Point2::new(cos, sin);
            self.view.expected(ray, 0.0).nearest.is_some()
        };
        share((0..geometry.beams).filter(hits_wall).count()) >= LEAST_EXPECTED_SHARE
    }
}
