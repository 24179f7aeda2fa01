//! Figures of the drive: codes, sizes, speeds.

/// Product codes of the drives that speak this process data.
pub const PRODUCT_CODES: [u32; 3] = [0x0170_5011, 0x1701_0091, 0x0200_1001];

/// Size of the process data to the drive.
pub const OUTPUTS_BYTES: usize = 36;

/// Size of the process data from the drive.
pub const INPUTS_BYTES: usize = 172;

/// Highest wheel speed that may be commanded.
pub const MAX_WHEEL_SPEED_RAD_S: f32 = 35.0;

/// Wheel speeds below this count as standing still.
pub const MIN_WHEEL_SPEED_RAD_S: f32 = 0.01;
