//! What coordinations decide about areas.

use crate::manager::effects::Effects;
use crate::nets::GivenBack;

/// An area that is kept for a robot and was not granted to it since.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reserved {
    pub(crate) area: usize,
    pub(crate) robot: usize,
}

/// Asked before a grant, told after it. Nets decide who is next, never that two robots fit where one does.
pub(crate) trait Reservations {
    /// Robots for which an area is kept.
    fn kept(&self, area: usize) -> Vec<usize>;

    /// Nobody but a net lets this robot into this area. A net that does not run leaves one that is caught in its areas a way out, where it
    /// `stands_in` one of them.
    fn decide(&self, area: usize, robot: usize, stands_in: &[usize]) -> bool;

    /// All areas that are kept and were not granted since, in the order of the coordinations' start.
    fn open(&self) -> Vec<Reserved>;

    /// A robot was granted an area.
    fn granted(&mut self, robot: usize, area: usize, effects: &mut Effects);

    /// A robot has given an area back.
    fn gave_back(&mut self, robot: usize, area: usize, how: GivenBack, effects: &mut Effects);
}
