//! How long each value of the table is, on processors of any width: who reads a robot's symbols must find them as they were written.
//!
//! All are `Pod`, which leaves no room between fields: where each lies follows from their order and from how long they are.
//!
//! A value that grows or shrinks does so here too, on purpose, and so raises the question who else reads it.

use coordination::symbols::Stamped;
use skills::borders::AreaSet;
use skills::odometry::Odometry;
use skills::tubes::FloorCheckpoint;

use super::faults::FaultTable;
use super::values::{
    ActivityState, DriveStatus, Encoders, FleetState, LidarStatus, Load, NavigationState,
    OdometryTrace, PoseEstimate, RangeScan, RobotMode, SafeCommand, TeleopWish, ThreadReport,
    TubeState, WantedMotion, WheelSetpoints, Whereabouts,
};

macro_rules! layouts {
    ($($value:ty: $bytes:literal,)*) => {
        $(const _: () = {
            assert!(size_of::<$value>() == $bytes && align_of::<$value>() == 8);
            assert!(size_of::<Stamped<$value>>() == $bytes + 8);
        };)*
    };
}

layouts! {
    Encoders: 56,
    DriveStatus: 88,
    WheelSetpoints: 16,
    RangeScan: 1552,
    LidarStatus: 40,
    OdometryTrace: 3080,
    WantedMotion: 80,
    TeleopWish: 48,
    SafeCommand: 24,
    TubeState: 72,
    PoseEstimate: 104,
    Whereabouts: 312,
    NavigationState: 224,
    RobotMode: 80,
    Load: 40,
    ActivityState: 24,
    ThreadReport: 3312,
    FleetState: 840,
    AreaSet: 32,
    Odometry: 128,
    FloorCheckpoint: 18480,
    FaultTable: 864,
}
