//! Which floor out of view is known to be free, so that the robot may swing its tail over it, or drive backwards.
//!
//! Nothing remembered beside or behind the robot may also mean that it never looked there. So floor counts as known only
//! where a scan saw it free, or the robot's own body has stood, within the last few metres of driving. It is kept on a grid in the odometry frame; what a newer scan sees occupied is unknown again, and so is
//! everything after a jump of the odometry.
//!
//! The floor beside a robot where it was put down was checked by the person who did so: it is *assumed* free for tubes
//! ahead, which could not begin to turn otherwise, but not for tubes backwards.
//!
//! What has come in behind the robot since is not known: keep `floor_memory_m` short where others drive.
//!
//! All memory is taken at construction; [`Floor::observe`] takes a time that does not depend on what is seen.

use super::cell::{ASSUMED, Cell, place};
use super::checkpoint::{FloorCheckpoint, MOST_AGE, SIDE};
use super::grid::NearGrid;
use super::known::KnownRanges;
use crate::direction::{behind_cos, direction_rad, floor, wrapped};
use crate::scan::{AlignedScan, ScanGeometry};
use description::geometry::{Footprint, Point2, Pose2};

/// A pose beyond this is refused as nonsense.
const FARTHEST_M: f64 = 1e6;
/// Cells count millimetres of 32 bits. After so long a way all is forgotten, and they begin anew.
const LONGEST_M: f64 = 4e6;

/// Cells of a row that a checkpoint skips at once where none of them is known.
const STRETCH: usize = 8;

/// How much wider than the robot the floor is, at each side, that somebody says is free: what a tube straight back asks about.
const ASIDE_M: f64 = 0.2;

/// Floor that was seen free.
#[derive(Clone, Debug)]
pub struct Floor {
    cells: Box<[Cell]>,
    /// When the newest cell of each stretch of cells was marked, as in [`Cell`].
    marked_mm: Box<[u32]>,
    grid: NearGrid,
    footprint: Footprint,
    geometry: ScanGeometry,
    /// The smallest free range of three neighbouring beams.
    narrowed_m: Box<[f32]>,
    /// Cells of the near grid that some tube asks about, and their middles.
    asked: Box<[(u32, Point2)]>,
    /// Words of the near grid; set where the floor is not known, and where it is not even assumed.
    unknown: Box<[u64]>,
    unassumed: Box<[u64]>,
    kept_mm: u32,
    /// How a checkpoint writes ages down, for every millimetre that a cell is kept.
    age_codes: Box<[u8]>,
    driven_m: f64,
    pose: Option<Pose2>,
    /// Whoever put the robot where it begins has seen what is beside it.
    assumes: bool,
    /// Somebody sees that it is free so far behind the robot; taken in with the next scan.
    trusted_m: f64,
}

impl Floor {
    /// Nothing known. `mask` has the cells of the grid that are asked about; without any it does nothing.
    #[must_use]
    pub fn new(
        grid: NearGrid,
        footprint: Footprint,
        geometry: ScanGeometry,
        mask: &[u64],
        kept_m: f64,
    ) -> Self {
        let is_set = |cell: &usize| {
            mask.get(cell / 64)
                .is_some_and(|w| w >> (cell % 64) & 1 != 0)
        };
        let asked: Box<[(u32, Point2)]> = (0..grid.cells())
            .filter(is_set)
            .map(|cell| (cell as u32, grid.centre(cell)))
            .collect();
        let (cells, beams) = if asked.is_empty() {
            (0, 0)
        } else {
            (SIDE * SIDE, geometry.beams)
        };
        let kept_mm = (kept_m.max(0.0) * 1e3) as u32;
        let unit_mm = age_unit_mm(kept_mm);
        // No younger than it is.
        let age_code = |age_mm: u32| 2 * (age_mm.div_ceil(unit_mm) as u8 + 1);
        Self {
            cells: vec![Cell::default(); cells].into_boxed_slice(),
            marked_mm: vec![0; cells / STRETCH].into_boxed_slice(),
            grid,
            footprint,
            geometry,
            narrowed_m: vec![0.0; beams].into_boxed_slice(),
            asked,
            unknown: vec![u64::MAX; grid.words()].into_boxed_slice(),
            unassumed: vec![u64::MAX; grid.words()].into_boxed_slice(),
            kept_mm,
            age_codes: (0..=kept_mm).map(age_code).collect(),
            driven_m: 0.0,
            pose: None,
            assumes: true,
            trusted_m: 0.0,
        }
    }

