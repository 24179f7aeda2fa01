//! The grid of cells around the robot on which what the sensor does not see now is kept.

use description::geometry::Point2;

/// A square grid of bits centred on `base_link`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearGrid {
    cell_m: f64,
    /// Cells in a metre: a point in memory is looked up at each scan, and to divide takes ten times as long.
    per_m: f64,
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
            per_m: 1.0 / cell_m,
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
        let column = (point.x_m + self.half_m) * self.per_m;
        let row = (point.y_m + self.half_m) * self.per_m;
        let side = self.side as f64;
        let inside = column >= 0.0 && column < side && row >= 0.0 && row < side;
        inside.then(|| row as usize * self.side + column as usize)
    }

    /// How far it reaches to each side.
    #[must_use]
    pub fn half_m(&self) -> f64 {
        self.half_m
    }

    /// The middle of a cell.
    #[must_use]
    pub fn centre(&self, cell: usize) -> Point2 {
        let (row, column) = (cell / self.side, cell % self.side);
        let middle = |index: usize| (index as f64 + 0.5) * self.cell_m - self.half_m;
        Point2::new(middle(column), middle(row))
    }
}
