//! What is remembered of the floor around the robot, as plain data: for another process, of the same robot, to go on with.

use description::geometry::Pose2;

/// Cells of one side of the floor that is kept; a power of two.
pub(super) const SIDE: usize = 128;
/// The oldest age of a cell.
pub(super) const MOST_AGE: u32 = 126;
/// Words of the cells about the robot in which something was seen.
const OCCUPIED_WORDS: usize = SIDE * SIDE / 64;

/// Floor around the robot at one scan, in `odom`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "symbols",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
pub struct FloorCheckpoint {
    /// `base_link` in `odom` at the newest scan.
    #[cfg_attr(feature = "symbols", serde(flatten))]
    pub pose: Pose2,
    /// Side of a cell; 0 when nothing is remembered.
    pub cell_m: f64,
    /// Column and row of the first cell.
    pub(super) first: [i64; 2],
    /// 0: not known to be free. Otherwise for which way of driving it has been, in parts of the longest one that counts, plus
    /// 1, times 2; one more when that was only assumed.
    #[cfg_attr(feature = "symbols", serde(skip))]
    pub(super) free: [[u8; SIDE]; SIDE],
    /// Bits of the near grid in which something was seen.
    #[cfg_attr(feature = "symbols", serde(skip))]
    pub(super) occupied: [u64; OCCUPIED_WORDS],
}

impl Default for FloorCheckpoint {
    fn default() -> Self {
        Self {
            pose: Pose2::IDENTITY,
            cell_m: 0.0,
            first: [0; 2],
            free: [[0; SIDE]; SIDE],
            occupied: [0; OCCUPIED_WORDS],
        }
    }
}

#[cfg(feature = "symbols")]
coordination::datatype!(FloorCheckpoint, "floor", description::SYMBOLS);