    /// Nobody has put the robot where it begins: of the floor beside it nothing is assumed.
    pub fn assume_nothing(&mut self) {
        self.assumes = false;
    }

    /// Somebody who looks sees that the floor beside the robot and straight behind it is free, so many metres from its rear
    /// and half a metre farther than it is wide at each side. It counts as seen, as far as the memory reaches, from the next
    /// scan on, but where that scan sees something.
    pub fn trust_behind(&mut self, way_m: f64) {
        self.trusted_m = if way_m.is_finite() {
            way_m.max(0.0)
        } else {
            0.0
        };
    }

    /// Bits of the near grid about the robot at the newest scan: the floor there is not known to be free.
    #[must_use]
    pub fn unknown(&self) -> &[u64] {
        &self.unknown
    }

    /// The same, where it is not even assumed.
    #[must_use]
    pub fn unassumed(&self) -> &[u64] {
        &self.unassumed
    }

    /// Forgets everything, as when the odometry frame jumps.
    pub fn clear(&mut self) {
        self.cells.fill(Cell::default());
        self.marked_mm.fill(0);
        self.unknown.fill(u64::MAX);
        self.unassumed.fill(u64::MAX);
        (self.pose, self.assumes) = (None, true);
        self.trusted_m = 0.0;
    }

    /// Writes down what is known around the robot; `false`: nothing is.
    pub fn save(&self, into: &mut FloorCheckpoint) -> bool {
        let Some(pose) = self.pose.filter(|_| !self.asked.is_empty()) else {
            return false;
        };
        let first = self.window(pose);
        let now_mm = self.now_mm();
        into.free.as_flattened_mut().fill(0);
        // The floor that is known is a trail: most stretches are empty.
        let stretches = self.cells.chunks_exact(STRETCH).zip(&self.marked_mm);
        for (cells, _) in stretches.filter(|&(_, at_mm)| now_mm - *at_mm <= self.kept_mm) {
            for cell in cells {
                let age_mm = now_mm - (cell.at_mm & !ASSUMED);
                let Some(&code) = self.age_codes.get(age_mm as usize) else {
                    continue;
                };
                let column = usize::from(cell.column.wrapping_sub(first[0] as i16) as u16);
                let row = usize::from(cell.row.wrapping_sub(first[1] as i16) as u16);
                let inside = column < SIDE && row < SIDE && cell.at_mm != 0;
                if inside {
                    into.free[row][column] = code + (cell.at_mm & ASSUMED) as u8;
                }
            }
        }
        (into.pose, into.cell_m, into.first) = (pose, self.grid.cell_m(), first);
        true
    }

    /// Knows what was known to another one; `false`: that one was of another kind, and nothing changes.
    pub fn resume(&mut self, from: &FloorCheckpoint) -> bool {
        let same = from.cell_m == self.grid.cell_m() && from.pose.is_finite();
        if self.asked.is_empty() || !same || from.first != self.window(from.pose) {
            return false;
        }
        self.clear();
        // Nothing is older than the way driven.
        self.driven_m += 2e-3 * f64::from(self.kept_mm) + 1.0;
        let (now_mm, unit_mm) = (self.now_mm(), age_unit_mm(self.kept_mm));
        for (row, cells) in (from.first[1]..).zip(&from.free) {
            for (column, &known) in (from.first[0]..).zip(cells) {
                if known >= 2 {
                    let at_mm = now_mm - unit_mm * u32::from(known / 2 - 1);
                    let at_mm = (at_mm & !ASSUMED) | u32::from(known) & ASSUMED;
                    self.mark(column, row, at_mm);
                }
            }
        }
        self.pose = Some(from.pose);
        true
    }

