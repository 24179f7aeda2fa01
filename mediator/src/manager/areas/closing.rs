//! Areas that an operator has closed: nobody is let in, until they are opened again.

use super::table::Areas;
use crate::journal::{ClosedRecord, Entry};
use crate::manager::effects::Effects;

impl Areas {
    /// Closes an area. Grants that are not used yet are asked back when it is served next.
    pub(crate) fn close(&mut self, area: usize, record: ClosedRecord, effects: &mut Effects) {
        self.areas[area].closed = Some(record);
        self.store_closed(area, effects);
        self.touch(area);
    }

    /// Opens an area again. Returns whether it was closed.
    pub(crate) fn open(&mut self, area: usize, effects: &mut Effects) -> bool {
        let was_closed = self.areas[area].closed.take().is_some();
        if was_closed {
            self.store_closed(area, effects);
            self.touch(area);
        }
        was_closed
    }

    fn store_closed(&self, area: usize, effects: &mut Effects) {
        effects.entries.push(Entry::Closed {
            area: self.names.area_id(area),
            record: self.areas[area].closed.clone(),
        });
    }
}
