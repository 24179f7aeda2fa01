//! What is remembered of the floor around the robot, as plain data: for another process, of the same robot, to go on with.

use description::geometry::Pose2;

/// Cells of a side of the window around the robot.
pub const WINDOW: usize = 64;
/// Words of the cells about the robot in which something was seen.
pub(super) const OCCUPIED_WORDS: usize = WINDOW * WINDOW / 64;

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
    /// Side of a cell; 0 when nothing is remembered, or the robot is too large for the window.
    pub cell_m: f64,
    /// Column and row of the window's first cell.
    pub(super) first: [i64; 2],
    /// 0: not known to be free. Otherwise for how many centimetres of driving it has been, plus 1, times 2; one more when
    /// that was only assumed.
    #[cfg_attr(feature = "symbols", serde(skip))]
    pub(super) free: [[u16; WINDOW]; WINDOW],
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
            free: [[0; WINDOW]; WINDOW],
            occupied: [0; OCCUPIED_WORDS],
        }
    }
}

#[cfg(feature = "symbols")]
coordination::datatype!(FloorCheckpoint, "floor");