    /// Column and row of the first of the cells around a pose.
    fn window(&self, pose: Pose2) -> [i64; 2] {
        [pose.x_m, pose.y_m].map(|at_m| {
            let own = (at_m / self.grid.cell_m()).floor() as i64;
            own - SIDE as i64 / 2
        })
    }

    /// Takes what a scan says of the floor about the robot.
    pub fn observe(&mut self, scan: &AlignedScan, known: &KnownRanges) {
        let pose = scan.odom_pose();
        if self.asked.is_empty() {
            return;
        }
        if !(pose.x_m.abs() < FARTHEST_M && pose.y_m.abs() < FARTHEST_M) {
            self.clear();
            return;
        }
        if let Some(before) = self.pose {
            self.driven_m += before.position().distance_m(pose.position());
        }
        if self.driven_m > LONGEST_M {
            self.clear();
            (self.driven_m, self.assumes) = (0.0, false);
        }
        let begins = self.pose.is_none();
        self.pose = Some(pose);
        self.narrow(known);
        if begins && self.assumes {
            self.assume(pose);
        }
        let trusted_m = std::mem::take(&mut self.trusted_m);
        if trusted_m > 0.0 {
            self.trust(pose, trusted_m);
        }
        self.look(pose);
        self.ask(pose);
    }

    /// Of neighbouring beams the shortest: a thing between two of them hides from neither.
    fn narrow(&mut self, known: &KnownRanges) {
        let ranges_m = &known.as_array()[..self.geometry.beams];
        for (narrow_m, three) in self.narrowed_m[1..].iter_mut().zip(ranges_m.windows(3)) {
            *narrow_m = three[0].min(three[1]).min(three[2]);
        }
    }

    /// Marks the cells beside and behind the robot as assumed.
    fn assume(&mut self, pose: Pose2) {
        let at_mm = self.now_mm() | ASSUMED;
        let (cell_m, half_m) = (self.grid.cell_m(), self.grid.half_m());
        let count = (2.0 * half_m / cell_m) as i64 + 1;
        let corner = |at_m: f64| ((at_m - half_m) / cell_m).floor() as i64;
        for row in (corner(pose.y_m)..).take(count as usize) {
            for column in (corner(pose.x_m)..).take(count as usize) {
                let at = Point2::new(column as f64 + 0.5, row as f64 + 0.5) * cell_m;
                if pose.inverse_transform(at).x_m <= self.footprint.front_m {
                    self.mark(column, row, at_mm);
                }
            }
        }
    }

    /// Marks the cells that somebody says are free.
    fn trust(&mut self, pose: Pose2, way_m: f64) {
        let now_mm = self.now_mm();
        let cell_m = self.grid.cell_m();
        let (outline, first) = (self.footprint, self.window(pose));
        let side = SIDE as i64;
        for row in (first[1]..).take(side as usize) {
            for column in (first[0]..).take(side as usize) {
                let at = Point2::new(column as f64 + 0.5, row as f64 + 0.5) * cell_m;
                let at = pose.inverse_transform(at);
                let along = at.x_m <= outline.front_m && at.x_m >= -(outline.rear_m + way_m);
                let beside =
                    at.y_m <= outline.left_m + ASIDE_M && at.y_m >= -(outline.right_m + ASIDE_M);
                if along && beside {
                    self.mark(column, row, now_mm);
                }
            }
        }
    }

