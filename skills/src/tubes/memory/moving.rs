//! Things that move: hits where a scan of a moment ago saw free floor.
//!
//! A scan is compared with one a quarter of a second old, and with one three quarters old for what moves slowly. A hit
//! counts as moving when the older scan looked clearly beyond it; what was merely out of sight does not. A run of such
//! beams is a thing. How far it is from the robot is all that is asked: it may turn at any time, so its direction
//! counts for nothing.
//!
//! A person who stops walking may walk on: what stands where something moved a few seconds ago still counts.
//!
//! Slower than about 0.15 m/s counts as standing; what comes from where the sensor does not look, or steps out of a
//! hiding place, counts once it has moved a tenth of a metre in view.
//!
//! All memory is taken at construction.

use super::known::KnownRanges;
use crate::scan::{AlignedScan, BeamGrid, BeamState, ScanGeometry};
use description::geometry::{Footprint, Point2, Pose2};
use description::robot::MovingPolicy;

/// Scans that are kept.
const KEPT: usize = 16;
/// A hit is compared with the youngest scan that is older than each of these.
const AGES_NS: [u64; 2] = [250_000_000, 750_000_000];
/// Scans older than this are no comparison.
const OLDEST_NS: u64 = 1_500_000_000;
/// The older scan must have looked beyond the hit by this much plus this share of its range.
const BEYOND_M: f64 = 0.10;
const BEYOND_SHARE: f64 = 0.02;
/// Neighbouring beams to either side that must agree.
const BESIDE: usize = 2;
/// Beams in a row that make a thing.
const RUN: usize = 4;
/// Beams of a run are no farther apart than this.
const RUN_STEP_M: f64 = 0.2;
/// Motion farther from the robot than this is ignored.
const FARTHEST_M: f64 = 2.5;

/// Things that moved and are remembered.
const SPOTS: usize = 16;
/// Largest distance that a thing moves between two scans.
const SPOT_STEP_M: f64 = 0.5;
/// A thing that has not moved for longer rests; what moves past it is another one.
const TRACKED_NS: u64 = 500_000_000;
/// A hit within this distance of where something was last seen moving is the same thing.
const SPOT_REACH_M: f64 = 0.3;

/// Where something moved, in `odom`, and when; 0 for nowhere.
#[derive(Clone, Copy, Debug, Default)]
struct Spot {
    at: Point2,
    moved_ns: u64,
}

#[derive(Clone, Debug)]
struct Past {
    ranges_m: Box<[f32]>,
    /// `laser` in `odom`.
    sensor: Pose2,
    reference_ns: u64,
}

/// Looks for things that move.
#[derive(Clone, Debug)]
pub struct Moving {
    ring: Box<[Past]>,
    next: usize,
    len: usize,
    nearest_m: f64,
    spots: [Spot; SPOTS],
    rest_ns: u64,
}

impl Moving {
    /// Nothing seen yet. Ignores all motion when the policy's speed is 0.
    #[must_use]
    pub fn new(geometry: &ScanGeometry, policy: &MovingPolicy) -> Self {
        let kept = if policy.speed_m_s > 0.0 { KEPT } else { 0 };
        let past = Past {
            ranges_m: vec![0.0; geometry.beams].into_boxed_slice(),
            sensor: Pose2::IDENTITY,
            reference_ns: 0,
        };
        Self {
            ring: vec![past; kept].into_boxed_slice(),
            next: 0,
            len: 0,
            nearest_m: f64::INFINITY,
            spots: [Spot::default(); SPOTS],
            rest_ns: (policy.rest_s * 1e9) as u64,
        }
    }

    /// From the footprint to the nearest thing that moves; infinite when there is none.
    #[must_use]
    pub fn nearest_m(&self) -> f64 {
        self.nearest_m
    }

    /// Forgets everything, as when the odometry frame jumps.
    pub fn clear(&mut self) {
        self.len = 0;
        self.nearest_m = f64::INFINITY;
        self.spots = [Spot::default(); SPOTS];
    }

