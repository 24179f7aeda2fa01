//! Where a robot's process begins, and whether it goes on from where the mediator has heard of the one before.

use contract::wire::{self, TakeUp};
use coordination::fsm::StateId;
use description::geometry::Pose2;

use super::setup::{Began, Start, StatePlan};

/// Where a robot has ended and where the mediator has heard of it last agree to this.
const AGREES_M: f64 = 0.25;
const AGREES_RAD: f64 = 0.25;

/// Where a robot goes on that the mediator has registered.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Resume {
    /// Where it believes to be.
    Here,
    /// Where it ended; and what to say of it.
    There { start: Start, why: String },
    /// Somebody has to say where it stands; and what to tell them.
    Nowhere { why: Option<String> },
}

impl Began {
    /// What to do about what the mediator knows. One that has ended elsewhere than it was heard of goes on nowhere by itself: it
    /// may have driven on unheard.
    pub(super) fn resume(self, take_up: Option<&TakeUp>, states: &[StatePlan]) -> Resume {
        let ended = match (self, take_up) {
            (Self::GoesOn, _) | (Self::Afresh { .. }, None) => return Resume::Here,
            (Self::Lost, None) => return Resume::Nowhere { why: None },
            (Self::Lost, _) => None,
            (Self::Afresh { ended }, _) => ended,
        };
        let TakeUp {
            pose, fsm_state, ..
        } = take_up.cloned().unwrap_or_default();
        let state = states.iter().position(|state| state.name == fsm_state);
        let state = state.and_then(|state| u16::try_from(state).ok());
        let heard = pose.filter(|pose| Pose2::from(pose).is_finite());
        match (ended, &heard, state) {
            (Some(ended), Some(heard), Some(state)) if agree(ended, heard) => Resume::There {
                start: Start {
                    pose: ended,
                    std_m: heard.std_x_m.max(heard.std_y_m),
                    std_rad: heard.std_theta_rad,
                    state: StateId(state),
                },
                why: format!(
                    "resuming where the robot was before it restarted: ({:.2} m, {:.2} m, {:.2} rad), state `{fsm_state}`",
                    ended.x_m, ended.y_m, ended.theta_rad
                ),
            },
            _ => {
                let heard = heard.map_or(String::new(), |heard| {
                    format!(
                        ", and was heard of last at ({:.2} m, {:.2} m, {:.2} rad)",
                        heard.x_m, heard.y_m, heard.theta_rad
                    )
                });
                Resume::Nowhere {
                    why: Some(format!(
                        "the robot was in state `{fsm_state}` before it restarted{heard}; nobody knows where it stands now: say so with `onboard ctl place X,Y,THETA --state {fsm_state}`"
                    )),
                }
            }
        }
    }
}

fn agree(ended: Pose2, heard: &wire::Pose) -> bool {
    let way = ended.between(Pose2::from(heard));
    way.x_m.hypot(way.y_m) <= AGREES_M && way.theta_rad.abs() <= AGREES_RAD
}
