//! Poses and instructions in messages, and as everybody else has them.

use description::geometry::Pose2;
use description::instruction::Instruction;

use crate::wire;

impl From<&wire::Pose> for Pose2 {
    fn from(pose: &wire::Pose) -> Self {
        Self::new(pose.x_m, pose.y_m, pose.theta_rad)
    }
}

/// Its standard deviations are left out.
impl From<Pose2> for wire::Pose {
    fn from(pose: Pose2) -> Self {
        Self {
            x_m: pose.x_m,
            y_m: pose.y_m,
            theta_rad: pose.theta_rad,
            ..Self::default()
        }
    }
}

/// No event: only the rest is ordered.
impl From<&wire::Instruction> for Instruction<Option<String>> {
    fn from(said: &wire::Instruction) -> Self {
        Self {
            event: Some(said.event.clone()).filter(|event| !event.is_empty()),
            speed_limit_m_s: Some(said.speed_limit_m_s).filter(|&limit_m_s| limit_m_s > 0.0),
            stop_at: said.stop_at.as_ref().map(Pose2::from),
        }
    }
}
