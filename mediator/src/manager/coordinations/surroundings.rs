//! What coordinations see and change besides themselves.

use crate::manager::areas::Areas;
use crate::manager::effects::Effects;
use crate::manager::sessions::Sessions;
use crate::nets::Instance;

/// The rest of the manager, for one step.
pub(crate) struct Surroundings<'a> {
    pub(crate) sessions: &'a mut Sessions,
    pub(crate) areas: &'a mut Areas,
    pub(crate) effects: &'a mut Effects,
    pub(crate) now_ns: u64,
}

impl Surroundings<'_> {
    /// A coordination has changed: its robots are told, and it may let them or others into areas.
    pub(super) fn news_for(&mut self, instance: &Instance) {
        for robot in instance.robots() {
            self.effects.tell(robot);
            // Whether it is let into others depends on who controls it.
            self.areas.touch_what_waits(robot);
        }
        for &area in &instance.plan.concerned {
            self.areas.touch(area);
        }
    }
}
