//! Where a robot begins: at its start, or where the process before has left it.

use skills::navigator::Navigator;

use crate::composition::checkpoint::{Checkpoint, Unusable};
use crate::composition::plan::{Plan, PlanError};
use crate::fleet::{Began, Start};
use crate::realtime::log::LogSender;

/// Where the robot begins.
pub struct Beginning<'a> {
    /// Navigation, there.
    pub navigator: Box<Navigator>,
    /// Where an operator puts a robot that is lost.
    pub start: Start,
    /// What the process before has left, if the robot goes on from there.
    pub left: Option<&'a Checkpoint>,
    /// What the fleet is to know of that.
    pub began: Began,
}

impl<'a> Beginning<'a> {
    /// At the robot's start, or where the process before has left it: by its checkpoint, or, `without` one, by how it has ended.
    ///
    /// # Errors
    /// As [`Plan::navigator`].
    pub fn of(
        plan: &Plan,
        left: Option<&'a Checkpoint>,
        without: Began,
        log: &LogSender,
    ) -> Result<Self, PlanError> {
        let mut navigator = Box::new(plan.navigator()?);
        let start = plan.start(navigator.machine().state());
        let used = left.filter(|left| navigator.resume(&left.navigator));
        if left.is_some() && used.is_none() {
            log.warn(format!("the checkpoint is not used: {}", Unusable::Lost));
        }
        let began = used.map_or(without, |_| Began::GoesOn);
        if let Began::Afresh { ended: Some(at) } = &began {
            // What the fleet has to say to that, it says once it is there; until then nothing else is taken for its place.
            let std_m = at.std_m.max(start.std_m);
            navigator.relocate(at.pose, std_m, at.std_rad.max(start.std_rad));
            if let Some(state) = navigator.machine().state_id(&at.state) {
                navigator.restart_in(state);
            }
        }
        Ok(Self {
            navigator,
            start,
            left: used,
            began,
        })
    }
}
