//! A cell of the floor that is known.

use super::checkpoint::SIDE;

/// A cell of the grid, which wraps around: which cell of the plane it stands for, and when that was known.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    pub(super) column: i16,
    pub(super) row: i16,
    /// Millimetres driven then, the last bit gone; 0 for never. The last bit says that it was only assumed.
    pub(super) at_mm: u32,
}

/// The last bit of [`Cell::at_mm`].
pub(super) const ASSUMED: u32 = 1;

impl Cell {
    pub(super) fn new(column: i64, row: i64, at_mm: u32) -> Self {
        Self {
            column: column as i16,
            row: row as i16,
            at_mm,
        }
    }

    /// Cells with the same numbers are hundreds of metres apart, farther than anything is kept.
    pub(super) fn stands_for(&self, column: i64, row: i64) -> bool {
        self.column == column as i16 && self.row == row as i16
    }
}

/// Where it is kept.
pub(super) fn place(column: i64, row: i64) -> usize {
    let side = SIDE as i64;
    (row.rem_euclid(side) * side + column.rem_euclid(side)) as usize
}
