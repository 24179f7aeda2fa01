//! What a navigator is made of.

use description::geometry::Footprint;
use description::robot::Navigation;
use description::site::Site;

/// Everything that a [`Navigator`](super::Navigator) needs to know.
#[derive(Clone, Debug)]
pub struct NavigatorSetup {
    /// Walls, lanes, areas, skills, monitors, state machines, and where the robots start.
    pub site: Site,
    /// The robot's identity, which the site knows.
    pub robot: String,
    /// How it estimates and steers.
    pub gains: Navigation,
    /// Fastest speed-up of the robot, `drive.acceleration_m_s2`.
    pub acceleration_m_s2: f64,
    /// The robot's own speed limit, `drive.max_speed_m_s`.
    pub max_speed_m_s: f64,
    /// The robot's outline.
    pub footprint: Footprint,
    /// Beams of a scan, at most.
    pub beams: usize,
}
