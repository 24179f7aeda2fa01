//! An operator at the mediator who closes every area, and opens them again.

use mediator::manager::Status;

use super::fleet::Stepped;
use crate::scenario::ScriptedKind;

impl Stepped<'_> {
    /// Sees to it that every area is closed while that fault lasts, and open else; `status`: as he finds them.
    pub(super) fn close_or_open(&mut self, status: &Status) {
        let closes = self.faults.lasts(ScriptedKind::CloseAreas, None);
        let Some(mediator) = &mut self.mediator else {
            return;
        };
        let others = { status.areas.iter() }.filter(|area| area.closed_by.is_some() != closes);
        others.for_each(|area| mediator.close_or_open(&area.id, closes));
    }
}
