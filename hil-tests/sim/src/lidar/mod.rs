//! A simulated Hokuyo URG-04LX on a pseudo-terminal: SCIP 1.1 and 2.0, byte for byte.
//!
//! [`Device`] is the sensor's firmware as a pure state machine: bytes and turns in, bytes out. [`Line`] is its serial
//! line, which has a bit rate; [`Sensor`] is both at work, turning. [`LidarServer`] runs it on a pty, where any program that
//! expects a serial port finds it: it works at the device's bit rate and at no other. What it measures comes from a
//! [`RangeSource`].
//!
//! ```
//! use sim::lidar::{Device, DeviceOptions};
//!
//! let mut sensor = Device::new(DeviceOptions::default(), 0);
//! let mut sent = Vec::new();
//! sensor.receive(b"SCIP2.0\n", 0, &mut sent);
//! assert_eq!(sent[0].bytes, b"SCIP2.0\n0\n\n");
//! ```

mod codec;
mod command;
mod device;
mod disturbance;
mod faults;
mod line;
mod measurement;
mod pty;
mod reports;
mod sensor;
mod server;

pub use crate::range_source::RangeSource;
pub use codec::{checksum, encode};
pub use device::{BIT_RATES, Device, DeviceOptions, Emission, Kind, Protocol};
pub use disturbance::Disturbance;
pub use faults::{Counters, FaultHandle};
pub use line::Line;
pub use sensor::Sensor;
pub use server::{LidarError, LidarOptions, LidarServer};
