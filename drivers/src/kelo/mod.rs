//! The KELO drive: two hub motors on a freely rotating pivot, one EtherCAT SubDevice.
//!
//! [`Outputs`] and [`Inputs`] are the process data, field by field; [`Setpoint`] and [`Feedback`] are the same in the
//! robot's terms: left and right wheel, positive forward. [`Faults`] judges what the drive reports.
//!
//! # Signs
//! Motor 1 is the right wheel and mirrored: driving forward it turns negative. Motor 2 is the left wheel. The pivot is
//! positive to the left. The mapping lives in `setpoint.rs` and `feedback.rs` and nowhere else.
//!
//! # Real-time contract
//! Nothing here allocates, locks or makes system calls. No input makes it panic.

mod faults;
mod feedback;
mod inputs;
mod outputs;
mod setpoint;

pub use faults::{Faults, StampWatch, VoltageLimits};
pub use feedback::Feedback;
pub use inputs::{Imu, Inputs, MotorInputs, Status};
pub use outputs::{Command, Mode, Outputs};
pub use setpoint::{Setpoint, SetpointLimits};

/// Product codes of the drives that speak this process data.
pub const PRODUCT_CODES: [u32; 3] = [0x0170_5011, 0x1701_0091, 0x0200_1001];

/// Size of the process data to the drive.
pub const OUTPUTS_BYTES: usize = 36;

/// Size of the process data from the drive.
pub const INPUTS_BYTES: usize = 172;

/// Faster than this no wheel is asked to turn.
pub const MAX_WHEEL_SPEED_RAD_S: f32 = 35.0;

/// Slower than this is standing still.
pub const MIN_WHEEL_SPEED_RAD_S: f32 = 0.01;
