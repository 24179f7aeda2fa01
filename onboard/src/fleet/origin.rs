//! Where a robot's process begins, and whether it goes on from where the mediator has heard of the one before.

use contract::wire::TakeUp;
use coordination::fsm::StateId;
use description::geometry::Pose2;

use super::setup::{Began, Setup};

/// Where a robot has ended agrees to this with where the mediator has heard of it last, and with its start.
const AGREES_M: f64 = 0.25;
const AGREES_RAD: f64 = 0.25;

/// Where a robot goes on that the mediator has registered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Resume {
    /// Where it believes to be.
    Here,
    /// Where it ended, from where odometry has moved it since; and what to say of it. In this state, if that is not the one that it ended in.
    There { state: Option<StateId>, why: String },
    /// Somebody has to say where it stands; and what to tell them.
    Nowhere { why: Option<String> },
}

impl Setup {
    /// What to do about what the mediator knows. One that has ended elsewhere than it was heard of goes on nowhere by itself: it
    /// may have driven on unheard. Nor does one whose state nobody knows.
    pub(super) fn resume(&self, take_up: Option<&TakeUp>) -> Resume {
        let state_of = |name: &str| {
            let state = self.states.iter().position(|state| state.name == name);
            state.and_then(|state| u16::try_from(state).ok())
        };
        let ended = match (&self.began, take_up) {
            (Began::GoesOn, _) | (Began::Afresh { ended: None }, None) => return Resume::Here,
            (Began::Lost, None) => return Resume::Nowhere { why: None },
            (Began::Lost, _) => None,
            (Began::Afresh { ended }, _) => ended.as_ref(),
        };
        let noted = ended.and_then(|ended| state_of(&ended.state));
        if let (Some(ended), None) = (ended, take_up) {
            // A new mediator, or one with another journal.
            return match noted.is_some() || agree(ended.pose, self.start) {
                true => Resume::Here,
                false => Resume::Nowhere {
                    why: Some(format!(
                        "the robot ended at {}; nobody knows in which state: say so with `onboard ctl place X,Y,THETA --state STATE`",
                        place(ended.pose)
                    )),
                },
            };
        }
        let TakeUp {
            pose, fsm_state, ..
        } = take_up.cloned().unwrap_or_default();
        let heard = pose.as_ref().map(Pose2::from);
        let heard = heard.filter(|pose| pose.is_finite());
        // What it has done in a later one, nobody has heard: it does that again.
        let state = state_of(&fsm_state).or(noted);
        match (ended, heard, state) {
            (Some(ended), Some(heard), Some(state)) if agree(ended.pose, heard) => Resume::There {
                state: (noted != Some(state)).then_some(StateId(state)),
                why: format!(
                    "resuming where the robot was before it restarted: {}, state `{}`",
                    place(ended.pose),
                    self.states[usize::from(state)].name
                ),
            },
            _ => {
                let heard = heard.map_or(String::new(), |heard| {
                    format!(", and was heard of last at {}", place(heard))
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

fn place(at: Pose2) -> String {
    format!(
        "({:.2} m, {:.2} m, {:.2} rad)",
        at.x_m, at.y_m, at.theta_rad
    )
}

fn agree(one: Pose2, other: Pose2) -> bool {
    let way = one.between(other);
    way.x_m.hypot(way.y_m) <= AGREES_M && way.theta_rad.abs() <= AGREES_RAD
}
