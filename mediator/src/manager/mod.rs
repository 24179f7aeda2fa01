//! The area manager: protocol 1 with every robot, for every area, and protocol 2 with the robots of coordinations.
//!
//! **Who may be where.** An area is *occupied* by every robot that was granted it, that stands in it by its own report, or
//! that did so when it was last heard. A request is granted when the area's other occupants leave room, in the order of
//! priority and then of asking; whoever stands in an area when it registers comes before all who wait outside.
//!
//! **What blocks.** A silent robot goes on occupying what it occupied. An intruder, or more robots than an area holds,
//! close the area to everyone until it is right again. After a restart nothing is granted until every robot that the
//! journal knows to be somewhere has reported, or its areas were cleared.
//!
//! **Coordinations.** An area that a net governs is entered only when the net says so; a robot whose discrete control is
//! taken gets only the areas of its orders, and before everybody else. Both still by protocol 1: nets decide who is next,
//! never that two fit where one does.
//!
//! The manager is pure: the same reports at the same times give the same entries and messages. After every call, write
//! [`Manager::entries`] to the journal, then send what [`Manager::next_message`] gives.

mod alarm;
mod coordinate;
mod explain;
mod message;
mod report;
mod revoke;
mod robot;
mod run;

pub use alarm::{Alarm, BadReport};
pub use explain::{AreaStatus, CoordinationStatus, RobotStatus, Status, UnknownRobot};

use std::sync::Arc;

use crate::journal::{Entry, Stored};
use crate::nets::Plan;
use crate::setup::{Index, Setup, SetupError, index};
use contract::wire::MediatorReport;
use coordinate::{Coordinator, KeptChange};
use coordination::protocol::MergeError;
use revoke::RevocationProtocol;
use robot::Robot;
use run::{AccessProtocol, Run};

/// A process that has not repeated its session by then is taken for gone.
const CANDIDATE_NS: u64 = 5_000_000_000;
/// A level is sent to every robot at least this often.
const LEVEL_NS: u64 = 200_000_000;

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Reports taken in.
    pub reports: u64,
    /// Reports from before: of an earlier boot or session, or with an old sequence number.
    pub stale: u64,
    /// Parts of reports that made no sense.
    pub bad: u64,
    /// Levels about another grant than the present one.
    pub other_fence: u64,
    /// Grants given.
    pub grants: u64,
    /// Requests taken in.
    pub requests: u64,
    /// Grants asked back.
    pub revocations: u64,
    /// Areas given back.
    pub given_back: u64,
    /// Levels taken over from a robot because the journal was behind.
    pub adopted: u64,
    /// Runs that an operator cleared.
    pub cleared: u64,
}

#[derive(Clone, Debug)]
struct Area {
    id: String,
    capacity: u32,
    /// Of the last grant.
    fence: u64,
    /// Robots whose request waits, in the order in which they are served.
    queue: Vec<usize>,
    /// Robots that hold it, stand in it, or ask for it: all that must be looked at.
    concerned: Vec<usize>,
    /// It was closed when last looked at.
    overfull: bool,
    /// Something changed, and a waiting robot may now fit.
    dirty: bool,
}

/// Why a mediator cannot go on from its journal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RestoreError {
    /// The site's own areas and robots.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The journal is of another site, or that site has changed.
    #[error(
        "the journal knows {kind} `{id}`, which the site does not have: use the journal's own site file, or begin a new journal when every robot stands still"
    )]
    Unknown {
        /// Area or robot.
        kind: &'static str,
        /// The id.
        id: String,
    },
    /// A stored level that the protocol does not have.
    #[error("the journal's level of robot `{robot}` and area `{area}` is none: {error}")]
    Level {
        /// The robot.
        robot: String,
        /// The area.
        area: String,
        /// What is wrong with it.
        error: MergeError,
    },
}

/// The manager of one site.
#[derive(Debug)]
pub struct Manager {
    site: String,
    silent_after_ns: u64,
    epoch: u64,
    protocol: AccessProtocol,
    revoking: RevocationProtocol,
    coordinator: Coordinator,
    areas: Vec<Area>,
    robots: Vec<Robot>,
    area_index: Index,
    robot_index: Index,
    /// Robots known to be somewhere that have not reported since the start.
    awaited: Vec<usize>,
    /// Of the last request.
    ticket: u64,
    /// Areas with `dirty` set.
    dirty: Vec<usize>,
    entries: Vec<Entry>,
    news: Vec<usize>,
    /// Refusals for robots that the site does not list.
    strangers: Vec<MediatorReport>,
    alarms: Vec<Alarm>,
    counters: Counters,
}