    /// Looks at a scan.
    pub fn observe(&mut self, scan: &AlignedScan, known: &KnownRanges, footprint: &Footprint) {
        if self.ring.is_empty() {
            return;
        }
        let now_ns = scan.reference_ns();
        let mut spots = self.spots;
        self.nearest_m = AGES_NS
            .iter()
            .filter_map(|&age_ns| self.past(now_ns, age_ns))
            .map(|past| nearest_m(scan, past, footprint, &mut spots))
            .fold(f64::INFINITY, f64::min);
        self.spots = spots;
        self.nearest_m = self.nearest_m.min(self.resting_m(scan, footprint));
        let past = &mut self.ring[self.next];
        let beams = past.ranges_m.len();
        past.ranges_m.copy_from_slice(&known.as_array()[..beams]);
        past.sensor = scan.odom_pose().compose(scan.geometry().mount);
        past.reference_ns = scan.reference_ns();
        self.next = (self.next + 1) % self.ring.len();
        self.len = (self.len + 1).min(self.ring.len());
    }

    /// From the footprint to the nearest hit where something moved not long ago.
    fn resting_m(&self, scan: &AlignedScan, footprint: &Footprint) -> f64 {
        let now_ns = scan.reference_ns();
        let mut nearest_m = f64::INFINITY;
        for spot in &self.spots {
            if spot.moved_ns == 0 || now_ns.saturating_sub(spot.moved_ns) > self.rest_ns {
                continue;
            }
            let at = scan.odom_pose().inverse_transform(spot.at);
            if footprint.distance_m(at) > FARTHEST_M {
                continue;
            }
            nearest_m = scan
                .hits()
                .filter(|hit| hit.distance_m(at) <= SPOT_REACH_M)
                .map(|hit| footprint.distance_m(hit))
                .fold(nearest_m, f64::min);
        }
        nearest_m
    }

    /// The youngest scan of at least an age.
    fn past(&self, now_ns: u64, age_ns: u64) -> Option<&Past> {
        let kept = self.ring.len();
        (1..=self.len)
            .map(|back| &self.ring[(self.next + kept - back) % kept])
            .find(|past| now_ns.saturating_sub(past.reference_ns) >= age_ns)
            .filter(|past| now_ns.saturating_sub(past.reference_ns) <= OLDEST_NS)
    }
}

/// Remembers where something moves.
fn mark(spots: &mut [Spot; SPOTS], at: Point2, now_ns: u64) {
    let (mut place, mut nearest_m) = (0, f64::INFINITY);
    for (index, spot) in spots.iter().enumerate() {
        let reach_m = if now_ns.saturating_sub(spot.moved_ns) <= TRACKED_NS {
            SPOT_STEP_M
        } else {
            SPOT_REACH_M
        };
        let away_m = spot.at.distance_m(at);
        if spot.moved_ns > 0 && away_m <= reach_m && away_m < nearest_m {
            (place, nearest_m) = (index, away_m);
        }
        if nearest_m.is_infinite() && spot.moved_ns < spots[place].moved_ns {
            place = index;
        }
    }
    spots[place] = Spot {
        at,
        moved_ns: now_ns,
    };
}

/// From the footprint to the nearest run of hits that the older scan looked beyond.
fn nearest_m(
    scan: &AlignedScan,
    past: &Past,
    footprint: &Footprint,
    spots: &mut [Spot; SPOTS],
) -> f64 {
    let to_past = past.sensor.between(scan.odom_pose()).transformation();
    let grid = scan.geometry().beam_grid();
    let mut nearest_m = f64::INFINITY;
    let mut run = MovedBeams::default();
    for beam in scan.points() {
        if beam.state != BeamState::Hit || f64::from(beam.range_m) > FARTHEST_M + 1.0 {
            run.miss();
            continue;
        }
        if !is_beyond(&grid, past, to_past(beam.point)) {
            run.miss();
            continue;
        }
        let away_m = footprint.distance_m(beam.point);
        if let Some(away_m) = run.hit(beam.point, away_m)
            && away_m <= FARTHEST_M
        {
            nearest_m = nearest_m.min(away_m);
            mark(
                spots,
                scan.odom_pose().transform(beam.point),
                scan.reference_ns(),
            );
        }
    }
    nearest_m
}

