//! The values in the symbol table: plain data, one owner each. Frames and units are in the names (REP 103, 105).
//!
//! Numbers are `f64` and counters `u64` throughout, so that no structure has padding.

use bytemuck::{Pod, Zeroable};
use coordination::datatype;
use description::geometry::{MotionCommand, Pose2, Twist2};
use skills::borders::{AreaSet, MAX_AREAS};
use skills::tubes::Room;

use crate::realtime::histogram::Histogram;
use crate::realtime::scheduling::Granted;
use crate::symbols::faults::{Fault, FaultTable};

type Json = serde_json::Value;

/// Longest scan in the table, in steps.
pub const MAX_STEPS: usize = 768;

macro_rules! value {
    ($(#[$meta:meta])* $name:ident, $datatype:literal { $($(#[$field_meta:meta])* $field:ident: $kind:ty,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Pod, Zeroable)]
        #[repr(C)]
        pub struct $name { $($(#[$field_meta])* pub $field: $kind,)* }

        impl Default for $name {
            fn default() -> Self { Self::zeroed() }
        }

        datatype!($name, $datatype);

        impl Describe for $name {
            fn describe(&self) -> Json {
                let mut object = serde_json::Map::new();
                $(object.insert(stringify!($field).to_owned(), self.$field.describe());)*
                Json::Object(object)
            }
        }
    };
}

/// A value as people and other programs read it, for `onboard inspect`.
pub trait Describe {
    /// As JSON; names of fields carry the units.
    fn describe(&self) -> Json;
}

impl Describe for f64 {
    fn describe(&self) -> Json {
        // What is not a number is null, as JSON has it.
        serde_json::Number::from_f64(*self).map_or(Json::Null, Json::Number)
    }
}

impl Describe for u64 {
    fn describe(&self) -> Json {
        (*self).into()
    }
}

impl<const N: usize> Describe for [u16; N] {
    fn describe(&self) -> Json {
        self.to_vec().into()
    }
}

value! {
    /// Wheel and pivot encoders of the drive, wheel-forward-positive, pivot positive to the left.
    Encoders, "encoders" {
        /// Left wheel angle.
        left_rad: f64,
        /// Right wheel angle.
        right_rad: f64,
        /// Pivot angle, 0 ahead.
        pivot_rad: f64,
        /// Left wheel speed.
        left_rad_s: f64,
        /// Right wheel speed.
        right_rad_s: f64,
        /// Pivot speed.
        pivot_rad_s: f64,
        /// How often the bus was brought up: with each time the drive may have begun to count anew.
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
    /// Dead reckoning in `odom`.
    OdometryValue, "odometry" {
        /// Position.
        x_m: f64,
        /// Position.
        y_m: f64,
        /// Heading.
        theta_rad: f64,
        /// Forward speed of `base_link`.
        v_m_s: f64,
        /// Yaw rate.
        omega_rad_s: f64,
        /// Pivot angle.
        steering_rad: f64,
        /// Way driven.
        distance_m: f64,
        /// Angle turned, left or right.
        turned_rad: f64,
        /// Readings that were refused as implausible.
        refused: u64,
    }
}

impl OdometryValue {
    /// Pose in `odom`.
    #[must_use]
    pub fn pose(&self) -> Pose2 {
        Pose2 {
            x_m: self.x_m,
            y_m: self.y_m,
            theta_rad: self.theta_rad,
        }
    }

    /// Twist in `base_link`.
    #[must_use]
    pub fn twist(&self) -> Twist2 {
        Twist2 {
            v_m_s: self.v_m_s,
            omega_rad_s: self.omega_rad_s,
        }
    }
}

/// Samples in [`OdometryTrace`]: a third of a second at 5 ms.
pub const TRACE_SAMPLES: usize = 64;

/// One sample of the trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct TraceSample {
    /// Time of the encoder reading.
    pub stamp_ns: u64,
    /// Position in `odom`.
    pub x_m: f64,
    /// Position in `odom`.
    pub y_m: f64,
    /// Heading in `odom`.
    pub theta_rad: f64,
    /// Forward speed.
    pub v_m_s: f64,
    /// Yaw rate.
    pub omega_rad_s: f64,
}

value! {
    /// The last samples of dead reckoning, so that a reader that comes every tenth of a second misses none.
    OdometryTrace, "odometry_trace" {
        /// Samples written since start; the newest lies at `(written - 1) % TRACE_SAMPLES`.
        written: u64,
        /// A ring.
        samples: [TraceSample; TRACE_SAMPLES],
    }
}

impl OdometryTrace {
    /// Adds a sample in place of the oldest.
    pub fn push(&mut self, sample: TraceSample) {
        self.samples[(self.written % TRACE_SAMPLES as u64) as usize] = sample;
        self.written += 1;
    }

    /// Samples behind the first `seen`, oldest first, as far as they are still there.
    pub fn since(&self, seen: u64) -> impl Iterator<Item = &TraceSample> {
        let first = seen.max(self.written.saturating_sub(TRACE_SAMPLES as u64));
        (first..self.written).map(|index| &self.samples[(index % TRACE_SAMPLES as u64) as usize])
    }
}

impl Describe for [TraceSample; TRACE_SAMPLES] {
    fn describe(&self) -> Json {
        let newest = self
            .iter()
            .max_by_key(|sample| sample.stamp_ns)
            .copied()
            .unwrap_or_default();
        serde_json::json!({ "samples": TRACE_SAMPLES, "newest_x_m": newest.x_m, "newest_y_m": newest.y_m,
            "newest_theta_rad": newest.theta_rad })
    }
}

value! {
    /// One scan as the sensor gave it, in the steps of the device.
    RangeScan, "range_scan" {
        /// Counts scans.
        sequence: u64,
        /// Number of valid entries.
        count: u64,
        /// Range of each step; below 20 an error code (facts of SCIP 2.0).
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
        /// Scans dropped as broken.
        dropped: u64,
        /// How often it was connected.
        connections: u64,
    }
}

value! {
    /// Forward speed and curvature of the path of `base_link`.
    CommandValue, "motion_command" {
        /// Forward speed.
        speed_m_s: f64,
        /// Curvature, positive to the left.
        curvature_1_m: f64,
        /// 1: stop with the stop deceleration.
        stop: u64,
    }
}

value! {
    /// The motion that navigation wants, and the path that it is on.
    WantedMotion, "wanted_motion" {
        /// Forward speed.
        speed_m_s: f64,
        /// Curvature, positive to the left.
        curvature_1_m: f64,
        /// `base_link` from the path of the controller, positive to the left.
        lateral_m: f64,
        /// Heading relative to that path.
        heading_rad: f64,
        /// Curvature of that path.
        path_curvature_1_m: f64,
        /// The robot keeps so near to that path; infinite: no limit.
        keep_within_m: f64,
        /// So far behind the robot it may be.
        behind_m: f64,
        /// Tightest curve on which navigation leads back to it.
        tightest_1_m: f64,
    }
}

impl WantedMotion {
    /// What navigation says.
    #[must_use]
    pub fn new(command: MotionCommand, room: Room) -> Self {
        Self {
            speed_m_s: command.speed_m_s,
            curvature_1_m: command.curvature_1_m,
            lateral_m: room.lateral_m,
            heading_rad: room.heading_rad,
            path_curvature_1_m: room.path_curvature_1_m,
            keep_within_m: room.limit_m,
            behind_m: room.behind_m,
            tightest_1_m: room.tightest_1_m,
        }
    }

    /// The motion.
    #[must_use]
    pub fn command(&self) -> MotionCommand {
        MotionCommand::new(self.speed_m_s, self.curvature_1_m)
    }

    /// The room about the path.
    #[must_use]
    pub fn room(&self) -> Room {
        Room {
            lateral_m: self.lateral_m,
            heading_rad: self.heading_rad,
            path_curvature_1_m: self.path_curvature_1_m,
            limit_m: self.keep_within_m,
            behind_m: self.behind_m,
            tightest_1_m: self.tightest_1_m,
        }
    }
}

impl CommandValue {
    /// The command that drives.
    #[must_use]
    pub fn drive(command: MotionCommand) -> Self {
        Self {
            speed_m_s: command.speed_m_s,
            curvature_1_m: command.curvature_1_m,
            stop: 0,
        }
    }

    /// The command that stops with the stop deceleration, steering held.
    #[must_use]
    pub fn stop(curvature_1_m: f64) -> Self {
        Self {
            speed_m_s: 0.0,
            curvature_1_m,
            stop: 1,
        }
    }

    /// As the skills take it.
    #[must_use]
    pub fn command(&self) -> MotionCommand {
        MotionCommand {
            speed_m_s: self.speed_m_s,
            curvature_1_m: self.curvature_1_m,
        }
    }
}

value! {
    /// Wheel speeds that the drive is to keep, wheel-forward-positive.
    WheelSetpointsValue, "wheel_setpoints" {
        /// Left wheel.
        left_rad_s: f64,
        /// Right wheel.
        right_rad_s: f64,
    }
}

value! {
    /// Pose of `base_link` in `map`, with standard deviations.
    PoseEstimate, "pose_estimate" {
        /// Position.
        x_m: f64,
        /// Position.
        y_m: f64,
        /// Heading.
        theta_rad: f64,
        /// Standard deviation.
        std_x_m: f64,
        /// Standard deviation.
        std_y_m: f64,
        /// Standard deviation.
        std_theta_rad: f64,
        /// 1 when it is too uncertain to drive.
        uncertain: u64,
    }
}

/// A name of up to 31 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Name {
    bytes: [u8; 32],
}

impl Name {
    /// Takes over `text`, cut at a character boundary when it is too long.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut bytes = [0; 32];
        put(&mut bytes, text);
        Self { bytes }
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        text(&self.bytes)
    }
}

impl Default for Name {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl Describe for Name {
    fn describe(&self) -> Json {
        self.as_str().into()
    }
}

/// A sentence of up to 255 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Line {
    bytes: [u8; 256],
}

impl Line {
    /// Takes over `text`, cut at a character boundary when it is too long.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut bytes = [0; 256];
        put(&mut bytes, text);
        Self { bytes }
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        text(&self.bytes)
    }
}

impl Default for Line {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl Describe for Line {
    fn describe(&self) -> Json {
        self.as_str().into()
    }
}

/// Fills `bytes`, which are zero, with as much of the text as fits before a final zero.
fn put(bytes: &mut [u8], text: &str) {
    let mut end = text.len().min(bytes.len() - 1);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
}

/// Up to the first zero.
fn text(bytes: &[u8]) -> &str {
    let end = bytes.iter().position(|&byte| byte == 0);
    std::str::from_utf8(&bytes[..end.unwrap_or(bytes.len())]).unwrap_or("?")
}

value! {
    /// Where navigation takes the robot to be and what it is doing there, in one moment: numbers, for other activities.
    Whereabouts, "whereabouts" {
        /// Position in `map`.
        x_m: f64,
        /// Position in `map`.
        y_m: f64,
        /// Heading in `map`.
        theta_rad: f64,
        /// Variance of x, in m².
        xx: f64,
        /// Covariance of x and y, in m².
        xy: f64,
        /// Variance of y, in m².
        yy: f64,
        /// Covariance of x and θ, in m rad.
        xt: f64,
        /// Covariance of y and θ, in m rad.
        yt: f64,
        /// Variance of θ, in rad².
        tt: f64,
        /// 1 when it is too uncertain to drive.
        uncertain: u64,
        /// Number of the state of the robot's machine.
        state: u64,
        /// Number of the area ahead that it may not enter, and slows down or waits for; `u64::MAX` for none.
        waiting_for: u64,
    }
}

/// Words of [`AllowedAreas`].
const AREA_WORDS: usize = MAX_AREAS / 64;

value! {
    /// Areas that the mediator lets the robot be in.
    AllowedAreas, "allowed_areas" {
        /// One bit for each area of the site, in its order, the lowest first.
        areas: [u64; AREA_WORDS],
    }
}

impl AllowedAreas {
    /// Puts a set into the table.
    #[must_use]
    pub fn new(set: &AreaSet) -> Self {
        let mut areas = [0; AREA_WORDS];
        for area in set.iter() {
            areas[area / 64] |= 1 << (area % 64);
        }
        Self { areas }
    }

    /// The set. Real time.
    #[must_use]
    pub fn set(&self) -> AreaSet {
        let bit = |area: &usize| self.areas[area / 64] >> (area % 64) & 1 == 1;
        (0..MAX_AREAS).filter(bit).collect()
    }
}

impl Describe for [u64; AREA_WORDS] {
    fn describe(&self) -> Json {
        let bit = |area: &usize| self[area / 64] >> (area % 64) & 1 == 1;
        (0..MAX_AREAS).filter(bit).collect::<Vec<_>>().into()
    }
}

value! {
    /// How the robot stands with the mediator.
    FleetState, "fleet_state" {
        /// 0: nobody manages the site's areas, and everything is granted.
        managed: u64,
        /// The mediator's epoch, 0 before it spoke.
        mediator_epoch: u64,
        /// The registration, 0 without one.
        session: u64,
        /// 1 when nothing was heard of the mediator for too long.
        silent: u64,
        /// 1 while the mediator has the discrete control.
        acquired: u64,
        /// The coordination under way, 0 for none.
        coordination: u64,
        /// Its net, with the flags set so far.
        net: Line,
        /// Areas that the robot may be in.
        holds: Line,
        /// Areas that it waits for and why, and orders that wait for its machine; or why the mediator refuses it.
        waits: Line,
        /// Reports sent.
        sent: u64,
        /// Messages of the mediator.
        received: u64,
        /// Messages of the mediator that were lost here, or could not be read.
        dropped: u64,
    }
}

value! {
    /// What navigation is doing.
    NavigationState, "navigation_state" {
        /// State of the robot's machine.
        state: Name,
        /// Area of that state.
        area: Name,
        /// Skill that is scheduled.
        skill: Name,
        /// Distance from the lane's centre, positive to its left.
        lateral_error_m: f64,
        /// Heading relative to the lane.
        heading_error_rad: f64,
        /// Distance to the lane's end, NaN when it is not tracked.
        lane_end_m: f64,
        /// Why it stands although its skill would move: see `skills::navigator::Hold`. Empty: it does not.
        hold: Name,
        /// The area ahead that it may not enter, and slows down or waits for. Empty: none.
        waiting_for: Name,
        /// Way left before that area, NaN when none is near.
        border_distance_m: f64,
        /// How often the schedule changed.
        schedule_changes: u64,
        /// How often the machine emitted `lap`.
        laps: u64,
        /// Events that the machine's state ignored.
        ignored_events: u64,
    }
}

value! {
    /// What the motion tubes make of the command.
    TubeState, "tube_state" {
        /// 0 free, 1 shifted, 2 slowed, 3 stopped.
        verdict: u64,
        /// Why it is not driven as wanted: number of the reason, see `skills::tubes::Reason`.
        reason: u64,
        /// Index of the chosen tube, `u64::MAX` for none.
        tube: u64,
        /// Free tubes at the last scan.
        free_tubes: u64,
        /// Tubes in the set.
        tubes: u64,
        /// Age of the scan that was judged.
        scan_age_ns: u64,
        /// Time the last evaluation took.
        evaluation_ns: u64,
        /// From the footprint to the nearest point of the last scan.
        clearance_m: f64,
    }
}

value! {
    /// Life cycle of one activity.
    ActivityState, "activity_state" {
        /// Number of the life-cycle state.
        state: u64,
        /// Events that arrived in a state that has no use for them.
        ignored_events: u64,
        /// How often its event loop ran.
        cycles: u64,
    }
}

/// What the robot as a whole is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Mode {
    /// Activities acquire their resources.
    Configuring = 0,
    /// It drives, or would if nothing were in the way.
    Running = 1,
    /// An operator paused it.
    Paused = 2,
    /// A fault or an operator stopped it; it waits for a reset.
    Stopped = 3,
    /// It stops, then the program ends.
    Ending = 4,
}

impl Mode {
    /// Its name on the network and in `inspect`.
    #[must_use]
    pub fn name_of(number: u64) -> &'static str {
        match number {
            0 => "configuring",
            1 => "running",
            2 => "paused",
            3 => "stopped",
            _ => "ending",
        }
    }
}

