//! What people do to a fleet: orders at any moment, robots carried away and put back, and poses that are wrong.

use super::UNKNOWN_MS;
use super::fleet::{Broken, Fleet};
use super::mediators::Mediator;
use super::robot::{Mistake, Robot};
use crate::random::Random;
use contract::timing::ENTERS_NO_MORE_NS;
use mediator::journal::ClosedRecord;
use mediator::manager::ClearError;

impl Fleet {
    /// An operator orders something of one of the mediators. He says what he sees, and knows nothing of grants.
    pub fn operate(&mut self, random: &mut Random) {
        if random.below(10) != 0 {
            return;
        }
        let number = random.below(self.mediators.len() as u64) as usize;
        let robot = random.below(self.robots.len() as u64) as usize;
        match random.below(12) {
            0..6 => self.clear_what_is_empty(number, random),
            6 if random.chance(10) => self.take_away(robot),
            7 | 8 => self.say_absent(number, robot),
            9 if random.chance(20) => self.robots[robot].is_put_back(self.now_ms),
            10 if random.chance(20) => self.end_a_coordination(number, random),
            11 => self.close_or_open(number, random),
            _ => {}
        }
    }

    fn clear_what_is_empty(&mut self, number: usize, random: &mut Random) {
        let area = random.below(self.floor.limits.len() as u64) as usize;
        let mut seconds = self.seconds.iter().filter(|own| own.is_there);
        let is_empty = { self.robots.iter() }
            .all(|robot| !robot.stands_in(&self.floor).contains(&area))
            && seconds.all(|own| !self.floor.spots[own.spot].contains(&area));
        let (id, now_ns) = (self.floor.name(area), self.now_ms * 1_000_000);
        let manager = self.mediators[number].manager.as_mut();
        if let Some(manager) = manager.filter(|_| is_empty) {
            self.tally.orders += 1;
            let early_ns = match self.broken {
                Some(Broken::ClearsAtOnce) => ENTERS_NO_MORE_NS,
                _ => 0,
            };
            match manager.clear(id, true, now_ns + early_ns) {
                Ok(done) => self.tally.cleared += u64::from(!done.of.is_empty()),
                Err(ClearError::MayEnter { .. }) => self.tally.not_yet_cleared += 1,
                Err(_) => {}
            }
        }
    }

    /// Somebody switches a robot off, and carries it off the floor.
    fn take_away(&mut self, robot: usize) {
        let outside = self.floor.outside();
        self.end_seconds_that_were_not_found(robot);
        let robot = &mut self.robots[robot];
        if let Some(process) = &robot.process {
            self.tally.add_client(&process.client.counters());
        }
        robot.is_taken_to(outside);
        self.tally.taken_away += 1;
    }

    fn say_absent(&mut self, number: usize, robot: usize) {
        let (robot, now_ns) = (&self.robots[robot], self.now_ms * 1_000_000);
        let manager = self.mediators[number].manager.as_mut();
        if let Some(manager) = manager.filter(|_| robot.is_away) {
            self.tally.orders += 1;
            self.tally.absent += u64::from(manager.absent(&robot.id, true, now_ns).is_ok());
        }
    }

    /// The process of a robot ends for good that asks for an area, and stands where all of them fit. Returns which, if there is one.
    pub fn lose_one_that_asks(&mut self) -> Option<usize> {
        let now_ns = self.now_ms * 1_000_000;
        let manager = self.mediators.first()?.manager.as_ref()?;
        let areas = manager.status(now_ns).areas;
        let all = self.robots.len();
        let lost = self.robots.iter().position(|robot| {
            let asks = areas.iter().any(|area| area.waiting.contains(&robot.id));
            let holds = { areas.iter().zip(&self.floor.limits) }.any(|(area, &limit)| {
                let mut holders = area.holders.iter();
                (limit as usize) < all && holders.any(|(id, _)| *id == robot.id)
            });
            let mut stands_in = robot.stands_in(&self.floor).into_iter();
            asks && !holds
                && robot.stands()
                && stands_in.all(|area| self.floor.limits[area] as usize >= all)
        })?;
        let robot = &mut self.robots[lost];
        let was = robot.spot;
        robot.is_taken_to(was);
        Some(lost)
    }

    /// People see that a robot is not where it was let in, if it was, before it counted as silent. Or they say that it is absent, and
    /// carry it away, as they must where it is awaited.
    pub fn look_after(&mut self, robot: usize, is_absent: bool) {
        let (now_ns, outside) = (self.now_ms * 1_000_000, self.floor.outside());
        let there = self.robots[robot].stands_in(&self.floor);
        let id = &self.robots[robot].id;
        let manager = self.mediators[0].manager.as_mut().expect("it runs");
        let status = manager.status(now_ns);
        if is_absent || status.awaited.contains(id) {
            manager
                .absent(id, true, now_ns)
                .expect("it enters nothing any more");
            self.robots[robot].is_taken_to(outside);
            return;
        }
        for (area, own) in status.areas.iter().enumerate() {
            if !there.contains(&area) && own.holders.iter().any(|(holder, _)| holder == id) {
                // Somebody else may be in it.
                let _ = manager.clear(&own.id, false, now_ns);
            }
        }
    }

