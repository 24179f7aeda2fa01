//! An operator at the mediator who clears every area that he sees empty.

use sim::world::Rectangle;

use super::fleet::Stepped;
use super::mediator::SteppedMediator;
use crate::scenario::ScriptedKind;
use crate::shapes::{footprint, region, touch};

impl Stepped<'_> {
    /// Clears each area into which no body reaches, while that fault lasts.
    pub(super) fn clear_what_is_empty(&mut self) {
        let Some(mediator) = { self.mediator.as_mut() }
            .filter(|_| self.faults.lasts(ScriptedKind::ClearAreas, None))
        else {
            return;
        };
        let world = self.world.lock();
        let plans = { self.plans.robots.iter() }.map(|(_, plan)| plan);
        let robots = { plans.clone() }.map(|plan| &plan.robot);
        let bodies = robots.chain(self.clones.iter().map(|clone| &clone.config));
        let bodies: Vec<Rectangle> = { bodies.enumerate() }
            .filter_map(|(number, robot)| {
                let truth = world.truth(number)?;
                Some(footprint(robot).at(&truth.pose))
            })
            .collect();
        // All robots drive by one site.
        for area in { plans.take(1) }.flat_map(|plan| &plan.site.areas) {
            let place = region(&area.region);
            if !bodies.iter().any(|body| touch(body, &place)) {
                mediator.clear(&area.id);
            }
        }
    }

    /// The listener hears of it too: nobody has had such an area since.
    pub(super) fn note_cleared(&mut self, now_ns: u64) {
        let cleared = { self.mediator.as_mut() }.map(SteppedMediator::take_cleared);
        for area in cleared.unwrap_or_default() {
            let robots: Vec<&str> = self.robots.iter().map(|own| own.id.as_str()).collect();
            self.observations.cleared(&area, &robots, now_ns);
        }
        let absent = { self.mediator.as_mut() }.map(SteppedMediator::take_absent);
        for robot in absent.unwrap_or_default() {
            let plans = self.plans.robots.iter().take(1);
            for area in plans.flat_map(|(_, plan)| &plan.site.areas) {
                self.observations.cleared(&area.id, &[&robot], now_ns);
            }
        }
    }
}
