//! Drive: exchanges process data with the KELO drive every millisecond and guards what is sent.
//!
//! Owns the encoders and the drive's status. Whatever happens above it, it never sends a setpoint over the limit, and
//! it ramps to zero when setpoints stop coming, when the drive reports a fault, or when anything panicked.

mod activity;
mod health;
mod holding;
mod ramp;
mod returning;
mod settings;
mod wheels;

pub use activity::Drive;
pub use settings::{OpenLink, Settings};