    /// Marks the cells about the robot that are seen free or stood upon, and unmarks those that are seen occupied.
    fn look(&mut self, pose: Pose2) {
        let (cell_m, half_m) = (self.grid.cell_m(), self.grid.half_m());
        let now_mm = self.now_mm();
        let count = (2.0 * half_m / cell_m) as i64 + 1;
        let corner = |at_m: f64| ((at_m - half_m) / cell_m).floor() as i64;
        let (column_0, row_0) = (corner(pose.x_m), corner(pose.y_m));
        let (sin, cos) = pose.theta_rad.sin_cos();
        let (mount_sin, mount_cos) = self.geometry.mount.theta_rad.sin_cos();
        let mount = self.geometry.mount.position();
        let half = (self.geometry.beams - 1) as f32 / 2.0;
        let middle_rad =
            self.geometry.angle_first_rad as f32 + self.geometry.angle_step_rad as f32 * half;
        let per_rad = 1.0 / self.geometry.angle_step_rad as f32;
        let last = self.geometry.beams as f32 - 2.0;
        let margin_m = cell_m as f32 / 2.0;
        let view_rad = middle_rad.abs() + half * self.geometry.angle_step_rad as f32;
        let behind = behind_cos(view_rad);
        for row in (row_0..).take(count as usize) {
            let y_m = (row as f64 + 0.5) * cell_m - pose.y_m;
            for column in (column_0..).take(count as usize) {
                let x_m = (column as f64 + 0.5) * cell_m - pose.x_m;
                let in_base = Point2::new(cos * x_m + sin * y_m, cos * y_m - sin * x_m);
                if self.footprint.contains(in_base) {
                    self.mark(column, row, now_mm);
                    continue;
                }
                let off = in_base - mount;
                let ahead_m = (mount_cos * off.x_m + mount_sin * off.y_m) as f32;
                let aside_m = (mount_cos * off.y_m - mount_sin * off.x_m) as f32;
                let range_m = (ahead_m * ahead_m + aside_m * aside_m).sqrt();
                if ahead_m < behind * range_m {
                    continue;
                }
                let beam = wrapped(direction_rad(aside_m, ahead_m) - middle_rad) * per_rad + half;
                if !(beam >= 1.0 && beam < last) || f64::from(range_m) < self.geometry.range_min_m {
                    continue;
                }
                let free_m = self.narrowed_m[(beam + 0.5) as usize];
                if free_m > range_m + margin_m {
                    self.mark(column, row, now_mm);
                } else if free_m > range_m - 2.0 * margin_m {
                    let cell = &mut self.cells[place(column, row)];
                    if cell.stands_for(column, row) {
                        cell.at_mm = 0;
                    }
                }
            }
        }
    }

    fn mark(&mut self, column: i64, row: i64, at_mm: u32) {
        let place = place(column, row);
        self.cells[place] = Cell::new(column, row, at_mm);
        let marked_mm = &mut self.marked_mm[place / STRETCH];
        *marked_mm = (at_mm & !ASSUMED).max(*marked_mm);
    }

    /// Brings what is known to where the robot is.
    fn ask(&mut self, pose: Pose2) {
        let per_cell_1_m = 1.0 / self.grid.cell_m();
        let now_mm = self.now_mm();
        let (sin, cos) = pose.theta_rad.sin_cos();
        for &(asked, centre) in &self.asked {
            // Between the middles of four cells: all of them must be known.
            let column = (pose.x_m + cos * centre.x_m - sin * centre.y_m) * per_cell_1_m - 0.5;
            let row = (pose.y_m + sin * centre.x_m + cos * centre.y_m) * per_cell_1_m - 0.5;
            let (column, row) = (floor(column), floor(row));
            let around = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, up)| {
                let (column, row) = (column + right, row + up);
                let cell = &self.cells[place(column, row)];
                let is_kept = cell.at_mm > ASSUMED
                    && cell.stands_for(column, row)
                    && now_mm - (cell.at_mm & !ASSUMED) <= self.kept_mm;
                (is_kept, is_kept && cell.at_mm & ASSUMED == 0)
            });
            let bit = 1 << (asked % 64);
            let word = asked as usize / 64;
            set(
                &mut self.unassumed[word],
                bit,
                !around.iter().all(|cell| cell.0),
            );
            set(
                &mut self.unknown[word],
                bit,
                !around.iter().all(|cell| cell.1),
            );
        }
    }

    /// Even, and never 0.
    fn now_mm(&self) -> u32 {
        (2 + (self.driven_m * 1e3) as u32) & !ASSUMED
    }
}

/// In which the age of a cell fits into seven bits.
fn age_unit_mm(kept_mm: u32) -> u32 {
    kept_mm.div_ceil(MOST_AGE).max(1)
}

fn set(word: &mut u64, bit: u64, on: bool) {
    *word = if on { *word | bit } else { *word & !bit };
}
