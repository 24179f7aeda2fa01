//! Which robots must be heard before anything is granted.

use super::table::Sessions;
use crate::manager::alarm::Alarm;
use crate::manager::effects::Effects;

/// What is new about a robot that was heard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Heard {
    /// Its first report that counts, of this process and to this mediator.
    pub(crate) first: bool,
    /// It was not heard before, or was silent.
    pub(crate) again: bool,
    /// It was awaited, so that nothing was granted to anybody since it was heard last.
    pub(crate) awaited: bool,
    /// It was the last one that was awaited.
    pub(crate) completes: bool,
    /// It was not accounted for, and is now: all that it has is what this report says.
    pub(crate) accounted: bool,
    /// It was said to be absent.
    pub(crate) returns: bool,
}

impl Sessions {
    pub(crate) fn awaited(&self) -> &[usize] {
        &self.awaited
    }

    pub(crate) fn is_awaited(&self, robot: usize) -> bool {
        self.awaited.contains(&robot)
    }

    /// Nothing is granted before these robots have said where they stand.
    pub(crate) fn wait_for(&mut self, robots: Vec<usize>) {
        for &robot in &robots {
            // Silent until it is heard; one second of grace would change nothing, since nothing is granted before.
            self.robots[robot].silent = true;
        }
        self.awaited = robots;
    }

    /// Another mediator may have granted a robot anything: it is awaited, and what it says then is taken over. One that was said to be
    /// absent may have come back to that one.
    pub(crate) fn unaccount(&mut self, robot: usize, now_ns: u64) {
        self.robots[robot].unaccount(now_ns);
        if !self.is_awaited(robot) {
            self.awaited.push(robot);
        }
    }

    /// An operator says that this robot is nowhere: nobody waits for it until it is heard. Returns whether it was the last one that was
    /// awaited.
    pub(crate) fn give_up(&mut self, robot: usize) -> bool {
        let session = &mut self.robots[robot];
        (session.unaccounted, session.absent) = (false, true);
        self.wait_no_longer_for(robot)
    }

    /// Returns whether it was the last one that was awaited.
    pub(crate) fn wait_no_longer_for(&mut self, robot: usize) -> bool {
        let before = self.awaited.len();
        self.awaited.retain(|&awaited| awaited != robot);
        before > 0 && self.awaited.is_empty()
    }

    /// A report that counts has come. Also one that does not know where it is was heard, but goes on being awaited, and so does one
    /// whose body may still be carried on by what a process before was granted.
    pub(crate) fn hear(
        &mut self,
        robot: usize,
        located: bool,
        now_ns: u64,
        effects: &mut Effects,
    ) -> Heard {
        let session = &mut self.robots[robot];
        let heard = session.is_heard();
        let first = !session.registered;
        session.heard_ns = now_ns;
        session.registered = true;
        let speaks = located && session.speaks_for_body(now_ns);
        let accounted = session.unaccounted && speaks;
        session.unaccounted &= !speaks;
        if !session.unaccounted {
            // Before that nothing of what it says of areas is taken in, and it must go on saying all.
            session.counted = session.sequence;
        }
        let returns = std::mem::take(&mut session.absent);
        if std::mem::take(&mut session.silent) && !first {
            effects.alarms.push(Alarm::Back {
                robot: self.names.robot_id(robot),
            });
        }
        let awaited = self.awaited.iter().position(|&awaited| awaited == robot);
        let found = awaited.filter(|_| speaks);
        if let Some(place) = found {
            self.awaited.swap_remove(place);
        }
        Heard {
            first,
            again: !heard,
            awaited: awaited.is_some(),
            completes: found.is_some() && self.awaited.is_empty(),
            accounted,
            returns,
        }
    }
}
