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

    /// The cells whose middles may be so near to a point of `base_link`, and some beside them.
    pub fn around(&self, point: Point2, reach_m: f64) -> impl Iterator<Item = usize> {
        let side = self.side;
        let between = |middle_m: f64| {
            let place = |at_m: f64| (at_m + self.half_m) * self.per_m;
            let (first, last) = (place(middle_m - reach_m), place(middle_m + reach_m));
            // A number below 0 is 0 here.
            first as usize..(last as usize + 1).min(side)
        };
        let columns = between(point.x_m);
        between(point.y_m)
            .flat_map(move |row| columns.clone().map(move |column| row * side + column))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_around_a_point_are_all_that_are_near() {
        let grid = NearGrid::new(0.6, 0.025);
        for at in 0..200 {
            let at = f64::from(at);
            let point = Point2::new(0.75 * (0.7 * at).sin(), 0.75 * (1.1 * at).cos());
            let reach_m = 0.001 * at;
            let is_near = |&cell: &usize| grid.centre(cell).distance_m(point) <= reach_m;
            let near: Vec<usize> = (0..grid.cells()).filter(is_near).collect();
            let around: Vec<usize> = grid.around(point, reach_m).filter(is_near).collect();
            assert_eq!(around, near, "{point:?}");
        }
    }
}
