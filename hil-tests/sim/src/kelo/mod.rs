//! A KELO drive: two hub motors on a freely turning pivot, as one EtherCAT SubDevice.
//!
//! Turns process data into a [`DriveCommand`](crate::plant::DriveCommand) and the plant's answer into process data.
//! Motor 1 is the right wheel with its sign inverted, motor 2 the left wheel. Motors have power only in OP, while
//! outputs are written, the motor is enabled, no emergency bit is set, the supply is in range and the motor has no
//! fault.
//!
//! Known from the vendor: process data layout, command and status bits, healthy status values. Assumed here: the
//! vendor id, the supply range, the motors' electrical values, and the sign of the differential modes (a positive
//! difference speeds up the right wheel).

mod demand;
mod drive;
mod handle;
mod injected;
pub mod pdo;
mod sensors;
#[cfg(test)]
mod tests;

pub use demand::MAX_WHEEL_RAD_S;
pub use drive::{Kelo, KeloOptions, PRODUCT_CODE, SimulatedDrive, VENDOR_ID};
pub use handle::{DriveHandle, DriveStatistics, Extremes};
