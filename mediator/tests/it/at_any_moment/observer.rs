//! An independent listener that knows owners by their fences.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};

use contract::wire::{Level, MediatorReport, RobotReport};
use contract::{Message, decode, keys};
use zenoh::Wait;

use super::fleet::PREFIX;

/// What it has seen.
#[derive(Debug, Default)]
pub struct Seen {
    pub reports: u64,
    pub messages: u64,
    /// Grants that robots have had.
    pub owners: usize,
    /// What must not be.
    pub accusations: Vec<String>,
}

#[derive(Default)]
struct Book {
    seen: Seen,
    /// Boot and sequence of each robot's last report.
    last: BTreeMap<String, (u64, u64)>,
    /// By area: who says that it has it, and by which fence.
    owners: BTreeMap<String, BTreeMap<String, u64>>,
    /// By area and fence: whose grant it is.
    grants: BTreeMap<(String, u64), String>,
    /// By area and fence: those that robots have used.
    used: BTreeSet<(String, u64)>,
    /// The largest fence by area that a robot had.
    highest: BTreeMap<String, u64>,
}

/// `granted` or `entered` is the last flag set: paths are 0: request, granted, entered, released; 1: request, granted, returned.
fn is_held(level: Option<&Level>) -> bool {
    level.is_some_and(|level| level.progress == 2 || (level.path == 0 && level.progress == 3))
}

impl Book {
    /// Reports of all robots arrive in the order in which they were sent, so that an area that was given back is seen to be
    /// given back before anybody else can have it.
    fn report(&mut self, report: &RobotReport) {
        self.seen.reports += 1;
        let now = (report.boot_epoch, report.sequence);
        let before = self.last.insert(report.robot_id.clone(), now);
        if report.session == 0 || report.mediator_epoch == 0 {
            // It has restarted and knows nothing, but still has what it had.
            return;
        }
        if let Some(before) = before
            && before.0 == now.0
            && now.1 <= before.1
        {
            self.accuse(format!("reports of {} are out of order", report.robot_id));
        }
        let mut held = BTreeMap::new();
        for access in &report.access {
            if is_held(access.level.as_ref()) {
                held.insert(access.area.as_str(), access.fence);
            }
        }
        for (area, owners) in &mut self.owners {
            if !held.contains_key(area.as_str()) {
                owners.remove(&report.robot_id);
            }
        }
        for (area, fence) in held {
            self.own(&report.robot_id, area, fence);
        }
    }

    fn own(&mut self, robot: &str, area: &str, fence: u64) {
        let owners = self.owners.entry(area.to_owned()).or_default();
        let before = owners.insert(robot.to_owned(), fence);
        let others: Vec<String> = owners
            .iter()
            .filter(|(other, _)| *other != robot)
            .map(|(other, fence)| format!("{other} by fence {fence}"))
            .collect();
        if before == Some(fence) {
            return;
        }
        if !others.is_empty() {
            self.accuse(format!(
                "{robot} has area {area} by fence {fence}, and so has {others:?}"
            ));
        }
        let highest = self.highest.entry(area.to_owned()).or_default();
        let first = self.used.insert((area.to_owned(), fence));
        if first && fence <= *highest {
            let highest = *highest;
            self.accuse(format!(
                "{robot} has area {area} by fence {fence}, and there was {highest}"
            ));
        } else {
            *highest = fence.max(*highest);
        }
        self.grant(robot, area, fence);
    }

    /// Every fence of an area belongs to one robot only.
    fn grant(&mut self, robot: &str, area: &str, fence: u64) {
        let place = (area.to_owned(), fence);
        let owner = self.grants.entry(place).or_insert_with(|| robot.to_owned());
        if owner != robot {
            let owner = owner.clone();
            self.accuse(format!(
                "fence {fence} of area {area} was given to {owner} and to {robot}"
            ));
        }
    }

    fn message(&mut self, message: &MediatorReport) {
        self.seen.messages += 1;
        for access in &message.access {
            if is_held(access.level.as_ref()) {
                self.grant(&message.robot_id, &access.area, access.fence);
            }
        }
    }

    fn accuse(&mut self, what: String) {
        self.seen.accusations.push(what);
    }
}

/// Listens until it is finished.
pub struct Observer {
    session: zenoh::Session,
    book: Arc<Mutex<Book>>,
}

impl Observer {
    pub fn new(session: zenoh::Session) -> Self {
        let book = Arc::new(Mutex::new(Book::default()));
        listen(&session, keys::all_reports(PREFIX), &book, Book::report);
        listen(&session, keys::to_all_robots(PREFIX), &book, Book::message);
        Self { session, book }
    }

    pub fn finish(self) -> Seen {
        self.session.close().wait().expect("it closes");
        let mut book = self.book.lock().expect("nobody panics with it");
        book.seen.owners = book.used.len();
        std::mem::take(&mut book.seen)
    }
}

/// Enters everything that is sent on a key into the book.
fn listen<M: Message + Default + 'static>(
    session: &zenoh::Session,
    key: Result<String, keys::InvalidName>,
    book: &Arc<Mutex<Book>>,
    enter: fn(&mut Book, &M),
) {
    let book = Arc::clone(book);
    session
        .declare_subscriber(key.expect("a plain name"))
        .callback(move |sample| {
            let mut book = book.lock().expect("nobody panics with it");
            match decode(&sample.payload().to_bytes()) {
                Ok(message) => enter(&mut book, &message),
                Err(error) => book.accuse(error.to_string()),
            }
        })
        .background()
        .wait()
        .expect("it subscribes");
}

/// An observer that sees nothing proves nothing.
mod tests {
    use super::*;
    use contract::wire::Access;

    fn report(robot: &str, sequence: u64, progress: u32, fence: u64) -> RobotReport {
        let level = Level {
            progress,
            ..Level::default()
        };
        RobotReport {
            robot_id: robot.into(),
            boot_epoch: 1,
            sequence,
            mediator_epoch: 1,
            session: 1,
            access: vec![Access {
                area: "room".into(),
                level: Some(level),
                fence,
            }],
            ..RobotReport::default()
        }
    }

    fn accusations(reports: &[RobotReport]) -> String {
        let mut book = Book::default();
        reports.iter().for_each(|report| book.report(report));
        book.seen.accusations.join("; ")
    }

    #[test]
    fn who_follows_the_rules_is_not_accused() {
        let said = accusations(&[
            report("a", 1, 1, 0),
            report("a", 2, 2, 1),
            report("b", 1, 1, 0),
            report("a", 3, 3, 1),
            report("a", 4, 4, 0),
            report("b", 2, 2, 2),
            report("b", 3, 3, 2),
        ]);
        assert_eq!(said, "");
    }

    #[test]
    fn two_owners_are_seen() {
        let said = accusations(&[report("a", 1, 3, 1), report("b", 1, 2, 2)]);
        assert!(
            said.contains("b has area room by fence 2, and so has"),
            "{said}"
        );
    }

    #[test]
    fn fences_that_do_not_grow_are_seen() {
        let said = accusations(&[
            report("a", 1, 2, 5),
            report("a", 2, 4, 0),
            report("b", 1, 2, 4),
        ]);
        assert!(said.contains("and there was 5"), "{said}");
    }

    #[test]
    fn one_fence_for_two_is_seen() {
        let said = accusations(&[
            report("a", 1, 2, 5),
            report("a", 2, 4, 0),
            report("b", 1, 2, 5),
        ]);
        assert!(said.contains("was given to a and to b"), "{said}");
    }
}
