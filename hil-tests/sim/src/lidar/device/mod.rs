//! The sensor's firmware: SCIP 1.1 and 2.0 as a state machine without I/O and without a clock of its own.

mod firmware;
mod scip11;
mod scip20;
mod sensor;
#[cfg(test)]
mod tests;
mod types;

pub use sensor::Device;
pub use types::{BIT_RATES, DeviceOptions, Emission, Kind, Protocol};
