//! The KELO drive: two hub motors on a freely rotating pivot, one EtherCAT SubDevice.
//!
//! [`Outputs`] and [`Inputs`] are the process data, field by field; [`Setpoint`] and [`Feedback`] are the same in the
//! robot's terms: left and right wheel, positive forward. [`Faults`] judges what the drive reports, [`WheelEncoder`] gives angles
//! the resolution that 32-bit floats lose.
//!
//! # Signs
//! Motor 1 is the right wheel and mirrored: driving forward it turns negative. Motor 2 is the left wheel. The pivot is
//! positive to the left. The mapping lives in `setpoint.rs` and `feedback.rs` and nowhere else.
//!
//! # Real-time contract
//! Nothing here allocates, locks or makes system calls. No input makes it panic.

mod drive;
mod encoder;
mod faults;
mod feedback;
mod inputs;
mod outputs;
mod setpoint;

pub use drive::{
    INPUTS_BYTES, MAX_WHEEL_SPEED_RAD_S, MIN_WHEEL_SPEED_RAD_S, OUTPUTS_BYTES, PRODUCT_CODES,
};
pub use encoder::{EncoderContradiction, Measured, WheelEncoder};
pub use faults::{Faults, StampWatch, VoltageLimits};
pub use feedback::Feedback;
pub use inputs::{Imu, Inputs, MotorInputs, Status};
pub use outputs::{CommandWord, Mode, Outputs};
pub use setpoint::{Setpoint, SetpointLimits};
