//! What was seen beside the robot a moment ago.
//!
//! A sensor near the front with a view of 240° does not see the robot's own flanks, where every turn begins. What
//! stands there was ahead before: hits are kept for two seconds in the odometry frame, and laid on a small grid around
//! `base_link` when tubes are judged. A tube has a mask on the same grid, of its cells that the sensor does not see.
//!
//! Bounded: a ring of fixed capacity; when more comes in within the memory's time, the oldest goes and is counted.

use crate::geometry::{Point2, Pose2};
use crate::scan::AlignedScan;

/// Points that a memory holds.
pub const CAPACITY: usize = 8192;

/// A square grid of bits centred on `base_link`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearGrid {
    cell_m: f64,
    half_m: f64,
    side: usize,
}

impl NearGrid {
    /// A grid that reaches at least `half_m` to all sides.
    #[must_use]
    pub fn new(half_m: f64, cell_m: f64) -> Self {
        let half_cells = (half_m / cell_m).ceil().max(1.0) as usize;
        Self {
            cell_m,
            half_m: half_cells as f64 * cell_m,
            side: 2 * half_cells,
        }
    }

    /// Bits in 64-bit words.
    #[must_use]
    pub fn words(&self) -> usize {
        (self.side * self.side).div_ceil(64)
    }

    /// Cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.side * self.side
    }

    /// Length of a cell's side.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// The cell that a point of `base_link` lies in.
    #[must_use]
    pub fn cell(&self, point: Point2) -> Option<usize> {
        let column = ((point.x_m + self.half_m) / self.cell_m).floor();
        let row = ((point.y_m + self.half_m) / self.cell_m).floor();
        let side = self.side as f64;
        let inside = column >= 0.0 && column < side && row >= 0.0 && row < side;
        inside.then(|| row as usize * self.side + column as usize)
    }

    /// The middle of a cell.
    #[must_use]
    pub fn centre(&self, cell: usize) -> Point2 {
        let (row, column) = (cell / self.side, cell % self.side);
        let middle = |index: usize| (index as f64 + 0.5) * self.cell_m - self.half_m;
        Point2::new(middle(column), middle(row))
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Remembered {
    point: Point2,
    stamp_ns: u64,
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
}

impl Memory {
    /// An empty memory on a grid. Allocates, once.
    #[must_use]
    pub fn new(grid: NearGrid, keep_s: f64, reach_m: f64) -> Self {
        Self {
            ring: vec![Remembered::default(); CAPACITY].into_boxed_slice(),
            next: 0,
            len: 0,
            keep_ns: (keep_s.max(0.0) * 1e9) as u64,
            reach_m,
            spacing_m: grid.cell_m / 2.0,
            overwritten: 0,
            grid,
            occupied: vec![0; grid.words()].into_boxed_slice(),
        }
    }

    /// Takes the hits of a scan that are near enough to matter, thinned to half a cell.
    pub fn remember(&mut self, scan: &AlignedScan) {
        let pose = scan.odom_pose();
        let stamp_ns = scan.reference_ns();
        let mut previous: Option<Point2> = None;
        for hit in scan.hits() {
            if hit.norm_m() > self.reach_m
                || previous.is_some_and(|previous| previous.distance_m(hit) < self.spacing_m)
            {
                continue;
            }
            previous = Some(hit);
            if self.len == self.ring.len()
                && stamp_ns.saturating_sub(self.ring[self.next].stamp_ns) <= self.keep_ns
            {
                self.overwritten += 1;
            }
            self.ring[self.next] = Remembered {
                point: pose.transform(hit),
                stamp_ns,
            };
            self.next = (self.next + 1) % self.ring.len();
            self.len = (self.len + 1).min(self.ring.len());
        }
    }

    /// Lays what is remembered on the grid around `base_link` at `pose`.
    pub fn project(&mut self, pose: Pose2, now_ns: u64) {
        self.occupied.fill(0);
        let (sin, cos) = pose.theta_rad.sin_cos();
        let capacity = self.ring.len();
        let mut expired = 0;
        for age in (0..self.len).rev() {
            let remembered = self.ring[(self.next + capacity - 1 - age) % capacity];
            if now_ns.saturating_sub(remembered.stamp_ns) > self.keep_ns {
                expired = self.len - age;
                continue;
            }
            let delta = remembered.point - pose.position();
            let point = Point2::new(
                cos * delta.x_m + sin * delta.y_m,
                cos * delta.y_m - sin * delta.x_m,
            );
            if let Some(cell) = self.grid.cell(point) {
                self.occupied[cell / 64] |= 1 << (cell % 64);
            }
        }
        self.len -= expired;
    }

    /// The occupied cells of the last projection.
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
        self.occupied.fill(0);
    }
}
