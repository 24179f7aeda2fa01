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
        let empty = self.areas_with(<[usize]>::is_empty);
        if let Some(mediator) = &mut self.mediator {
            empty.into_iter().for_each(|id| mediator.clear(id));
        }
    }

    /// Who has carried a second robot of one identity away, or a robot that was off, sees where the mediator still takes its body to stand, and
    /// says that it is gone, once nobody is there or may come; or, when all faults are over, once only the robot itself is there.
    pub(super) fn clear_of_other_bodies(&mut self) {
        let now_ns = self.now_ns();
        let Some(status) = self.told.status(now_ns) else {
            return;
        };
        let runs = |id: &str| {
            let mut running = self.clones.iter().filter(|own| own.is_running());
            running.any(|own| own.of == id)
        };
        let gone: Vec<_> = { status.robots.iter() }
            .filter(|own| !runs(&own.id))
            .collect();
        let blocked: Vec<&String> = gone.iter().flat_map(|own| &own.second_in).collect();
        if blocked.is_empty() {
            return;
        }
        let is_held = |id: &str| {
            let mut held = status.areas.iter().filter(|own| !own.holders.is_empty());
            held.any(|own| own.id == id)
        };
        let mut clear = self.areas_with(<[usize]>::is_empty);
        clear.retain(|id| blocked.iter().any(|own| own == id) && !is_held(id));
        let mut clear_of_seconds = Vec::new();
        if self.faults.are_over() {
            for own in gone.iter().filter(|own| own.heard) {
                let is_own =
                    |number: usize| self.robots.get(number).is_some_and(|it| it.id == own.id);
                let mut alone = self.areas_with(|bodies| matches!(*bodies, [one] if is_own(one)));
                alone.retain(|id| own.second_in.iter().any(|area| area == id) && !is_held(id));
                clear_of_seconds.extend(alone);
            }
        }
        if let Some(mediator) = &mut self.mediator {
            clear.into_iter().for_each(|id| mediator.clear(id));
            let robot_stays = clear_of_seconds.into_iter();
            robot_stays.for_each(|id| mediator.clear_of_seconds(id));
        }
    }

    /// Areas of which this holds for the numbers of the bodies that reach into them.
    fn areas_with(&self, holds: impl Fn(&[usize]) -> bool) -> Vec<&'a str> {
        let world = self.world.lock();
        let plans = { self.plans.robots.iter() }.map(|(_, plan)| plan);
        let robots = { plans.clone() }.map(|plan| &plan.robot);
        let bodies = robots.chain(self.clones.iter().map(|clone| &clone.config));
        let bodies: Vec<(usize, Rectangle)> = { bodies.enumerate() }
            .filter_map(|(number, robot)| {
                let truth = world.truth(number)?;
                Some((number, footprint(robot).at(&truth.pose)))
            })
            .collect();
        // All robots drive by one site.
        let areas = { plans.take(1) }.flat_map(|plan| &plan.site.areas);
        let found = areas.filter(|area| {
            let place = region(&area.region);
            let inside = bodies.iter().filter(|(_, body)| touch(body, &place));
            let inside: Vec<usize> = inside.map(|(number, _)| *number).collect();
            holds(&inside)
        });
        found.map(|area| area.id.as_str()).collect()
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