/// The older scan looked clearly beyond a point of its `laser`.
fn is_beyond(grid: &BeamGrid<'_>, past: &Past, point: Point2) -> bool {
    let range_m = point.norm_m();
    let Some(beam) = grid.beam_at(point) else {
        return false;
    };
    if beam < BESIDE || beam + BESIDE >= past.ranges_m.len() {
        return false;
    }
    let beyond_m = (range_m * (1.0 + BEYOND_SHARE) + BEYOND_M) as f32;
    past.ranges_m[beam - BESIDE..=beam + BESIDE]
        .iter()
        .all(|&free_m| free_m > beyond_m)
}

/// Beams in a row that moved.
#[derive(Default)]
struct MovedBeams {
    hits: usize,
    missed: usize,
    last: Point2,
    nearest_m: f64,
}

impl MovedBeams {
    fn miss(&mut self) {
        self.missed += 1;
        // A single missing beam does not end a run.
        if self.missed > 1 {
            self.hits = 0;
        }
    }

    /// The nearest of the run, once it is long enough.
    fn hit(&mut self, point: Point2, away_m: f64) -> Option<f64> {
        let goes_on = self.hits > 0 && self.last.distance_m(point) <= RUN_STEP_M;
        self.nearest_m = if goes_on {
            self.nearest_m.min(away_m)
        } else {
            away_m
        };
        self.hits = if goes_on { self.hits + 1 } else { 1 };
        self.missed = 0;
        self.last = point;
        (self.hits >= RUN).then_some(self.nearest_m)
    }
}

/// The highest speed from which a robot stands before something at `away_m` that comes at it arrives.
///
/// Over the delay and the braking time t = delay + v/a the thing comes nearer by its own speed times t, the robot by
/// v·delay + v²/2a. Negative when even a standing robot is met.
#[must_use]
pub fn highest_speed_m_s(
    policy: &MovingPolicy,
    away_m: f64,
    delay_s: f64,
    deceleration_m_s2: f64,
) -> f64 {
    if away_m == f64::INFINITY || policy.speed_m_s <= 0.0 {
        return f64::INFINITY;
    }
    let room_m = away_m - policy.margin_m - policy.speed_m_s * delay_s;
    if room_m <= 0.0 {
        return -1.0;
    }
    // v²/2a + v·b − room = 0
    let b_s = delay_s + policy.speed_m_s / deceleration_m_s2;
    let a = deceleration_m_s2;
    ((a * b_s).powi(2) + 2.0 * a * room_m).sqrt() - a * b_s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_rests_is_not_forgotten_when_another_passes() {
        let mut spots = [Spot::default(); SPOTS];
        let resting = Point2::new(2.0, 0.0);
        mark(&mut spots, resting, 1_000_000_000);
        for step in 0..20_u32 {
            let passing = Point2::new(1.0 + 0.1 * f64::from(step), 0.4);
            mark(
                &mut spots,
                passing,
                2_000_000_000 + 100_000_000 * u64::from(step),
            );
        }
        let known: Vec<Point2> = { spots.iter() }
            .filter(|spot| spot.moved_ns > 0)
            .map(|spot| spot.at)
            .collect();
        assert_eq!(known.len(), 2, "{known:?}");
        assert_eq!(known[0], resting);
        assert!(known[1].distance_m(Point2::new(2.9, 0.4)) < 1e-9);
    }

    #[test]
    fn a_robot_at_the_allowed_speed_stands_when_it_is_met() {
        let policy = MovingPolicy::default();
        for away_m in [0.35, 0.5, 0.8, 1.5] {
            for (delay_s, a) in [(0.1, 2.0), (0.25, 2.0), (0.2, 0.8)] {
                let v = highest_speed_m_s(&policy, away_m, delay_s, a);
                if v < 0.0 {
                    assert!(policy.speed_m_s * delay_s + policy.margin_m >= away_m);
                    continue;
                }
                let standing_s = delay_s + v / a;
                let robot_m = v * delay_s + v * v / (2.0 * a);
                let left_m = away_m - robot_m - policy.speed_m_s * standing_s;
                assert!((left_m - policy.margin_m).abs() < 1e-9, "{left_m}");
            }
        }
        let none = highest_speed_m_s(&policy, f64::INFINITY, 0.2, 2.0);
        assert_eq!(none, f64::INFINITY);
    }
}
