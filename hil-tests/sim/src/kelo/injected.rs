//! Faults of the drive itself that are injected now.

/// What is injected.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Injected {
    pub bus_voltage_v: Option<f64>,
    pub status1_set: u16,
    pub status1_cleared: u16,
    pub status2: Option<u16>,
    pub emergency_stop: bool,
    pub sensors_frozen: bool,
    pub encoders_ahead_rad: f64,
    /// Of the left and of the right wheel, and of the pivot.
    pub encoder_stuck: [bool; 3],
}