value! {
    /// The supervisor's view of the robot.
    RobotMode, "robot_mode" {
        /// 0 configuring, 1 running, 2 paused, 3 stopped, 4 ending.
        mode: u64,
        /// Drawn at start.
        boot_epoch: u64,
        /// Process id.
        pid: u64,
        /// Robot, as its file names it.
        robot: Name,
    }
}

value! {
    /// Scheduling and timing of one thread.
    ThreadReport, "thread_report" {
        /// Configured period; 0 when it has none.
        period_ns: u64,
        /// How often its loop ran.
        cycles: u64,
        /// Cycles that ended after the next should have begun.
        overruns: u64,
        /// What the kernel granted.
        granted: Granted,
        /// Lateness of wake-ups while running, in µs when described.
        wakeup: Histogram,
        /// Execution times while running, in µs when described.
        exec: Histogram,
    }
}

impl Describe for Granted {
    fn describe(&self) -> Json {
        serde_json::json!({ "policy": self.policy_name(), "priority": self.priority, "cores": self.cores_text(),
            "reset_on_fork": self.reset_on_fork != 0 })
    }
}

impl Describe for Histogram {
    fn describe(&self) -> Json {
        let us = |ns: u64| ns as f64 / 1000.0;
        serde_json::json!({ "p50": us(self.quantile_ns(0.5)), "p99": us(self.quantile_ns(0.99)),
            "p999": us(self.quantile_ns(0.999)), "max": us(self.max_ns()) })
    }
}