impl Manager {
    /// Takes up where the journal ends; an empty one is a first start. Coordinates nobody.
    ///
    /// # Errors
    /// As [`Manager::with_plans`].
    pub fn new(setup: &Setup, stored: &Stored, now_ns: u64) -> Result<Self, RestoreError> {
        Self::with_plans(setup, Vec::new(), stored, now_ns)
    }

    /// Takes up where the journal ends; an empty one is a first start. `plans` are made for this setup.
    ///
    /// # Errors
    /// [`RestoreError`] when the setup makes no sense, or the journal is of another one.
    pub fn with_plans(
        setup: &Setup,
        plans: Vec<Arc<Plan>>,
        stored: &Stored,
        now_ns: u64,
    ) -> Result<Self, RestoreError> {
        for area in &setup.areas {
            if area.capacity == 0 {
                return Err(SetupError::NoCapacity(area.id.clone()).into());
            }
        }
        let areas = setup.areas.iter().map(|area| Area {
            id: area.id.clone(),
            capacity: area.capacity,
            fence: 0,
            queue: Vec::new(),
            concerned: Vec::new(),
            overfull: false,
            dirty: false,
        });
        let robots = setup
            .robots
            .iter()
            .map(|robot| Robot::new(&robot.id, &robot.role, robot.priority));
        let silent_after_ns = u64::try_from(setup.silent_after.as_nanos()).unwrap_or(u64::MAX);
        let mut manager = Self {
            site: setup.site.clone(),
            silent_after_ns,
            epoch: stored.epoch + 1,
            protocol: AccessProtocol::new(),
            revoking: RevocationProtocol::new(),
            coordinator: Coordinator::new(plans, setup.areas.len()),
            areas: areas.collect(),
            robots: robots.collect(),
            area_index: index("area", setup.areas.iter().map(|area| &area.id))?,
            robot_index: index("robot", setup.robots.iter().map(|robot| &robot.id))?,
            awaited: Vec::new(),
            ticket: 0,
            dirty: Vec::new(),
            entries: Vec::new(),
            news: Vec::new(),
            strangers: Vec::new(),
            alarms: Vec::new(),
            counters: Counters::default(),
        };
        manager.entries.push(Entry::Epoch(manager.epoch));
        manager.place_unheard(setup, stored)?;
        manager.restore(stored, now_ns)?;
        manager.restore_revocations(stored)?;
        manager.restore_coordinations(stored, now_ns);
        Ok(manager)
    }

    /// A robot that was never heard of stands where the site file lets it start.
    fn place_unheard(&mut self, setup: &Setup, stored: &Stored) -> Result<(), SetupError> {
        for (robot, setup) in setup.robots.iter().enumerate() {
            for id in &setup.starts_in {
                let area = self.area_index.get(id).copied();
                let area = area.ok_or_else(|| SetupError::UnknownStart {
                    robot: setup.id.clone(),
                    area: id.clone(),
                })?;
                if !stored.robots.contains_key(&setup.id) {
                    self.robots[robot].stands_in.push(area);
                    self.concern(area, robot);
                }
            }
            self.robots[robot].stands_in.sort_unstable();
        }
        Ok(())
    }

    fn restore(&mut self, stored: &Stored, now_ns: u64) -> Result<(), RestoreError> {
        for (area, &fence) in &stored.fences {
            let area = self.known_area(area)?;
            self.areas[area].fence = fence;
        }
        for (id, record) in &stored.robots {
            let robot = self.known_robot(id)?;
            let stands_in = record.stands_in.iter();
            let stands_in: Vec<usize> = stands_in
                .map(|area| self.known_area(area))
                .collect::<Result<_, _>>()?;
            for &area in &stands_in {
                self.concern(area, robot);
            }
            self.robots[robot].restore(record.clone(), stands_in);
        }
        for ((robot_id, area_id), &record) in &stored.access {
            let (robot, area) = (self.known_robot(robot_id)?, self.known_area(area_id)?);
            let mut run = self
                .protocol
                .resume(record)
                .map_err(|error| RestoreError::Level {
                    robot: robot_id.clone(),
                    area: area_id.clone(),
                    error,
                })?;
            run.asked_ns = now_ns;
            self.ticket = self.ticket.max(run.ticket);
            let waits = run.waits();
            let matters = waits || run.is_held();
            self.robots[robot].runs.set(area, run);
            if matters {
                self.concern(area, robot);
            }
            if waits {
                self.enqueue(area, robot);
            }
        }
        let somewhere = |robot: &Robot| {
            !robot.stands_in.is_empty() || robot.runs.iter().any(|(_, run)| run.is_held())
        };
        self.awaited = (0..self.robots.len())
            .filter(|&robot| self.robots[robot].session > 0 && somewhere(&self.robots[robot]))
            .collect();
        for &robot in &self.awaited {
            // Silent until it is heard; one second of grace would change nothing, since nothing is granted before.
            self.robots[robot].silent = true;
        }
        Ok(())
    }

