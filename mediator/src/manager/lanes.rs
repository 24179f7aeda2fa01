//! An operator closes areas and opens them again while robots drive.

use super::error::{CloseError, UnknownArea};
use super::routing::Manager;
use crate::journal::ClosedRecord;

/// Who is still concerned when an area is closed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Inside {
    /// Robots that are in it, for all that is known: they may leave.
    pub standing: Vec<String>,
    /// Robots of which a second process is in it.
    pub seconds: Vec<String>,
    /// Robots to which it was granted and that are not in it: they are asked to give it back, and may be too near to stop.
    pub granted: Vec<String>,
}

impl Manager {
    /// An operator closes an area: nobody is let in any more, also after later starts, until [`open`](Self::open). Returns who
    /// is in it, or may still come.
    ///
    /// # Errors
    /// [`CloseError`] when the site has no such area, or this mediator stands by.
    pub fn close(
        &mut self,
        area_id: &str,
        record: ClosedRecord,
        now_ns: u64,
    ) -> Result<Inside, CloseError> {
        let area = self.known_area(area_id)?;
        self.takes_orders()?;
        self.areas.close(area, record, &mut self.effects);
        self.go_on(now_ns);
        let (own, seconds) = self.view(now_ns).bodies_in(area);
        let (standing, granted) = own.into_iter().partition(|&robot| {
            let own = self.areas.robot(robot);
            own.stands_in(area) || own.has_entered(area) && !own.placed
        });
        let names = |robots: Vec<usize>| -> Vec<String> {
            { robots.into_iter() }
                .map(|robot| self.names.robot_id(robot))
                .collect()
        };
        Ok(Inside {
            standing: names(standing),
            seconds: names(seconds),
            granted: names(granted),
        })
    }

    /// An operator opens an area again. Returns whether it was closed.
    ///
    /// # Errors
    /// [`CloseError`] when the site has no such area, or this mediator stands by.
    pub fn open(&mut self, area_id: &str, now_ns: u64) -> Result<bool, CloseError> {
        let area = self.known_area(area_id)?;
        self.takes_orders()?;
        let was_closed = self.areas.open(area, &mut self.effects);
        self.go_on(now_ns);
        Ok(was_closed)
    }

    pub(super) fn known_area(&self, area_id: &str) -> Result<usize, UnknownArea> {
        self.names.area(area_id).ok_or_else(|| UnknownArea {
            found: area_id.to_owned(),
            known: self.names.all_areas(),
        })
    }
}
