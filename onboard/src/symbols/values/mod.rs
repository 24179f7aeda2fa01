//! The values in the symbol table: plain data, one owner each. Frames and units are in the names (REP 103, 105).
//!
//! Numbers are `f64` and counters `u64` throughout, so that no structure has padding. What the skills compute with lies in
//! the table as the skills define it. `onboard inspect` shows each as it serializes.

#[macro_use]
mod value;

mod devices;
mod motion;
mod pose;
mod robot;
mod text;

pub use devices::{DriveStatus, Encoders, LidarStatus, MAX_STEPS, RangeScan, WheelSetpoints};
pub use motion::{OdometryTrace, SafeCommand, TRACE_SAMPLES, TeleopWish, TubeState, WantedMotion};
pub use pose::{NavigationState, PoseEstimate, Whereabouts};
pub use robot::{ActivityState, FleetState, Load, Mode, RobotMode, ThreadReport};
pub use text::{Line, Name};
