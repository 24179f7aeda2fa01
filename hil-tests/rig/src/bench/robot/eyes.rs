//! What is seen of a robot from outside, at one time.

use coordination::symbols::Reader;
use onboard::symbols::values::{RangeScan, TubeState, WheelSetpoints};
use sim::kelo::DriveHandle;
use sim::lidar::FaultHandle;
use sim::rt::monotonic_ns;

/// Reads the symbols of a robot, and asks its simulated devices.
pub(super) struct Eyes {
    pub(super) scan: Reader<RangeScan>,
    pub(super) tubes: Reader<TubeState>,
    pub(super) setpoints: Reader<WheelSetpoints>,
    pub(super) lidar: FaultHandle,
    pub(super) drive: DriveHandle,
}

/// What was there. All times are nanoseconds of the monotonic clock, all speeds rad/s of left and right wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Now.
    pub(super) now_ns: u64,
    /// Number of the newest scan that the robot has taken in,
    pub(super) scan: u64,
    /// and when its first beam was measured.
    pub(super) measured_ns: u64,
    /// When the last byte of the newest scan was handed to the robot.
    pub(super) ended_ns: u64,
    /// When the scan was measured that the motion tubes judged last.
    pub(super) judged_ns: u64,
    /// When control has made setpoints last,
    pub(super) controlled_ns: u64,
    /// and these setpoints.
    pub(super) wanted_rad_s: (f64, f64),
    /// Frames with setpoints that the drive has had,
    pub(super) frames: u64,
    /// and the setpoints in the last one.
    pub(super) framed_rad_s: (f64, f64),
}

impl Eyes {
    /// Looks.
    pub(super) fn look(&mut self) -> Seen {
        // What comes first last, so that nothing is seen before what it follows from.
        let drive = self.drive.statistics();
        let setpoints = self.setpoints.read();
        let tubes = self.tubes.read();
        let scan = self.scan.read();
        let speeds = setpoints.value.speeds;
        Seen {
            now_ns: monotonic_ns(),
            scan: scan.value.sequence,
            measured_ns: scan.stamp_ns,
            ended_ns: self.lidar.counters().scan_ended_ns,
            judged_ns: tubes.stamp_ns.saturating_sub(tubes.value.scan_age_ns),
            controlled_ns: setpoints.stamp_ns,
            wanted_rad_s: (speeds.left_rad_s, speeds.right_rad_s),
            frames: drive.setpoints,
            framed_rad_s: drive.last_rad_s,
        }
    }
}
