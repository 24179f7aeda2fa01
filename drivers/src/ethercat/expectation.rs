//! What bring-up is given and what it tells.

use std::time::Duration;

/// What must be found on the bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Expectation {
    /// The SubDevice's vendor id.
    pub vendor_id: u32,
    /// Its product code is one of these.
    pub product_codes: Vec<u32>,
    /// Size of the process data to the SubDevice.
    pub outputs_bytes: usize,
    /// Size of the process data from the SubDevice.
    pub inputs_bytes: usize,
    /// After this time without new outputs the SubDevice stops by itself; is set and checked.
    pub watchdog_ms: u32,
}

/// How long bring-up may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BringUpOptions {
    /// For everything. A SubDevice with a slow SII needs one to two seconds.
    pub timeout: Duration,
    /// A frame without an answer for this time is sent again.
    pub frame_timeout: Duration,
    /// How often a frame is sent before the segment is taken for absent.
    pub frame_attempts: u32,
    /// Between two process-data frames on the way to OP, and between two looks at a state.
    pub cycle: Duration,
}

impl Default for BringUpOptions {
    fn default() -> BringUpOptions {
        BringUpOptions {
            timeout: Duration::from_secs(5),
            frame_timeout: Duration::from_millis(20),
            frame_attempts: 10,
            cycle: Duration::from_millis(1),
        }
    }
}

/// What was found on the bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// The link it was found on.
    pub link: String,
    /// Station address.
    pub address: u16,
    /// Name, from the SII.
    pub name: String,
    /// Vendor id.
    pub vendor_id: u32,
    /// Product code.
    pub product_code: u32,
    /// Revision.
    pub revision: u32,
    /// Serial number.
    pub serial: u32,
}
