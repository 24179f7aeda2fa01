//! What the devices say, and what the drive is told.

use description::wheels::{EncoderAngles, WheelSpeeds};
use serde::{Serialize, Serializer};

/// Longest scan in the table, in steps.
pub const MAX_STEPS: usize = 768;

value! {
    /// Wheel and pivot encoders of the drive, wheel-forward-positive, pivot positive to the left.
    Encoders, "encoders" {
        /// Angles.
        #[serde(flatten)]
        angles: EncoderAngles,
        /// Speeds of the wheels.
        #[serde(flatten)]
        speeds: WheelSpeeds,
        /// Pivot speed.
        pivot_rad_s: f64,
        /// How often the encoders were found to have begun anew, as after a loss of power; 0 while they count on from before
        /// this process.
        epoch: u64,
    }
}

value! {
    /// State of the bus and of the drive on it.
    DriveStatus, "drive_status" {
        /// 1 while process data is exchanged in OP.
        operational: u64,
        /// 1 while the drive does what the wheel setpoints say.
        follows: u64,
        /// Exchanges since start.
        cycles: u64,
        /// Frames that were not answered in time.
        lost_frames: u64,
        /// Answers with a wrong working counter.
        wkc_errors: u64,
        /// How often the bus was brought up.
        bring_ups: u64,
        /// status1 of the drive in the low half, status2 in the high half.
        status: u64,
        /// Bus voltage.
        bus_voltage_v: f64,
        /// Input current.
        input_current_a: f64,
        /// The last left setpoint that was sent.
        sent_left_rad_s: f64,
        /// The last right setpoint that was sent.
        sent_right_rad_s: f64,
    }
}

value! {
    /// Wheel speeds that the drive is to keep, wheel-forward-positive.
    WheelSetpoints, "wheel_setpoints" {
        /// Of both wheels.
        #[serde(flatten)]
        speeds: WheelSpeeds,
    }
}

value! {
    /// One scan as the sensor gave it, in the steps of the device.
    RangeScan, "range_scan" {
        /// Counts scans.
        sequence: u64,
        /// Number of valid entries.
        count: u64,
        /// Range of each step; below 20 an error code of SCIP 2.0.
        #[serde(serialize_with = "all")]
        ranges_mm: [u16; MAX_STEPS],
    }
}

value! {
    /// State of the lidar.
    LidarStatus, "lidar_status" {
        /// 1 while it streams.
        streaming: u64,
        /// Good scans.
        scans: u64,
        /// Scans dropped as broken, or replaced by an error of the device.
        dropped: u64,
        /// How often it was connected.
        connections: u64,
        /// Connections given up because the delay of their scans changed by more than clocks drift.
        untrusted: u64,
    }
}

fn all<S: Serializer>(ranges_mm: &[u16; MAX_STEPS], serializer: S) -> Result<S::Ok, S::Error> {
    ranges_mm[..].serialize(serializer)
}
