//! What a collision was: who moved, and who was hit.

/// A robot slower than this counts as standing, even if its wheels turn.
pub const STANDING_M_S: f64 = 0.02;
/// Most collisions kept for each robot; counters count all.
pub(super) const MOST_COLLISIONS: usize = 256;

/// Who is to blame for a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The robot moved, and what it touched stood.
    DroveInto,
    /// Both moved.
    Met,
    /// The robot stood, and what it touched moved.
    RunInto,
}

/// The beginning of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collision {
    /// Monotonic time.
    pub time_ns: u64,
    /// Who moved.
    pub cause: Cause,
    /// Fastest speed of the robot's outline just before.
    pub robot_m_s: f64,
    /// Fastest speed of what it touched.
    pub object_m_s: f64,
    /// Where the middle of what it touched was, seen from its lidar, 0 ahead and positive to the left; of a wall,
    /// ahead.
    pub bearing_rad: f64,
}

impl Collision {
    pub(super) fn new(
        time_ns: u64,
        robot_m_s: f64,
        object_m_s: f64,
        bearing_rad: f64,
    ) -> Collision {
        let cause = match (robot_m_s < STANDING_M_S, object_m_s < STANDING_M_S) {
            (true, false) => Cause::RunInto,
            (false, false) => Cause::Met,
            // Contact with a wall is always the robot's, at any speed.
            (_, true) => Cause::DroveInto,
        };
        Collision {
            time_ns,
            cause,
            robot_m_s,
            object_m_s,
            bearing_rad,
        }
    }
}
