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

    /// Who has carried a second robot of one identity away sees where the mediator still takes it to stand, and says that it is gone, once
    /// nobody is there or may come.
    pub(super) fn clear_of_clones(&mut self) {
        let running: Vec<&str> = { self.clones.iter() }
            .filter(|own| own.is_running())
            .map(|own| own.of.as_str())
            .collect();
        let now_ns = self.now_ns();
        let Some((mediator, status)) = self.mediator.as_mut().zip(self.told.status(now_ns)) else {
            return;
        };
        let world = self.world.lock();
        let plans = { self.plans.robots.iter() }.map(|(_, plan)| plan);
        let bodies: Vec<Rectangle> = { plans.clone().enumerate() }
            .filter_map(|(number, plan)| {
                let truth = world.truth(number)?;
                Some(footprint(&plan.robot).at(&truth.pose))
            })
            .collect();
        let gone = { status.robots.iter() }.filter(|own| !running.contains(&own.id.as_str()));
        let mut areas: Vec<&String> = gone.flat_map(|own| &own.second_in).collect();
        areas.sort_unstable();
        areas.dedup();
        for id in areas {
            let site = { plans.clone() }.find_map(|plan| plan.site.area(id));
            let is_held =
                { status.areas.iter() }.any(|own| own.id == *id && !own.holders.is_empty());
            let is_free = site.is_some_and(|area| {
                let place = region(&area.region);
                !bodies.iter().any(|body| touch(body, &place))
            });
            if is_free && !is_held {
                mediator.clear(id);
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
