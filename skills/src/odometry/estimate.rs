//! What goes into dead reckoning, and what comes out of it.

use description::geometry::{Pose2, Twist2};
use description::wheels::EncoderAngles;

/// What the drive's encoders said at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EncoderSample {
    /// When it was sampled, monotonic.
    pub stamp_ns: u64,
    /// The angles.
    pub angles: EncoderAngles,
}

/// Where dead reckoning believes the robot is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "symbols",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
pub struct Odometry {
    /// When the encoders were sampled; 0 before the first sample.
    #[cfg_attr(feature = "symbols", serde(skip))]
    pub stamp_ns: u64,
    /// `base_link` in `odom`.
    #[cfg_attr(feature = "symbols", serde(flatten))]
    pub pose: Pose2,
    /// Of `base_link`, smoothed over a few samples.
    #[cfg_attr(feature = "symbols", serde(flatten))]
    pub twist: Twist2,
    /// Pivot angle in (−π, π].
    pub steering_rad: f64,
    /// Length of the path driven since the start; never falls.
    pub distance_m: f64,
    /// Sum of all angles turned, left or right; never falls.
    pub turned_rad: f64,
    /// Samples rejected as implausible before this one.
    pub refused: u64,
    /// What the encoders said then.
    #[cfg_attr(feature = "symbols", serde(skip))]
    pub angles: EncoderAngles,
    /// Way that the wheels say and the robot may not have driven, since the start; never falls.
    pub slipped_m: f64,
    /// How often the robot may have moved without being measured since the start, as when the encoders lost power. What is
    /// remembered in `odom` from before is worth nothing, and the pose in `map` is less certain.
    pub breaks: u64,
    /// Way that the robot may have moved, in whatever direction, besides what is reckoned, and angle in radians that it may have turned,
    /// since the start; never falls.
    pub unmeasured_m: f64,
}

#[cfg(feature = "symbols")]
coordination::datatype!(Odometry, "odometry", description::SYMBOLS);
