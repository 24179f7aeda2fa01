//! Granting: who is let into an area next.

use super::reservations::Reservations;
use super::table::Areas;
use crate::manager::alarm::Alarm;
use crate::manager::effects::Effects;
use crate::manager::sessions::Sessions;

impl Areas {
    /// Grants what can be granted in every area where something changed, and asks for grants back that coordinations need.
    pub(crate) fn serve(
        &mut self,
        sessions: &Sessions,
        reservations: &mut dyn Reservations,
        effects: &mut Effects,
    ) {
        while let Some(area) = self.next_changed() {
            let own = &self.areas[area];
            let seconds =
                { own.concerned.iter() }.map(|&robot| self.robots[robot].seconds.bodies(area));
            let fits = own.concerned.len() + seconds.sum::<usize>() <= own.capacity as usize;
            if own.queue.is_empty() && fits && !self.is_closed(area) {
                // Nobody waits, and there are not too many.
                continue;
            }
            let inside: Vec<usize> = self.occupants(area).collect();
            self.judge_capacity(area, &inside, sessions, effects);
            if self.is_closed(area) {
                // One that is on its way would meet whoever should not be there.
                self.keep_out(area, effects);
            }
            self.serve_area(area, inside, sessions, reservations, effects);
        }
        self.revoke_what_is_kept(sessions, reservations, effects);
    }

    fn serve_area(
        &mut self,
        area: usize,
        mut inside: Vec<usize>,
        sessions: &Sessions,
        reservations: &mut dyn Reservations,
        effects: &mut Effects,
    ) {
        let own = &self.areas[area];
        let capacity = own.capacity as usize;
        let nobody_fits =
            inside.len() >= capacity && !own.queue.iter().any(|robot| inside.contains(robot));
        // Until every robot of the journal has reported, one of them may be in this area.
        if !sessions.awaited().is_empty() || own.queue.is_empty() || nobody_fits {
            return;
        }
        let kept = reservations.kept(area);
        let mut order = own.queue.clone();
        // Whoever stands there already comes first: letting somebody else in would only make it worse.
        order.sort_by_key(|&robot| (!self.robots[robot].stands_in(area), !kept.contains(&robot)));
        for robot in order {
            if !self.can_use_grants(robot, sessions) {
                // It could not use the grant; the next one may.
                continue;
            }
            let others = self.bodies_besides(robot, area, &inside);
            if self.areas[area].crowded || others >= capacity {
                return;
            }
            let stands_there = self.robots[robot].stands_in(area);
            // Of two that were not let in and stand there, each would wait for the other to leave first.
            let intruded =
                { inside.iter() }.any(|&other| other != robot && self.robots[other].intrudes(area));
            if !stands_there && (intruded || self.areas[area].closed.is_some()) {
                // Those behind it do not stand there either.
                return;
            }
            if !stands_there && !kept.contains(&robot) {
                let still_kept = { kept.iter() }
                    .filter(|&&other| !self.robots[other].occupies(area))
                    .count();
                // A way out that is not empty may be one that the net keeps for others.
                let stands_in = &self.robots[robot].stands_in[..];
                let stands_in = if others == 0 { stands_in } else { &[] };
                if others + still_kept >= capacity || reservations.decide(area, robot, stands_in) {
                    continue;
                }
            }
            self.grant(area, robot, reservations, effects);
            inside.clear();
            inside.extend(self.occupants(area));
        }
    }

    /// How many bodies may be in an area besides that of the process that speaks for a robot: where another one has its name,
    /// the robot is no exception.
    fn bodies_besides(&self, robot: usize, area: usize, inside: &[usize]) -> usize {
        let bodies = inside.iter().map(|&other| {
            let own = &self.robots[other];
            let has = other != robot && own.has(area);
            usize::from(has) + own.seconds.bodies(area)
        });
        bodies.sum()
    }

    fn grant(
        &mut self,
        area: usize,
        robot: usize,
        reservations: &mut dyn Reservations,
        effects: &mut Effects,
    ) {
        // Larger than every fence of this area before.
        let fence = self.areas[area].fence + 1;
        let occupant = &mut self.robots[robot];
        let claim = occupant.claims.get_mut(area);
        let ticket = claim.as_ref().map_or(0, |claim| claim.ticket);
        if !claim.is_some_and(|claim| claim.grant(&self.access, fence)) {
            return;
        }
        occupant.found_in.retain(|&other| other != area);
        self.areas[area].fence = fence;
        self.dequeue(area, robot);
        self.pass(area, ticket, effects);
        effects.counters.grants += 1;
        reservations.granted(robot, area, effects);
        self.store_fence(area, effects);
        self.store_claim(robot, area, effects);
        // Why others go on waiting, they hear with their next level.
        effects.tell(robot);
    }

    /// Notices when an area holds more than it can, and when that is over. All bodies count that may be there, also those of
    /// processes that do not speak for their robot; who has said so of itself is told to people.
    fn judge_capacity(
        &mut self,
        area: usize,
        inside: &[usize],
        sessions: &Sessions,
        effects: &mut Effects,
    ) {
        let capacity = self.areas[area].capacity;
        let is_known = sessions.awaited().is_empty();
        let bodies = inside.iter().map(|&robot| {
            let own = &self.robots[robot];
            // As long as somebody has not reported, where one stands is a guess of before the start. What others were granted before
            // it they may still use.
            // Who has left and keeps the area comes back.
            let is_in = if is_known {
                own.has(area)
            } else {
                own.holds(area) || own.placed && own.stands_in(area)
            };
            usize::from(is_in) + own.seconds.bodies(area)
        });
        let crowded = bodies.sum::<usize>() > capacity as usize;
        let inside: Vec<usize> = { inside.iter().copied() }
            .filter(|&robot| self.robots[robot].is_or_will_be_in(area))
            .collect();
        let overfull = is_known && inside.len() > capacity as usize;
        self.areas[area].crowded = crowded;
        let was_overfull = std::mem::replace(&mut self.areas[area].overfull, overfull);
        if overfull && !was_overfull {
            effects.alarms.push(Alarm::Overfull {
                area: self.names.area_id(area),
                capacity,
                found: inside.len(),
                robots: self.names.robot_list(inside),
            });
        }
    }
}
