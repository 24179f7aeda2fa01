//! An operator at the mediator who clears every area that he sees empty.

use sim::world::Rectangle;

use super::fleet::Stepped;
use super::mediator::SteppedMediator;
use crate::scenario::ScriptedKind;
use crate::shapes::{footprint, region, touch};

impl<'a> Stepped<'a> {
    /// Clears each area into which no body reaches, while that fault lasts.
    pub(super) fn clear_what_is_empty(&mut self) {
        if self.mediator.is_none() || !self.faults.lasts(ScriptedKind::ClearAreas, None) {
            return;
        }
        let empty = self.empty_areas();
        if let Some(mediator) = &mut self.mediator {
            empty.into_iter().for_each(|id| mediator.clear(id));
        }
    }

    /// Who has carried a second robot of one identity away, or a robot that was off, sees where the mediator still takes its body to stand, and
    /// says that it is gone, once nobody is there or may come.
    pub(super) fn clear_of_other_bodies(&mut self) {
        let now_ns = self.now_ns();
        let Some(status) = self.told.status(now_ns) else {
            return;
        };
        let runs = |id: &str| {
            let mut running = self.clones.iter().filter(|own| own.is_running());
            running.any(|own| own.of == id)
        };
        let gone = { status.robots.iter() }.filter(|own| !runs(&own.id));
        let blocked: Vec<&String> = gone.flat_map(|own| &own.second_in).collect();
        if blocked.is_empty() {
            return;
        }
        let is_held = |id: &str| {
            let mut held = status.areas.iter().filter(|own| !own.holders.is_empty());
            held.any(|own| own.id == id)
        };
        let mut clear = self.empty_areas();
        clear.retain(|id| blocked.iter().any(|own| own == id) && !is_held(id));
        if let Some(mediator) = &mut self.mediator {
            clear.into_iter().for_each(|id| mediator.clear(id));
        }
    }

    /// Areas into which no body reaches.
    fn empty_areas(&self) -> Vec<&'a str> {
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
        let areas = { plans.take(1) }.flat_map(|plan| &plan.site.areas);
        let empty = areas.filter(|area| {
            let place = region(&area.region);
            !bodies.iter().any(|body| touch(body, &place))
        });
        empty.map(|area| area.id.as_str()).collect()
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