datatype!(FaultTable, "fault_table");

impl Describe for FaultTable {
    fn describe(&self) -> Json {
        let states = Fault::ALL
            .into_iter()
            .filter(|&fault| self.state(fault).count > 0)
            .map(|fault| {
                let state = self.state(fault);
                let value =
                    serde_json::json!({ "active": state.active != 0, "count": state.count });
                (fault.name().to_owned(), value)
            });
        Json::Object(states.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_gives_what_is_new_and_still_there() {
        let mut trace = OdometryTrace::default();
        for stamp_ns in 1..=100 {
            trace.push(TraceSample {
                stamp_ns,
                ..TraceSample::default()
            });
        }
        let stamps = |seen| {
            trace
                .since(seen)
                .map(|sample| sample.stamp_ns)
                .collect::<Vec<_>>()
        };
        assert_eq!(stamps(97), [98, 99, 100]);
        assert_eq!((stamps(0).len(), stamps(0)[0]), (TRACE_SAMPLES, 37));
        assert!(stamps(100).is_empty());
    }

    #[test]
    fn areas_survive_the_table() {
        for set in [
            AreaSet::EMPTY,
            AreaSet::ALL,
            [0, 63, 64, 255].into_iter().collect(),
        ] {
            assert_eq!(AllowedAreas::new(&set).set(), set);
        }
        // Never written: nothing is allowed.
        assert!(AllowedAreas::default().set().is_empty());
    }

    #[test]
    fn names_are_cut_at_a_character() {
        assert_eq!(Name::new("drive-1").as_str(), "drive-1");
        assert_eq!(Name::new(&"ä".repeat(20)).as_str(), "ä".repeat(15));
        assert_eq!(Line::new(&"ä".repeat(200)).as_str(), "ä".repeat(127));
    }
}
