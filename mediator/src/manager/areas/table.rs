//! All areas and where all robots are: who occupies what, and who waits for it.

use std::cmp::Reverse;
use std::sync::Arc;

use contract::level;
use contract::protocols::{AccessProtocol, RevocationProtocol};
use contract::wire::Access;
use coordination::protocol::Level;

use super::claim::Claim;
use super::occupant::Occupant;
use crate::journal::{ClosedRecord, Entry};
use crate::manager::alarm::BadReport;
use crate::manager::effects::Effects;
use crate::manager::names::Names;
use crate::manager::sessions::Sessions;
use crate::setup::Setup;

/// No array was run so often, no area was granted so often.
const MOST_RUNS: u64 = 1 << 31;
const MOST_FENCE: u64 = 1 << 62;

/// One area.
#[derive(Clone, Debug)]
pub(crate) struct Area {
    pub(crate) capacity: u32,
    /// Of the last grant.
    pub(crate) fence: u64,
    /// Of the last grant up to which the journal knew of all at the start.
    pub(super) known_fence: u64,
    /// Robots whose request waits, in the order in which they are served.
    pub(crate) queue: Vec<usize>,
    /// Robots that hold it, stand in it, or ask for it: nobody else needs to be looked at.
    pub(super) concerned: Vec<usize>,
    /// More robots were in it than it holds when it was last looked at.
    pub(super) overfull: bool,
    /// More bodies may have been, those of processes that do not speak for their robot included.
    pub(super) crowded: bool,
    /// An operator has closed it.
    pub(crate) closed: Option<ClosedRecord>,
    /// Something changed, and a waiting robot may now fit.
    changed: bool,
    /// Something changed, and coordinations have not looked.
    is_news: bool,
}

/// Where an area's robots are, and what they claim.
#[derive(Clone, Debug)]
pub(crate) struct Areas {
    pub(super) names: Arc<Names>,
    pub(super) access: AccessProtocol,
    pub(super) revocation: RevocationProtocol,
    pub(super) areas: Vec<Area>,
    pub(super) robots: Vec<Occupant>,
    /// Of the last request.
    pub(super) ticket: u64,
    /// Areas with `changed` set.
    changed: Vec<usize>,
    /// Areas with `is_news` set.
    news: Vec<usize>,
    /// Areas whose journal does not know of all grants.
    pub(super) adopted: Vec<usize>,
}

impl Areas {
    pub(crate) fn new(setup: &Setup, names: &Arc<Names>) -> Self {
        let areas = setup.areas.iter().map(|area| Area {
            capacity: area.capacity,
            fence: 0,
            known_fence: 0,
            queue: Vec::new(),
            concerned: Vec::new(),
            overfull: false,
            crowded: false,
            closed: None,
            changed: false,
            is_news: false,
        });
        Self {
            access: AccessProtocol::new(),
            revocation: RevocationProtocol::new(),
            areas: areas.collect(),
            robots: vec![Occupant::default(); names.robots().len()],
            ticket: 0,
            changed: Vec::new(),
            news: Vec::new(),
            adopted: Vec::new(),
            names: Arc::clone(names),
        }
    }

    // ---------------------------------------------------------------- questions

    pub(crate) fn len(&self) -> usize {
        self.areas.len()
    }

    pub(crate) fn area(&self, area: usize) -> &Area {
        &self.areas[area]
    }

    pub(crate) fn robot(&self, robot: usize) -> &Occupant {
        &self.robots[robot]
    }

    /// It is heard, and knows where it is: what it is granted it can use.
    pub(crate) fn can_use_grants(&self, robot: usize, sessions: &Sessions) -> bool {
        sessions.is_heard(robot) && self.robots[robot].located
    }

