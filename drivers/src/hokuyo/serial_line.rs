//! The serial line to a lidar, whatever carries its bytes.

use std::fmt::Debug;
use std::io;
use std::sync::Arc;

use crate::clock::{Clock, Monotonic};

/// The line is gone: unplugged, or its other end closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gone;

/// What waiting ended with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wait {
    /// There are bytes.
    Ready,
    /// The deadline passed.
    TimedOut,
}

/// An open serial line: 8 data bits, no parity, 1 stop bit, no flow control, for this program alone.
///
/// # Real-time contract
/// Implementations do not allocate, lock or log in [`wait`](SerialLine::wait) and [`read`](SerialLine::read), and make no
/// system call but those of their own device.
pub trait SerialLine: Debug + Send {
    /// Sets the bit rate.
    ///
    /// # Errors
    /// The system's, for instance when the line does not have this rate.
    fn set_bit_rate(&mut self, bit_rate: u32) -> io::Result<()>;

    /// Throws away what has come in and what has not gone out.
    fn clear(&mut self);

    /// Waits for bytes until `deadline_ns` of its [`clock`](SerialLine::clock); looks once even when it has passed.
    ///
    /// # Errors
    /// [`Gone`].
    fn wait(&mut self, deadline_ns: u64) -> Result<Wait, Gone>;

    /// Reads what is there; 0 when nothing is.
    ///
    /// # Errors
    /// [`Gone`].
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Gone>;

    /// Writes all of `bytes`; false when the deadline passed first.
    ///
    /// # Errors
    /// [`Gone`].
    fn write(&mut self, bytes: &[u8], deadline_ns: u64) -> Result<bool, Gone>;

    /// Bytes written that have not left yet.
    fn unsent_bytes(&self) -> u32;

    /// The clock of its deadlines: `CLOCK_BOOTTIME`, unless the device is simulated on another.
    fn clock(&self) -> Arc<dyn Clock> {
        Arc::new(Monotonic)
    }
}
