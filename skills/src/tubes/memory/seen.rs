//! What was seen beside the robot a moment ago.
//!
//! A sensor near the front with a view of 240° does not see the robot's own flanks, where every turn begins. What
//! stands there was ahead before: hits are kept for two seconds in the odometry frame, and laid on a small grid around
//! `base_link` when tubes are judged. A tube has a mask on the same grid, of its cells that the sensor does not see.
//!
//! The two seconds are seconds of driving at the highest speed: a robot that waits or creeps does not forget what stands
//! beside it. What a newer scan looks through is forgotten at once.
//!
//! Bounded: a ring of fixed capacity; when more comes in within the memory's time, the oldest goes and is counted.

use super::checkpoint::FloorCheckpoint;
use super::grid::NearGrid;
use crate::scan::{AlignedScan, BeamGrid};
use description::geometry::{Point2, Pose2};

/// A robot that moved less between two scans counts as standing.
const STANDS_M: f64 = 0.005;
const STANDS_RAD: f64 = 0.01;
/// A beam has looked through a remembered point when it measures this much farther.
const LOOKED_THROUGH_M: f32 = 0.1;

/// Points that a memory holds.
pub const CAPACITY: usize = 8192;

#[derive(Clone, Copy, Debug, Default)]
struct Remembered {
    point: Point2,
    /// On the clock that runs while the robot drives; `None` when looked through.
    driven_ns: Option<u64>,
}

impl Remembered {
    fn is_kept(&self, now_ns: u64, keep_ns: u64) -> bool {
        self.driven_ns
            .is_some_and(|driven_ns| now_ns - driven_ns <= keep_ns)
    }
}

/// Hits of the last moments, in the odometry frame.
#[derive(Clone, Debug)]
pub struct Memory {
    ring: Box<[Remembered]>,
    next: usize,
    len: usize,
    keep_ns: u64,
    /// Farther hits cannot come beside the robot in time.
    reach_m: f64,
    spacing_m: f64,
    overwritten: u64,
    grid: NearGrid,
    occupied: Box<[u64]>,
    /// Runs while the robot drives, no faster than the highest speed.
    driven_ns: u64,
    fastest_m_s: f64,
    /// The pose that driving is measured from, and its time.
    newest: Option<(u64, Pose2)>,
}

impl Memory {
    /// An empty memory on a grid. At `fastest_m_s` its clock runs as any other, when slower the same for the same way.
    /// Allocates, once.
    #[must_use]
    pub fn new(grid: NearGrid, keep_s: f64, reach_m: f64, fastest_m_s: f64) -> Self {
        Self {
            ring: vec![Remembered::default(); CAPACITY].into_boxed_slice(),
            next: 0,
            len: 0,
            keep_ns: (keep_s.max(0.0) * 1e9) as u64,
            reach_m,
            spacing_m: grid.cell_m() / 2.0,
            overwritten: 0,
            grid,
            occupied: vec![0; grid.words()].into_boxed_slice(),
            driven_ns: 0,
            fastest_m_s,
            newest: None,
        }
    }

    /// Takes the hits of a scan that are near enough to matter, thinned to half a cell, and lays all that is
    /// remembered on the grid around where the robot was at the scan's reference time.
    pub fn observe(&mut self, scan: &AlignedScan) {
        let drives = self.advance(scan.reference_ns(), scan.odom_pose());
        self.remember(scan, drives);
        self.project(scan);
    }

    /// Runs the clock; says whether the robot drives.
    fn advance(&mut self, reference_ns: u64, pose: Pose2) -> bool {
        let Some((before_ns, from)) = self.newest else {
            self.newest = Some((reference_ns, pose));
            return true;
        };
        let moved = from.between(pose);
        let moved_m = moved.position().norm_m();
        let drives = moved_m > STANDS_M || moved.theta_rad.abs() > STANDS_RAD;
        if drives {
            let at_most_ns = reference_ns.saturating_sub(before_ns);
            let driven_ns = moved_m / self.fastest_m_s * 1e9;
            self.driven_ns += (driven_ns as u64).min(at_most_ns);
            self.newest = Some((reference_ns, pose));
        }
        drives
    }

    fn remember(&mut self, scan: &AlignedScan, drives: bool) {
        let pose = scan.odom_pose();
        let mut previous: Option<Point2> = None;
        for hit in scan.hits() {
            if hit.norm_m() > self.reach_m
                || previous.is_some_and(|previous| previous.distance_m(hit) < self.spacing_m)
            {
                continue;
            }
            previous = Some(hit);
            // The same view again and again would push out what is beside the robot.
            if !drives && !self.is_news(hit) {
                continue;
            }
            self.push(pose.transform(hit));
        }
    }