    /// Robots that may be in the area.
    pub(crate) fn occupants(&self, area: usize) -> impl Iterator<Item = usize> + '_ {
        let concerned = self.areas[area].concerned.iter().copied();
        concerned.filter(move |&robot| self.robots[robot].occupies(area))
    }

    /// It has the grant of an area in which it does not stand.
    pub(crate) fn may_enter(&self, robot: usize) -> bool {
        let occupant = &self.robots[robot];
        { occupant.claims.iter() }.any(|(area, claim)| claim.is_held() && !occupant.stands_in(area))
    }

    /// It has the grant of an area.
    pub(crate) fn has_any(&self, robot: usize) -> bool {
        { self.robots[robot].claims.iter() }.any(|(_, claim)| claim.is_held())
    }

    /// Areas in which a robot may be.
    pub(crate) fn occupied_by(&self, robot: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.areas.len()).filter(move |&area| self.robots[robot].occupies(area))
    }

    /// Nobody is let in.
    pub(crate) fn is_closed(&self, area: usize) -> bool {
        let intruded = self
            .occupants(area)
            .any(|robot| self.robots[robot].intrudes(area));
        self.areas[area].crowded || intruded || self.areas[area].closed.is_some()
    }

    /// What a report says of an area.
    pub(super) fn level_and_area(&self, access: &Access) -> Result<(Level, usize), BadReport> {
        let level = level::decode(access.level.as_ref())?;
        below("run", level.run.into(), MOST_RUNS)?;
        below("fence", access.fence, MOST_FENCE)?;
        let area = self.names.area(&access.area);
        Ok((level, area.ok_or(BadReport::UnknownArea)?))
    }

    /// The same of what this mediator does not know and takes over, `run` being what it knows of the array: that leaves half of
    /// all numbers to count on, whoever lies.
    pub(super) fn level_to_take_over(
        &self,
        access: &Access,
        run: impl FnOnce(usize) -> Option<u32>,
    ) -> Result<(Level, usize), BadReport> {
        let (level, area) = self.level_and_area(access)?;
        let known_run = run(area).map_or(0, u64::from);
        let known_fence = self.areas[area].fence;
        below("run", level.run.into(), (MOST_RUNS / 2).max(known_run + 1))?;
        below("fence", access.fence, (MOST_FENCE / 2).max(known_fence + 1))?;
        Ok((level, area))
    }

    // ---------------------------------------------------------------- bookkeeping

    pub(super) fn concern(&mut self, area: usize, robot: usize) {
        let concerned = &mut self.areas[area].concerned;
        if !concerned.contains(&robot) {
            concerned.push(robot);
        }
    }

    /// Drops the robot from the area's list when it neither occupies the area nor waits for it.
    pub(super) fn unconcern(&mut self, area: usize, robot: usize) {
        let occupant = &self.robots[robot];
        if !occupant.occupies(area) && !occupant.waits_for(area) {
            self.areas[area].concerned.retain(|&other| other != robot);
        }
    }

    /// Gives a claim the next ticket.
    pub(super) fn draw_ticket(ticket: &mut u64, claim: &mut Claim, now_ns: u64) {
        *ticket += 1;
        claim.ticket = *ticket;
        claim.passed = 0;
        claim.asked_ns = now_ns;
    }

    /// Where a robot with a ticket comes in the queue.
    fn rank(&self, area: usize, robot: usize) -> (Reverse<u32>, u64) {
        let claim = self.robots[robot].claim(area);
        let (ticket, passed) = claim.map_or((u64::MAX, 0), |claim| (claim.ticket, claim.passed));
        let name = &self.names.robots()[robot];
        (Reverse(name.priority_after(passed)), ticket)
    }

    /// A request was granted; those that have waited for longer age, where the site lets them.
    pub(super) fn pass(&mut self, area: usize, granted: u64, effects: &mut Effects) {
        let mut queue = std::mem::take(&mut self.areas[area].queue);
        for &robot in { queue.iter() }.filter(|&&robot| self.names.robots()[robot].ages()) {
            let claim = self.robots[robot].claims.get_mut(area);
            if let Some(claim) = claim.filter(|claim| claim.ticket < granted) {
                claim.passed = claim.passed.saturating_add(1);
                self.store_claim(robot, area, effects);
            }
        }
        queue.sort_by_key(|&robot| self.rank(area, robot));
        self.areas[area].queue = queue;
    }

    /// Puts a robot with a ticket into the queue, by priority and then by ticket.
    pub(super) fn enqueue(&mut self, area: usize, robot: usize) {
        let own = self.rank(area, robot);
        let queue = &self.areas[area].queue;
        let place = queue.partition_point(|&other| self.rank(area, other) <= own);
        self.areas[area].queue.insert(place, robot);
        self.concern(area, robot);
        self.touch(area);
    }

    pub(super) fn dequeue(&mut self, area: usize, robot: usize) {
        self.areas[area].queue.retain(|&other| other != robot);
    }

    /// Something changed in an area: it is looked at when areas are next served, and by coordinations.
    pub(crate) fn touch(&mut self, area: usize) {
        if !std::mem::replace(&mut self.areas[area].changed, true) {
            self.changed.push(area);
        }
        if !std::mem::replace(&mut self.areas[area].is_news, true) {
            self.news.push(area);
        }
    }

    pub(crate) fn touch_all(&mut self) {
        (0..self.areas.len()).for_each(|area| self.touch(area));
    }

    /// Whether a robot can use a grant has changed.
    pub(crate) fn touch_what_waits(&mut self, robot: usize) {
        let waits: Vec<usize> = self.robots[robot].waits().collect();
        waits.into_iter().for_each(|area| self.touch(area));
    }

    /// The next area to look at.
    pub(super) fn next_changed(&mut self) -> Option<usize> {
        let area = self.changed.pop()?;
        self.areas[area].changed = false;
        Some(area)
    }

    /// The next area of which there is news for coordinations.
    pub(crate) fn take_news(&mut self) -> Option<usize> {
        let area = self.news.pop()?;
        self.areas[area].is_news = false;
        Some(area)
    }

    pub(super) fn store_claim(&self, robot: usize, area: usize, effects: &mut Effects) {
        if let Some(claim) = self.robots[robot].claim(area) {
            effects.entries.push(Entry::Access {
                robot: self.names.robot_id(robot),
                area: self.names.area_id(area),
                record: claim.record(),
            });
        }
    }

    pub(super) fn store_fence(&self, area: usize, effects: &mut Effects) {
        effects.entries.push(Entry::Fence {
            area: self.names.area_id(area),
            fence: self.areas[area].fence,
        });
    }

    // ---------------------------------------------------------------- what others say

    /// Another process speaks for a robot, which does not know yet where it is.
    pub(crate) fn forget_place(&mut self, robot: usize) {
        self.robots[robot].forget_place();
    }

    /// Remembers what a robot was told of why it waits.
    pub(crate) fn note_why(&mut self, robot: usize, area: usize, now_ns: u64, why: String) {
        if let Some(claim) = self.robots[robot].claims.get_mut(area) {
            claim.why = (now_ns.max(1), why);
        }
    }

    /// An operator says that a robot is not in an area.
    pub(crate) fn leave(&mut self, robot: usize, area: usize) {
        self.robots[robot].leave(area);
    }

    /// A robot that is nowhere asks for nothing: its requests end, and it asks anew when it is back.
    pub(crate) fn withdraw(&mut self, robot: usize, effects: &mut Effects) {
        let waits: Vec<usize> = self.robots[robot].waits().collect();
        for area in waits {
            self.dequeue(area, robot);
            if let Some(claim) = self.robots[robot].claims.get_mut(area) {
                claim.abort();
            }
            self.unconcern(area, robot);
            self.touch(area);
            self.store_claim(robot, area, effects);
        }
    }

    /// Ends a robot's hold on an area, if it has one.
    pub(crate) fn end_hold(&mut self, robot: usize, area: usize, effects: &mut Effects) {
        let claim = self.robots[robot].claims.get_mut(area);
        if let Some(claim) = claim.filter(|claim| claim.is_held()) {
            claim.abort();
            self.store_claim(robot, area, effects);
        }
    }
}

fn below(what: &'static str, found: u64, most: u64) -> Result<(), BadReport> {
    if found < most {
        return Ok(());
    }
    Err(BadReport::TooLarge { what, found, most })
}
