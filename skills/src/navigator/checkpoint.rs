//! Where a navigator is, in numbers: enough for another one, of the same robot and site, to go on from there.

use super::instruction::Parameters;
use super::state::Navigator;
use crate::odometry::Odometry;
use coordination::fsm::StateId;
use description::geometry::Pose2;
use nalgebra::Matrix3;

/// No pose.
const NOWHERE: Pose2 = Pose2::new(f64::NAN, f64::NAN, f64::NAN);

/// Where a navigator was after a step, and what it did there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "symbols",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
pub struct NavigatorCheckpoint {
    /// `base_link` in `map`, when odometry was this:
    #[cfg_attr(feature = "symbols", serde(flatten))]
    pub pose: Pose2,
    /// dead reckoning of the step.
    #[cfg_attr(feature = "symbols", serde(skip))]
    pub odometry: Odometry,
    /// Of (x, y, θ), row by row, in metres and radians.
    pub covariance: [[f64; 3]; 3],
    /// 1 when it is too uncertain to drive.
    pub uncertain: u64,
    /// Number of the state of the robot's machine,
    pub state: u64,
    /// in which it has been for this time, seconds,
    pub in_state_s: f64,
    /// and whose path began here, in `map`.
    pub began: Pose2,
    /// The speed limit that an instruction brought, metres per second; NaN for none.
    pub speed_limit_m_s: f64,
    /// Where an instruction said to stop, in `map`; NaN for nowhere.
    pub stop_at: Pose2,
}

impl Navigator {
    /// Where it is since the last step. Real time.
    #[must_use]
    pub fn checkpoint(&self) -> NavigatorCheckpoint {
        NavigatorCheckpoint {
            pose: self.pose.pose(),
            odometry: self.pose.odometry(),
            covariance: (*self.pose.covariance()).transpose().into(),
            uncertain: u64::from(self.pose.is_uncertain()),
            state: u64::from(self.machine.state().0),
            in_state_s: self.in_state_s,
            began: self.began,
            speed_limit_m_s: self.parameters.speed_limit_m_s.unwrap_or(f64::NAN),
            stop_at: self.parameters.stop_at.unwrap_or(NOWHERE),
        }
    }

    /// Goes on where another one was: its pose, which odometry has moved since, its state, and the path of that state from
    /// where it began. Features are looked for anew.
    ///
    /// `false`: the numbers are not those of a place on this site, or the pose was uncertain, and nothing changes.
    pub fn resume(&mut self, from: &NavigatorCheckpoint) -> bool {
        let covariance = Matrix3::from(from.covariance).transpose();
        let spread = (0..3).all(|axis| covariance[(axis, axis)] > 0.0);
        let finite = [from.pose, from.odometry.pose, from.began]
            .iter()
            .all(|pose| pose.is_finite());
        let known = covariance.iter().all(|value| value.is_finite()) && from.uncertain == 0;
        let state = u16::try_from(from.state).ok().map(StateId);
        let state = state.filter(|state| state.index() < self.schedules.len());
        let (Some(state), true) = (state, finite && spread && known) else {
            return false;
        };
        if !self.machine.restart_in(state) {
            return false;
        }
        self.pose.resume(from.pose, covariance, &from.odometry);
        self.parameters = Parameters {
            speed_limit_m_s: Some(from.speed_limit_m_s).filter(|limit_m_s| *limit_m_s >= 0.0),
            stop_at: Some(from.stop_at).filter(|pose| pose.is_finite()),
            ..Parameters::default()
        };
        self.activate(None);
        self.begin_motion_at(from.began);
        self.in_state_s = from.in_state_s.max(0.0);
        true
    }
}
