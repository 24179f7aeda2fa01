//! What bring-up expects, how long it may take, and what it found.

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
    /// Time without new outputs after which the SubDevice stops by itself. Written to the SubDevice and read back.
    pub watchdog_ms: u32,
}

/// How long bring-up may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BringUpOptions {
    /// Limit for the whole bring-up. A SubDevice with a slow SII needs one to two seconds.
    pub timeout: Duration,
    /// A frame is sent again when it stays unanswered for this long.
    pub frame_timeout: Duration,
    /// Attempts for one frame before the segment counts as absent.
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
pub struct FoundSubDevice {
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
    /// It still had the station address of an earlier bring-up: its controller has had power ever since.
    pub had_address: bool,
}
