//! Which messages are of the present registration of a robot.
//!
//! A process of a mediator numbers its registrations, and takes a larger epoch where another one may have granted what it does not
//! know. So messages are ordered by whom they are of, in the order in which those were heard first, and then by session.

use std::collections::BTreeMap;

/// A mediator's process with its epoch, and its journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Source {
    pub(super) instance: u64,
    pub(super) epoch: u64,
    pub(super) journal: u64,
}

/// A place in the order of sources, and the session.
type Registration = (usize, u64);

/// The present ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Registrations {
    sources: Vec<Source>,
    /// With the boot of the robot's process.
    by_robot: BTreeMap<String, (Registration, u64)>,
}

/// How a robot's report comes in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// Of an earlier registration.
    Old,
    Present,
    /// The first of a new one.
    Begins,
}

impl Registrations {
    /// Takes in whom a message is of. Returns whether that is the first one by another journal than before.
    pub(super) fn hear(&mut self, source: Source) -> bool {
        if self.sources.contains(&source) {
            return false;
        }
        let other = { self.sources.last() }.is_some_and(|last| last.journal != source.journal);
        self.sources.push(source);
        other
    }

    fn registration(&self, source: Source, session: u64) -> Registration {
        let place = self.sources.iter().position(|own| *own == source);
        (place.unwrap_or(0), session)
    }

    /// Takes in a report of a robot's process.
    pub(super) fn report(
        &mut self,
        robot: &str,
        source: Source,
        (session, boot): (u64, u64),
    ) -> Order {
        let found = self.registration(source, session);
        let Some((present, present_boot)) = self.by_robot.get_mut(robot) else {
            self.by_robot.insert(robot.to_owned(), (found, boot));
            return Order::Present;
        };
        match found.cmp(present) {
            std::cmp::Ordering::Less => Order::Old,
            std::cmp::Ordering::Equal => Order::Present,
            std::cmp::Ordering::Greater => {
                // Another mediator may give the same number, and keeps what a process has, but not what one before it had.
                let anew = (session, boot) != (present.1, *present_boot);
                (*present, *present_boot) = (found, boot);
                if anew { Order::Begins } else { Order::Present }
            }
        }
    }

    /// The journal of the mediator that the robot follows, by its last report; none: it has not said.
    pub(super) fn followed_by(&self, robot: &str) -> Option<u64> {
        let ((place, _), _) = self.by_robot.get(robot)?;
        self.sources.get(*place).map(|source| source.journal)
    }

    /// Whether what the mediator says to a robot is of an earlier registration.
    pub(super) fn is_old(&self, robot: &str, source: Source, session: u64) -> bool {
        let found = self.registration(source, session);
        self.by_robot
            .get(robot)
            .is_some_and(|(present, _)| found < *present)
    }
}
