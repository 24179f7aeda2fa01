//! What steering and speed are tuned by.

/// How the controllers steer. The defaults suit a wheelbase of 0.25 m at up to 0.5 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlGains {
    /// Curvature per metre of lateral error. With the heading gain: a lateral error decays over a way of
    /// 2/`heading_gain_1_m`, without overshoot while `heading_gain_1_m`² ≥ 4·`lateral_gain_1_m2`.
    pub lateral_gain_1_m2: f64,
    /// Curvature per radian of heading error.
    pub heading_gain_1_m: f64,
    /// A large lateral error is approached as if aiming this far ahead on the lane.
    pub lookahead_m: f64,
    /// Tightest curve that is asked for.
    pub max_curvature_1_m: f64,
    /// Speeding up.
    pub acceleration_m_s2: f64,
    /// Slowing down where it can be foreseen.
    pub deceleration_m_s2: f64,
    /// From commanding a curve until the pivot has turned; manoeuvres begin and end this much earlier.
    pub steering_lag_s: f64,
}

impl Default for ControlGains {
    fn default() -> Self {
        Self {
            lateral_gain_1_m2: 4.0,
            heading_gain_1_m: 4.0,
            lookahead_m: 0.6,
            max_curvature_1_m: 2.5,
            acceleration_m_s2: 0.5,
            deceleration_m_s2: 0.4,
            steering_lag_s: 0.2,
        }
    }
}