    fn known_area(&self, id: &str) -> Result<usize, RestoreError> {
        self.area_index
            .get(id)
            .copied()
            .ok_or_else(|| RestoreError::Unknown {
                kind: "area",
                id: id.to_owned(),
            })
    }

    fn known_robot(&self, id: &str) -> Result<usize, RestoreError> {
        self.robot_index
            .get(id)
            .copied()
            .ok_or_else(|| RestoreError::Unknown {
                kind: "robot",
                id: id.to_owned(),
            })
    }

    /// How often the mediator has started, this time included.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Counts since the start.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// What must be in the journal before any message leaves.
    pub fn entries(&mut self) -> std::vec::Drain<'_, Entry> {
        self.entries.drain(..)
    }

    /// What people should hear of.
    pub fn alarms(&mut self) -> std::vec::Drain<'_, Alarm> {
        self.alarms.drain(..)
    }

    /// The next message to send, to the robot that it names; nothing when all have heard the news.
    pub fn next_message(&mut self, now_ns: u64) -> Option<MediatorReport> {
        if let Some(refusal) = self.strangers.pop() {
            return Some(refusal);
        }
        let &robot = self.news.last()?;
        let state = &mut self.robots[robot];
        if let Some(candidate) = &mut state.candidate
            && std::mem::take(&mut candidate.news)
        {
            let (boot_epoch, session) = (candidate.boot_epoch, candidate.session);
            let message = self.message(robot, boot_epoch, session, now_ns);
            if self.robots[robot].session == 0 {
                self.told(robot, now_ns);
            }
            return Some(message);
        }
        let (boot_epoch, session) = (state.boot_epoch, state.session);
        self.told(robot, now_ns);
        Some(self.message(robot, boot_epoch, session, now_ns))
    }

    /// Lets time pass: finds silent robots, and repeats levels. Call it some times a second.
    pub fn tick(&mut self, now_ns: u64) {
        for robot in 0..self.robots.len() {
            let state = &self.robots[robot];
            let late = now_ns > state.heard_ns.saturating_add(self.silent_after_ns);
            if state.registered && !state.silent && late {
                self.robots[robot].silent = true;
                let areas: Vec<&str> = (0..self.areas.len())
                    .filter(|&area| self.robots[robot].occupies(area))
                    .map(|area| self.areas[area].id.as_str())
                    .collect();
                self.alarms.push(Alarm::Silent {
                    robot: self.robots[robot].id.clone(),
                    areas: if areas.is_empty() {
                        "nothing".to_owned()
                    } else {
                        areas.join(", ")
                    },
                });
                // It cannot be granted anything while it is silent, so others may go first.
                for area in self.waits_for(robot) {
                    self.touch(area);
                }
            }
            let state = &mut self.robots[robot];
            let since = |candidate: &robot::Candidate| candidate.since_ns + CANDIDATE_NS;
            state.candidate = state.candidate.filter(|it| now_ns < since(it));
            let somebody = state.session > 0 || state.candidate.is_some();
            if somebody && now_ns >= state.sent_ns.saturating_add(LEVEL_NS) {
                self.tell(robot);
            }
        }
        self.watch_coordinations(now_ns);
        self.coordinate(now_ns);
        self.serve();
    }

    /// An operator says that no silent robot is in the area. Returns whose hold was ended.
    ///
    /// # Errors
    /// [`ClearError`] when there is no such area, or a robot that is heard is in it.
    pub fn clear(&mut self, area_id: &str, now_ns: u64) -> Result<Vec<String>, ClearError> {
        let area = *self.area_index.get(area_id).ok_or_else(|| {
            let mut known: Vec<&str> = self.areas.iter().map(|area| area.id.as_str()).collect();
            known.sort_unstable();
            ClearError::UnknownArea {
                found: area_id.to_owned(),
                known: known.join(", "),
            }
        })?;
        let occupants: Vec<usize> = self.occupants(area).collect();
        if let Some(&robot) = occupants
            .iter()
            .find(|&&robot| self.robots[robot].is_heard())
        {
            return Err(ClearError::Heard {
                area: area_id.to_owned(),
                robot: self.robots[robot].id.clone(),
            });
        }
        for &robot in &occupants {
            self.counters.cleared += 1;
            self.robots[robot].stands_in.retain(|&other| other != area);
            self.robots[robot].found_in.retain(|&other| other != area);
            self.store_robot(robot);
            if self.robots[robot].holds(area)
                && let Some(run) = self.robots[robot].runs.get_mut(area)
            {
                run.abort();
                self.store_run(robot, area);
            }
            self.cleared_of(robot, now_ns);
            self.tell(robot);
            let state = &self.robots[robot];
            let elsewhere = !state.stands_in.is_empty()
                || (0..self.areas.len()).any(|other| state.holds(other));
            if !elsewhere {
                self.awaited.retain(|&awaited| awaited != robot);
                self.touch_all();
            }
        }
        self.touch(area);
        self.coordinate(now_ns);
        self.serve();
        let names = occupants.iter().map(|&robot| self.robots[robot].id.clone());
        Ok(names.collect())
    }

    /// Robots that may be in the area.
    fn occupants(&self, area: usize) -> impl Iterator<Item = usize> + '_ {
        let concerned = self.areas[area].concerned.iter().copied();
        concerned.filter(move |&robot| self.robots[robot].occupies(area))
    }

    fn is_closed(&self, area: usize) -> bool {
        self.areas[area].overfull
            || self
                .occupants(area)
                .any(|robot| self.robots[robot].intrudes(area))
    }

    fn waits_for(&self, robot: usize) -> Vec<usize> {
        let runs = self.robots[robot].runs.iter();
        runs.filter(|(_, run)| run.waits())
            .map(|(area, _)| area)
            .collect()
    }

    // ---------------------------------------------------------------- bookkeeping

    fn concern(&mut self, area: usize, robot: usize) {
        let concerned = &mut self.areas[area].concerned;
        if !concerned.contains(&robot) {
            concerned.push(robot);
        }
    }

    /// Drops the robot from the area's list when nothing joins them any more.
    fn unconcern(&mut self, area: usize, robot: usize) {
        let state = &self.robots[robot];
        if !state.occupies(area) && !state.run(area).is_some_and(Run::waits) {
            self.areas[area].concerned.retain(|&other| other != robot);
        }
    }

    /// Puts a robot with a ticket into the queue, by priority and then by ticket.
    fn enqueue(&mut self, area: usize, robot: usize) {
        let rank = |robot: &usize| {
            let state = &self.robots[*robot];
            let ticket = state.run(area).map_or(u64::MAX, |run| run.ticket);
            (std::cmp::Reverse(state.priority), ticket)
        };
        let queue = &self.areas[area].queue;
        let place = queue.partition_point(|other| rank(other) <= rank(&robot));
        self.areas[area].queue.insert(place, robot);
        self.concern(area, robot);
        self.touch(area);
    }

    fn dequeue(&mut self, area: usize, robot: usize) {
        self.areas[area].queue.retain(|&other| other != robot);
    }

    fn touch(&mut self, area: usize) {
        if !self.areas[area].dirty {
            self.areas[area].dirty = true;
            self.dirty.push(area);
        }
    }

    fn touch_all(&mut self) {
        (0..self.areas.len()).for_each(|area| self.touch(area));
    }

    fn told(&mut self, robot: usize, now_ns: u64) {
        self.news.pop();
        let state = &mut self.robots[robot];
        state.news = false;
        state.sent_ns = now_ns;
    }

    fn tell(&mut self, robot: usize) {
        if let Some(candidate) = &mut self.robots[robot].candidate {
            candidate.news = true;
        }
        if !self.robots[robot].news {
            self.robots[robot].news = true;
            self.news.push(robot);
        }
    }

    fn store_robot(&mut self, robot: usize) {
        let state = &self.robots[robot];
        self.entries.push(Entry::Robot {
            robot: state.id.clone(),
            record: state.record(|area| self.areas[area].id.clone()),
        });
    }

    fn store_run(&mut self, robot: usize, area: usize) {
        let state = &self.robots[robot];
        if let Some(run) = state.run(area) {
            self.entries.push(Entry::Access {
                robot: state.id.clone(),
                area: self.areas[area].id.clone(),
                record: run.record(),
            });
        }
    }

    // ---------------------------------------------------------------- granting

    /// Grants what can be granted in every area where something changed.
    fn serve(&mut self) {
        while let Some(area) = self.dirty.pop() {
            let own = &mut self.areas[area];
            own.dirty = false;
            if own.queue.is_empty() && own.concerned.len() <= own.capacity as usize {
                // Nobody waits, and there cannot be too many.
                own.overfull = false;
                continue;
            }
            let inside: Vec<usize> = self.occupants(area).collect();
            self.judge_capacity(area, &inside);
            self.serve_area(area, inside);
        }
        self.revoke_what_is_kept();
    }

    fn serve_area(&mut self, area: usize, mut inside: Vec<usize>) {
        let Area {
            queue, capacity, ..
        } = &self.areas[area];
        let nobody_fits =
            inside.len() >= *capacity as usize && !queue.iter().any(|robot| inside.contains(robot));
        if !self.awaited.is_empty() || queue.is_empty() || nobody_fits {
            return;
        }
        // Whoever stands there already comes first: letting somebody else in would only make it worse.
        let standing =
            |manager: &Self, robot: usize| manager.robots[robot].stands_in.contains(&area);
        let kept = self.coordinator.kept(area);
        let mut order = self.areas[area].queue.clone();
        order.sort_by_key(|robot| (!standing(self, *robot), !kept.contains(robot)));
        for robot in order {
            let state = &self.robots[robot];
            if !state.is_heard() || !state.located {
                // It could not use the grant; the next one may.
                continue;
            }
            let closed_by_others = self.areas[area].overfull || { inside.iter() }
                .any(|&other| other != robot && self.robots[other].intrudes(area));
            let others = inside.iter().filter(|&&other| other != robot).count();
            if closed_by_others || others >= self.areas[area].capacity as usize {
                return;
            }
            if !standing(self, robot) && !kept.contains(&robot) {
                let still_kept = { kept.iter() }
                    .filter(|&&other| !self.robots[other].occupies(area))
                    .count();
                let full = others + still_kept >= self.areas[area].capacity as usize;
                if full || self.is_decided_by_a_net(area, robot) {
                    continue;
                }
            }
            self.grant(area, robot);
            inside.clear();
            inside.extend(self.occupants(area));
        }
    }

    /// Nobody but a net lets this robot into this area.
    fn is_decided_by_a_net(&self, area: usize, robot: usize) -> bool {
        self.coordinator.governed[area].is_some() || self.coordinator.control_of(robot).is_some()
    }

    fn grant(&mut self, area: usize, robot: usize) {
        let fence = self.areas[area].fence + 1;
        let Some(run) = self.robots[robot].runs.get_mut(area) else {
            return;
        };
        if !self.protocol.grant(run, fence) {
            return;
        }
        self.areas[area].fence = fence;
        self.robots[robot].found_in.retain(|&other| other != area);
        self.dequeue(area, robot);
        self.counters.grants += 1;
        self.kept_changed(robot, area, KeptChange::Granted);
        self.entries.push(Entry::Fence {
            area: self.areas[area].id.clone(),
            fence,
        });
        self.store_run(robot, area);
        // Why others go on waiting, they hear with their next level.
        self.tell(robot);
    }

    /// Notices when an area holds more than it can, and when that is over.
    fn judge_capacity(&mut self, area: usize, inside: &[usize]) {
        if inside.len() <= self.areas[area].capacity as usize {
            self.areas[area].overfull = false;
            return;
        }
        // Where a robot stands that has not said so is only guessed.
        let inside: Vec<usize> = { inside.iter().copied() }
            .filter(|&robot| self.robots[robot].placed || self.robots[robot].holds(area))
            .collect();
        let Area { capacity, id, .. } = &self.areas[area];
        // As long as somebody has not reported, it may have left: nothing is granted anyway.
        let overfull = self.awaited.is_empty() && inside.len() > *capacity as usize;
        if overfull && !self.areas[area].overfull {
            let robots: Vec<&str> = inside
                .iter()
                .map(|&robot| self.robots[robot].id.as_str())
                .collect();
            self.alarms.push(Alarm::Overfull {
                area: id.clone(),
                capacity: *capacity,
                found: inside.len(),
                robots: robots.join(", "),
            });
        }
        self.areas[area].overfull = overfull;
    }
}

/// Why an area was not cleared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClearError {
    /// No such area.
    #[error("there is no area `{found}`; this site has {known}")]
    UnknownArea {
        /// As asked for.
        found: String,
        /// All there are.
        known: String,
    },
    /// Somebody is in it.
    #[error("area `{area}` is not cleared: robot `{robot}` is in it and is heard")]
    Heard {
        /// The area.
        area: String,
        /// The robot.
        robot: String,
    },
}
