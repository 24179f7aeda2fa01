//! An operator at the mediator who closes every area and opens them again, or ends what he sees run.

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

    /// Ends every coordination that runs, as he was told last.
    pub(super) fn end_coordinations(&mut self) {
        let now_ns = self.now_ns();
        let Some(mediator) = &mut self.mediator else {
            return;
        };
        let running = { self.told.status(now_ns).into_iter() }
            .flat_map(|status| &status.coordinations)
            .filter(|own| !own.over);
        running.for_each(|own| mediator.end(own.number));
    }
}
