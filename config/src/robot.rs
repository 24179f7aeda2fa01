//! What a robot file holds, once it is read and valid.

use std::net::SocketAddr;
use std::path::PathBuf;

use crate::geometry::PoseConfig;
use crate::origin::Origin;
use crate::threads::ThreadConfig;

/// One robot: its hardware, its limits, its threads, its gains.
#[derive(Clone, Debug)]
pub struct RobotConfig {
    /// Who it is.
    pub identity: Identity,
    /// How much floor it covers.
    pub footprint: Footprint,
    /// Its wheel unit, and how fast it may move.
    pub drive: DriveConfig,
    /// How the wheel unit is reached.
    pub ethercat: EthercatConfig,
    /// Its range sensor.
    pub lidar: LidarConfig,
    /// Which activity runs where, and when.
    pub threads: Vec<ThreadConfig>,
    /// Gains of the motion thread.
    pub control: ControlGains,
    /// Gains and limits of navigation.
    pub navigation: NavigationGains,
    /// The motion tubes.
    pub tubes: TubeConfig,
    /// How it meets the rest of the fleet.
    pub fleet: FleetConfig,
    /// Where each value was written.
    pub origin: Origin,
}

/// `[identity]`
#[derive(Clone, Debug, PartialEq)]
pub struct Identity {
    /// Unique name in the fleet; also names shared memory and network keys.
    pub id: String,
    /// What kind of robot this is, for people.
    pub model: String,
}

/// `[footprint]`: distances from `base_link` to the body's edges, all positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// To the front edge.
    pub front_m: f64,
    /// To the rear edge.
    pub rear_m: f64,
    /// To the left edge.
    pub left_m: f64,
    /// To the right edge.
    pub right_m: f64,
}

/// `[drive]`: the wheel unit's geometry and the limits of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveConfig {
    /// From the fixed axle (`base_link`) forward to the unit's pivot.
    pub wheelbase_m: f64,
    /// Diameter of each hub wheel.
    pub wheel_diameter_m: f64,
    /// Between the two hub wheels.
    pub wheel_separation_m: f64,
    /// How far the wheel axle trails behind the pivot.
    pub caster_offset_m: f64,
    /// What the pivot encoder reads when the unit points forward.
    pub pivot_zero_rad: f64,
    /// No wheel setpoint ever exceeds this.
    pub max_wheel_speed_rad_s: f64,
    /// Speed limit of `base_link`.
    pub max_speed_m_s: f64,
    /// Largest commanded steering (pivot) angle to either side.
    pub max_steering_rad: f64,
    /// How fast the steering angle may change.
    pub max_steering_rate_rad_s: f64,
    /// Limit when speeding up.
    pub acceleration_m_s2: f64,
    /// Limit when slowing down in normal driving.
    pub deceleration_m_s2: f64,
    /// Deceleration of every stop for a fault.
    pub stop_deceleration_m_s2: f64,
    /// Motor current limit while driving.
    pub drive_current_a: f64,
    /// Motor current limit while standing.
    pub stop_current_a: f64,
    /// Under this bus voltage the robot stops.
    pub min_bus_voltage_v: f64,
    /// Over this bus voltage the robot stops.
    pub max_bus_voltage_v: f64,
    /// A wheel setpoint older than this counts as none.
    pub setpoint_timeout_ms: u32,
    /// Lost frames up to this long are bridged by holding the last setpoint.
    pub hold_ms: u32,
    /// Bring-ups by itself within a minute; one more needs an operator.
    pub bringups_per_minute: u32,
}

/// Where the EtherCAT frames go: exactly one of `interface` and `udp`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Link {
    /// Raw Ethernet frames on this network interface.
    Interface(String),
    /// The same datagrams over UDP, to this address.
    Udp(SocketAddr),
}

/// `[ethercat]`
#[derive(Clone, Debug, PartialEq)]
pub struct EthercatConfig {
    /// Where the frames go.
    pub link: Link,
    /// The vendor that the SubDevice must report.
    pub vendor_id: u32,
    /// The product codes that are accepted.
    pub product_codes: Vec<u32>,
    /// A cycle's answer later than this counts as lost.
    pub deadline_us: u32,
    /// The SubDevice's process-data watchdog, as it must report it.
    pub watchdog_ms: u32,
}

/// `[lidar]`
#[derive(Clone, Debug, PartialEq)]
pub struct LidarConfig {
    /// The serial device.
    pub device: PathBuf,
    /// The bit rate to switch to.
    pub bit_rate: u32,
    /// Where `laser` sits in `base_link`.
    pub mount: PoseConfig,
    /// Nearer readings are unknown.
    pub range_min_m: f64,
    /// Farther readings are free up to here.
    pub range_max_m: f64,
    /// Neighbouring steps merged into one reading (1: none).
    pub cluster: u32,
    /// Scans left out between two that are sent.
    pub skip: u32,
    /// No valid scan for this long stops the robot.
    pub scan_timeout_ms: u32,
    /// Good scans for this long let it go on.
    pub good_scans_s: f64,
}

