//! Who starts the mediator again, and tells it what he sees.

use std::time::Duration;

use contract::floor::Floor;
use mediator::journal::{RobotRecord, Stored};
use mediator::manager::Manager;
use mediator::setup::{AreaSetup, RobotSetup, Setup};

use super::action::{AREAS, Left};
use super::kept::Kept;
use super::rules::{AFTER_ALL_NS, Rule};
use super::world::{Journal, SITE, World, now_ns};

fn setup() -> Setup {
    let area = |id: &str| AreaSetup {
        id: id.to_owned(),
        capacity: 1,
    };
    let robot = |id: &str| RobotSetup {
        id: id.to_owned(),
        role: "normal".to_owned(),
        priority: 0,
        ages_after: 0,
        starts_in: Vec::new(),
    };
    Setup {
        site: SITE.to_owned(),
        areas: AREAS.map(area).into(),
        floor: Floor::default(),
        robots: ["one", "two"].map(robot).into(),
        silent_after: Duration::from_secs(1),
    }
}

/// A process of the mediator, with a number of its own.
pub(super) fn manager(stored: &Stored, now_ns: u64, instance: u64) -> Manager {
    let manager = Manager::new(&setup(), stored, now_ns).expect("its own journal");
    manager.speaks_as(instance)
}

impl World {
    pub(super) fn restart(&mut self, left: Left) {
        self.starts += 1;
        self.robots.iter_mut().for_each(|robot| robot.said_in = 0);
        let Journal { stored, before } = self.journal.get().clone();
        let mut stored = match left {
            Left::All => stored,
            Left::AllButLast => before.unwrap_or(stored),
            Left::Nothing => Stored::new(stored.journal + 1),
        };
        self.lost |= left != Left::All;
        let mut read = stored.clone();
        let mut start_ns = now_ns(self.tick);
        match self.limits.without {
            Some(Rule::Awaited) => {
                for id in ["one", "two"] {
                    let record = read
                        .robots
                        .entry(id.to_owned())
                        .or_insert_with(RobotRecord::default);
                    record.absent = true;
                }
                // And the time is over in which who is on the floor is heard all the same.
                start_ns -= AFTER_ALL_NS;
            }
            Some(Rule::BeforeStart | Rule::NewProcess) => start_ns -= AFTER_ALL_NS,
            _ => {}
        }
        self.manager = Kept::new(manager(&read, start_ns, u64::from(self.starts)));
        // Nothing is told before the new epoch is on the disk.
        self.manager
            .change(|manager| manager.entries().for_each(|entry| stored.apply(entry)));
        self.journal = Kept::new(Journal {
            stored,
            before: None,
        });
    }

    /// For an order the mediator looks at its clock.
    pub(super) fn order_ns(&self) -> u64 {
        match self.limits.without {
            Some(Rule::EntersNoMore) => AFTER_ALL_NS,
            Some(Rule::Drift) => 100_000_000,
            _ => 0,
        }
    }

    /// Somebody was granted the area, and is not in it for all that the mediator knows.
    pub(super) fn is_granted(&self, area: u8) -> bool {
        let status = self.manager.get().status(now_ns(self.tick));
        let area = &status.areas[usize::from(area)];
        !area.holders.is_empty() && area.standing.is_empty()
    }

    /// Whoever the mediator thinks is there is not: the operator sees the area empty.
    pub(super) fn clear(&mut self, area: u8) -> Option<()> {
        self.clear_as(area, true)
    }

    /// People are told which areas a process before is not known to have left, and clear those in which they see nobody.
    pub(super) fn clear_what_was_left(&mut self) {
        let bodies = { self.robots.iter() }.fold(0, |bodies, robot| bodies | robot.body);
        let robots = self.manager.get().status(now_ns(self.tick)).robots;
        for area in 0..2 {
            let id = AREAS[usize::from(area)];
            let is_blocked = { robots.iter() }.any(|own| own.second_in.iter().any(|own| own == id));
            if is_blocked && bodies & 1 << area == 0 {
                // Somebody may still be on its way there.
                let _ = self.clear(area);
            }
        }
    }

    /// The operator means another area, and has not seen that somebody was taken out of this one.
    pub(super) fn mistake(&mut self, area: u8) -> Option<()> {
        let is_not_asked = self.limits.without == Some(Rule::AsksTwice);
        self.clear_as(area, is_not_asked)
    }

    fn clear_as(&mut self, area: u8, taken_away: bool) -> Option<()> {
        let (id, later_ns) = (AREAS[usize::from(area)], self.order_ns());
        let what = ("clear", area, taken_away, later_ns);
        let (done, messages) = self.manage(what, |manager, now_ns| {
            let of = manager.clear(id, taken_away, now_ns + later_ns);
            of.is_ok_and(|done| !done.of.is_empty())
        });
        self.deliver(messages);
        done.then_some(())
    }

    pub(super) fn absent(&mut self, robot: u8) -> Option<()> {
        let (id, later_ns) = (self.robot(robot).id(), self.order_ns());
        let what = ("absent", robot, later_ns);
        let (done, messages) = self.manage(what, |manager, now_ns| {
            manager.absent(id, true, now_ns + later_ns).is_ok()
        });
        self.deliver(messages);
        done.then_some(())
    }
}
