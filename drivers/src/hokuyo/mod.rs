//! The Hokuyo URG-04LX laser scanner, over a serial line that speaks SCIP 2.0.
//!
//! - [`Hokuyo::connect`] finds the device at any bit rate and in any state, and starts a stream of scans. It takes
//!   time, allocates, and ends within [`Options::connect_timeout`].
//! - [`Hokuyo::read_scan`] is real-time: it waits with `poll`, reads, and parses, without allocation, until a scan is
//!   there or its deadline passes.
//! - After [`ReadError::Disconnected`] or [`ReadError::Untrusted`], or when scans stay away, drop the driver and connect
//!   again.
//!
//! [`Hokuyo::connect_over`] does the same over any [`SerialLine`]; [`TtyLine`] is the one of a robot.
//!
//! # Time
//! The device stamps a scan with its own clock when a turn starts, at step 0. [`Scan::stamp_ns`] is that moment on
//! the line's clock plus the time the sensor needs to turn to the first reading: the time of **the first beam**. Beam
//! `i` was taken `i ×` [`Hokuyo::beam_period`] later. Right to about 1 ms after the connection, and to a few
//! milliseconds while the clocks drift apart. A delay that changes by more than clocks drift ends the connection; one that
//! grows by less than 200 ppm (0.2 ms/s) cannot be told from drift.
//!
//! # Readings
//! Millimetres from 20 on. Smaller ones are codes and stay distinct: 0 is nothing in sight, the others say why the
//! device could not measure; see [`Reading`].
//!
//! ```no_run
//! use drivers::hokuyo::{Hokuyo, Options, ReadError, Scan};
//! use drivers::monotonic_ns;
//!
//! let mut lidar = Hokuyo::connect("/dev/ttyACM0".as_ref(), &Options::default())?;
//! let mut scan = Scan::new();
//! loop {
//!     match lidar.read_scan(&mut scan, monotonic_ns() + 250_000_000) {
//!         Ok(_) => println!("{} beams at {} ns", scan.count, scan.stamp_ns),
//!         Err(ReadError::Disconnected | ReadError::Untrusted { .. }) => break,
//!         Err(error) => println!("{error}"),
//!     }
//! }
//! # Ok::<(), drivers::hokuyo::ConnectError>(())
//! ```

mod clock;
pub mod codec;
mod connect;
mod conversation;
mod device;
mod error;
mod identity;
mod line;
mod options;
mod parser;
mod scan;
mod serial_line;
mod tty;

pub use codec::{Encoding, Status};
pub use device::Hokuyo;
pub use error::{ConnectError, ReadError};
pub use identity::{DeviceState, Parameters, SensorIdentity};
pub use options::{Options, ScanFormat};
pub use scan::{FIRST_LENGTH_MM, LidarCounters, MAX_BEAMS, Reading, Received, Scan};
pub use serial_line::{Gone, SerialLine, Wait};
pub use tty::TtyLine;