    /// Remembers a point of `odom`.
    fn push(&mut self, point: Point2) {
        let oldest = &self.ring[self.next];
        if self.len == self.ring.len() && oldest.is_kept(self.driven_ns, self.keep_ns) {
            self.overwritten += 1;
        }
        self.ring[self.next] = Remembered {
            point,
            driven_ns: Some(self.driven_ns),
        };
        self.next = (self.next + 1) % self.ring.len();
        self.len = (self.len + 1).min(self.ring.len());
    }

    /// Near, where nothing was on the newest scan.
    fn is_news(&self, hit: Point2) -> bool {
        self.grid
            .cell(hit)
            .is_some_and(|cell| !is_set(&self.occupied, cell))
    }

    fn project(&mut self, scan: &AlignedScan) {
        self.occupied.fill(0);
        let pose = scan.odom_pose();
        let (sin, cos) = pose.theta_rad.sin_cos();
        let beams = BeamsPast::of(scan);
        // The corner of the grid, and a little more than rounding takes away.
        let farthest_m2 = 2.001 * self.grid.half_m() * self.grid.half_m();
        let (driven_ns, keep_ns) = (self.driven_ns, self.keep_ns);
        let mut kept = 0;
        let (newest, before) = self.ring.split_at_mut(self.next);
        let newest_first = newest.iter_mut().rev().chain(before.iter_mut().rev());
        for (age, remembered) in newest_first.take(self.len).enumerate() {
            if !remembered.is_kept(driven_ns, keep_ns) {
                continue;
            }
            kept = age + 1;
            let delta = remembered.point - pose.position();
            if delta.dot(delta) > farthest_m2 {
                continue;
            }
            let point = Point2::new(
                cos * delta.x_m + sin * delta.y_m,
                cos * delta.y_m - sin * delta.x_m,
            );
            let Some(cell) = self.grid.cell(point) else {
                continue;
            };
            if beams.look_through(point) {
                remembered.driven_ns = None;
            } else {
                self.occupied[cell / 64] |= 1 << (cell % 64);
            }
        }
        // Everything older than the last kept entry has expired.
        self.len = kept;
    }

    /// Writes down where something is around the robot; `false`: the window is too small.
    pub fn save(&self, into: &mut FloorCheckpoint) -> bool {
        let Some(words) = into.occupied.get_mut(..self.occupied.len()) else {
            return false;
        };
        words.copy_from_slice(&self.occupied);
        true
    }

    /// Remembers what another one, on the same grid, has seen around the robot, as if it had been now.
    pub fn resume(&mut self, from: &FloorCheckpoint) {
        self.clear();
        for cell in (0..self.grid.cells()).filter(|cell| is_set(&from.occupied, *cell)) {
            self.push(from.pose.transform(self.grid.centre(cell)));
        }
    }

    /// The occupied cells around the robot at the newest scan.
    #[must_use]
    pub fn occupied(&self) -> &[u64] {
        &self.occupied
    }

    /// Points held.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Nothing is remembered.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Points that went before their time because the ring was full.
    #[must_use]
    pub fn overwritten(&self) -> u64 {
        self.overwritten
    }

    /// Forgets everything, as when the odometry frame jumps.
    pub fn clear(&mut self) {
        self.len = 0;
        self.newest = None;
        self.occupied.fill(0);
    }
}

fn is_set(words: &[u64], cell: usize) -> bool {
    words
        .get(cell / 64)
        .is_some_and(|word| word >> (cell % 64) & 1 != 0)
}

/// The beams of a scan, as points of `base_link` are compared with them.
struct BeamsPast<'a> {
    ranges_m: &'a [f32],
    grid: BeamGrid<'a>,
    sensor: Point2,
    sin: f64,
    cos: f64,
}

impl<'a> BeamsPast<'a> {
    fn of(scan: &'a AlignedScan) -> Self {
        let mount = scan.geometry().mount;
        let (sin, cos) = mount.theta_rad.sin_cos();
        Self {
            ranges_m: scan.ranges_m(),
            grid: scan.geometry().beam_grid(),
            sensor: mount.position(),
            sin,
            cos,
        }
    }

    /// The beam at a point, and those that there are beside it, measure clearly farther.
    fn look_through(&self, point: Point2) -> bool {
        let delta = point - self.sensor;
        let in_laser = Point2::new(
            self.cos * delta.x_m + self.sin * delta.y_m,
            self.cos * delta.y_m - self.sin * delta.x_m,
        );
        let range_m = in_laser.norm_m() as f32 + LOOKED_THROUGH_M;
        let Some(beam) = self.grid.beam_at(in_laser) else {
            return false;
        };
        let beside = beam.saturating_sub(1)..(beam + 2).min(self.ranges_m.len());
        self.ranges_m[beside].iter().all(|&free_m| free_m > range_m)
    }
}