    fn end_a_coordination(&mut self, number: usize, random: &mut Random) {
        let now_ns = self.now_ms * 1_000_000;
        let Some(manager) = self.mediators[number].manager.as_mut() else {
            return;
        };
        let mut running = manager.status(now_ns).coordinations;
        running.retain(|own| !own.over);
        if running.is_empty() {
            return;
        }
        let own = &running[random.below(running.len() as u64) as usize];
        let stands_by = manager.stands_by();
        let ended = manager.end(&own.number.to_string(), now_ns);
        assert!(ended.is_ok() || stands_by, "it runs: {ended:?}");
        self.tally.orders += 1;
        self.tally.ended += u64::from(ended.is_ok());
    }

    fn close_or_open(&mut self, number: usize, random: &mut Random) {
        let area = random.below(self.floor.limits.len() as u64) as usize;
        let (id, now_ns) = (self.floor.name(area), self.now_ms * 1_000_000);
        // Where two go on, each closes for its own robots only.
        let goes_on = |own: &Mediator| own.manager.as_ref().is_none_or(|own| !own.stands_by());
        let by_one = self.mediators.iter().filter(|own| goes_on(own)).count() <= 1;
        let Some(manager) = self.mediators[number].manager.as_mut() else {
            return;
        };
        self.tally.orders += 1;
        // Mostly open.
        if random.chance(20) {
            let by = ClosedRecord {
                who: "user 1000".to_owned(),
                ..ClosedRecord::default()
            };
            let ignored = self.broken == Some(Broken::IgnoresClosed);
            if ignored || manager.close(id, by, now_ns).is_ok() {
                self.tally.closed += 1;
                if by_one {
                    self.closed.entry(area).or_insert(self.now_ms);
                }
            }
        } else if manager.open(id, now_ns).is_ok() {
            self.closed.remove(&area);
        }
    }

    /// A robot that begins to reach into an area does not while that is closed. What was granted before it may still enter for as
    /// long as any grant, and so what it has left just now; and whoever says that it cannot stop before it is believed.
    pub fn assert_enters_nothing_closed(&self, robot: &Robot) {
        let Some(next) = robot.crossing.filter(|_| !robot.was_mistaken) else {
            return;
        };
        let here = &self.floor.spots[robot.spot];
        let (before, came_ms) = robot.came;
        let was_in = |area| self.floor.spots[before].contains(area);
        let mut closed = { self.floor.spots[next].iter() }
            .filter(|area| !here.contains(area) && !robot.insists_on(**area))
            .filter_map(|area| {
                let since_ms = *self.closed.get(area)?;
                Some(if was_in(area) {
                    since_ms.max(came_ms)
                } else {
                    since_ms
                })
            });
        assert!(
            closed.all(|since_ms| self.now_ms < since_ms + UNKNOWN_MS),
            "seed {}, {} ms: {} enters a closed area: {}",
            self.seed,
            self.now_ms,
            robot.id,
            self.explain()
        );
    }

    pub fn open_all(&mut self) {
        self.closed.clear();
        let now_ns = self.now_ms * 1_000_000;
        for manager in { self.mediators.iter_mut() }.filter_map(|own| own.manager.as_mut()) {
            for area in &self.floor.setup.areas {
                // One that stands by does it when it goes on.
                let _ = manager.open(&area.id, now_ns);
            }
        }
    }

    /// A robot loses its pose, or is given a wrong one, for a while.
    pub fn mislead_somebody(&mut self, random: &mut Random) {
        let now_ms = self.now_ms;
        for robot in &mut self.robots {
            let ended = robot.mistake.take_if(|(_, until_ms)| now_ms >= *until_ms);
            robot.is_found(ended);
        }
        if random.below(100) != 0 {
            return;
        }
        let (spots, half) = (self.floor.spots.len() as u64, random.chance(50));
        let robot = random.below(self.robots.len() as u64) as usize;
        let robot = &mut self.robots[robot];
        if robot.mistake.is_some() || robot.process.is_none() {
            return;
        }
        let until_ms = now_ms + random.below(6_000);
        if half {
            robot.mistake = Some((Mistake::Lost, until_ms));
            self.tally.lost += 1;
        } else if robot.stands() {
            let elsewhere = random.below(spots) as usize;
            robot.mistake = Some((Mistake::Elsewhere(elsewhere), until_ms));
            robot.was_mistaken = self.broken != Some(Broken::WrongPose);
            self.tally.mistaken += 1;
        }
    }
}