/// `[control]`: gains of the motion thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlGains {
    /// Pivot rate asked per radian of pivot error.
    pub pivot_gain_1_s: f64,
    /// Pivot errors beyond this are treated as this.
    pub pivot_error_max_rad: f64,
    /// With a larger pivot error the unit turns in place before it rolls.
    pub align_rad: f64,
    /// A motion command older than this counts as none.
    pub command_timeout_ms: u32,
}

/// `[navigation]`: controllers, feature trackers, and when the pose is too poor to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationGains {
    /// Curvature (1/m) asked per metre of lateral error.
    pub lateral_gain_1_m2: f64,
    /// Curvature (1/m) asked per radian of heading error.
    pub heading_gain_1_m: f64,
    /// How far ahead on the lane the corridor controller aims.
    pub lookahead_m: f64,
    /// Tightest curvature that navigation asks for.
    pub max_curvature_1_m: f64,
    /// Deceleration towards a lane's end.
    pub deceleration_m_s2: f64,
    /// From asking for a curve until the pivot has turned: manoeuvres begin so much earlier.
    pub steering_lag_s: f64,
    /// A scan point this near to a line belongs to it.
    pub wall_inlier_m: f64,
    /// Points that a wall needs to be one.
    pub wall_min_points: u32,
    /// Noise of one range, at least.
    pub range_std_m: f64,
    /// Measurements farther than this many standard deviations are refused.
    pub gate_sigma: f64,
    /// Growth of the position's standard deviation per metre driven.
    pub odometry_std_m_per_m: f64,
    /// Growth of the heading's standard deviation per metre driven.
    pub odometry_std_rad_per_m: f64,
    /// Standard deviation of the start position.
    pub start_std_m: f64,
    /// Standard deviation of the start heading.
    pub start_std_rad: f64,
    /// Above this standard deviation of the position the robot stops.
    pub max_std_m: f64,
    /// Above this standard deviation of the heading the robot stops.
    pub max_std_rad: f64,
    /// Borders are kept away from by this many standard deviations of the pose.
    pub border_sigma: f64,
}

/// One length of tubes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeHorizon {
    /// How far ahead in time.
    pub horizon_s: f64,
    /// At which speed.
    pub speed_m_s: f64,
}

/// `[tubes]`: the set of motion tubes; `horizons.len() * omega_steps` tubes in all.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeConfig {
    /// Lengths and speeds, shortest first.
    pub horizons: Vec<TubeHorizon>,
    /// The same, driven backwards; none: the robot never drives backwards.
    pub backward_horizons: Vec<TubeHorizon>,
    /// Turn rates reach from minus to plus this.
    pub omega_max_rad_s: f64,
    /// Turn rates per horizon, evenly spaced; odd, so that straight is one of them.
    pub omega_steps: u32,
    /// Spacing of the samples on a tube's border.
    pub sample_step_m: f64,
    /// How far outside the border the samples lie: at least half a step plus the sensor's error.
    pub augment_m: f64,
    /// A wanted curvature (1/m) may be shifted by no more than this, so that the lane is kept.
    pub curvature_band_1_m: f64,
    /// What a lost m/s weighs against a shift of the curvature by one 1/m.
    pub speed_weight: f64,
    /// The other side must be better by this much curvature before a shift changes sides.
    pub hysteresis_1_m: f64,
    /// A tube is free after so many free scans in a row, and blocked after one.
    pub free_scans: u32,
    /// From a command to the beginning of its deceleration.
    pub reaction_s: f64,
    /// How long the way must be free before it goes on after a stop.
    pub resume_after_s: f64,
    /// How long points out of view are remembered.
    pub memory_s: f64,
    /// Floor behind that was seen free counts as free for so long a way.
    pub floor_memory_m: f64,
    /// Tightest curve (1/m) of a way around a standing thing; 0: it stops before it.
    pub detour_curvature_1_m: f64,
    /// How far such a way may turn from the direction in which it was hindered.
    pub detour_heading_rad: f64,
    /// The highest speed on such a way.
    pub detour_speed_m_s: f64,
    /// Hindered for so long before such a way begins.
    pub detour_after_s: f64,
    /// Where no way leads on it backs out so far; 0: never.
    pub detour_retreat_m: f64,
    /// Things that are seen to move may come this fast; 0: takes no notice of motion.
    pub moving_speed_m_s: f64,
    /// What remains between a moving thing and the robot when it stands.
    pub moving_margin_m: f64,
    /// What has moved may move on for so long after it came to rest.
    pub moving_rest_s: f64,
}

/// `[fleet]`: zenoh, between this robot and everybody else.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetConfig {
    /// Endpoints to listen on, such as `tcp/0.0.0.0:7447`.
    pub listen: Vec<String>,
    /// Endpoints to connect to.
    pub connect: Vec<String>,
    /// Whether to look for others by multicast.
    pub scouting: bool,
    /// The network interface for scouting; never the fieldbus.
    pub interface: Option<String>,
    /// First part of every key.
    pub key_prefix: String,
    /// An area that the mediator grants is asked for so far ahead, beyond the way that the robot needs to stop.
    pub request_ahead_m: f64,
}
