//! What the drive activity needs to know of the bus and the drive on it.

use drivers::ethercat::{BringUpOptions, Expectation, Link};
use drivers::kelo::VoltageLimits;

use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS};

/// Pause between two attempts to bring the bus up.
pub(super) const RETRY_NS: u64 = 500 * MILLISECOND_NS;

/// A drive that was gone for longer, from its last answer until it is up again, waits for an operator.
pub(super) const GONE_NS: u64 = SECOND_NS;

/// How long a drive may take to leave OP when the program ends.
pub(super) const SHUT_DOWN_NS: u64 = 100 * MILLISECOND_NS;

/// What the drive activity needs to know.
#[derive(Clone, Debug)]
pub struct Settings {
    /// What the bus must look like.
    pub expectation: Expectation,
    /// How the bus is brought up.
    pub bring_up: BringUpOptions,
    /// Time that an answer may take, from the cycle's start.
    pub deadline_ns: u64,
    /// Age at which a setpoint is stale.
    pub setpoint_timeout_ns: u64,
    /// How long lost frames are tolerated.
    pub hold_ns: u64,
    /// Bring-ups in a minute before an operator is needed.
    pub bring_ups_per_minute: usize,
    /// One that was not there when the program started afresh, and takes longer to come, waits for an operator.
    pub awaited_ns: u64,
    /// Fastest wheel speed that may ever be sent.
    pub max_wheel_speed_rad_s: f64,
    /// Wheel deceleration of a stop.
    pub stop_deceleration_rad_s2: f64,
    /// Current limit while driving.
    pub drive_current_a: f32,
    /// Current limit while standing.
    pub stop_current_a: f32,
    /// How far a wheel may turn beyond what it was told.
    pub obedience_rad: f64,
    /// Whether the drive is to stop by itself when its wheels do not obey.
    pub emergency_bits: bool,
    /// Within these the bus voltage is good.
    pub voltage: VoltageLimits,
    /// Pivot encoder when the unit points forward.
    pub pivot_zero_rad: f64,
}

/// Opens the link to the bus; called again after each loss.
pub type OpenLink = Box<dyn Fn() -> Result<Box<dyn Link>, String> + Send>;
