//! One other process with a robot's name: what is known of it, and where its body stands.

use crate::journal::Before;

/// No process sends so many reports that nobody hears, in a century.
pub(super) const MOST_REPORTS: u64 = 1 << 40;

/// What is known of such a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Known {
    /// It may be the robot's next process, or late words of one that is gone.
    Nothing,
    /// None that speaks for the robot is heard, and this one is refused: for all that is known it is the robot.
    Alone,
    /// It was found beside the one that speaks for the robot: it is another body.
    Found,
}

/// The process that speaks for a robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Speaker {
    /// Its boot epoch.
    pub(crate) process: u64,
    /// Of its last report.
    pub(crate) sequence: u64,
}

/// What became of the process that spoke for the robot before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Judged {
    /// The robot is its next one. These areas it has held beside the robot.
    Next(Vec<usize>),
    /// It is another body, and in these areas, for all that is known.
    Another { process: u64, areas: Vec<usize> },
}

/// The body of a process in an area.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hold {
    pub(super) area: usize,
    /// Until then it counts as heard there.
    pub(super) heard_until_ns: u64,
    /// It was found: it is there, too, when it is silent.
    pub(super) is_found: bool,
    /// People were told that it is silent.
    pub(super) told: bool,
    /// The robot is in the area itself, and it is one body with this one, for all that is known.
    pub(super) is_robot: bool,
}

impl Hold {
    pub(super) fn of(area: usize, is_robot: bool) -> Self {
        Self {
            area,
            heard_until_ns: 0,
            is_found: false,
            told: false,
            is_robot,
        }
    }
}

/// A process, and the areas in which its body stands.
#[derive(Clone, Debug)]
pub(super) struct Second {
    /// Its boot epoch.
    pub(super) process: u64,
    /// Of its newest report.
    pub(super) sequence: u64,
    pub(super) is_found: bool,
    /// It was refused while none that speaks for the robot was heard.
    pub(super) alone: bool,
    /// A new process speaks for the robot, which is its next one if it is heard no more. The journal does not know: what a mediator that
    /// starts in that second keeps blocked, people clear.
    pub(super) has_next: bool,
    /// It spoke for the robot before a new process, which has not said yet where it stands, and stood so.
    pub(super) before: Option<Before>,
    pub(super) holds: Vec<Hold>,
}

impl Second {
    /// It spoke for the robot before a new process: in these areas it is the robot, for all that is known.
    pub(super) fn of_before(speaker: Speaker, stood: Before, areas: &[usize]) -> Self {
        // Whether people are to hear of it, that one says.
        let hold = |&area: &usize| Hold {
            is_found: true,
            told: true,
            ..Hold::of(area, true)
        };
        Self {
            process: speaker.process,
            sequence: speaker.sequence,
            is_found: true,
            alone: false,
            has_next: false,
            before: Some(stood),
            holds: areas.iter().map(hold).collect(),
        }
    }

    /// It can have brought the robot to where that stands: into an area in which it was or which it had, or beside all areas, if it stood there.
    pub(super) fn leads_to(&self, stands_in: &[usize]) -> bool {
        let goes_on = |own: &Hold| stands_in.contains(&own.area);
        let beside_all = stands_in.is_empty() && self.before == Some(Before::Outside);
        beside_all || self.holds.is_empty() || self.holds.iter().any(goes_on)
    }

    /// It was heard. One that `lives` beside a new process is not what that one goes on from. Returns whether that is news to the journal.
    pub(super) fn hears(&mut self, lives: bool) -> bool {
        self.has_next &= !lives;
        lives && self.before.take().is_some()
    }

    /// As a body besides the robot's.
    pub(super) fn is_in(&self, area: usize) -> bool {
        let mut all = self.holds.iter().filter(|own| !own.is_robot);
        all.any(|own| own.area == area)
    }

    /// What else is known of it. Returns whether that is news to the journal.
    pub(super) fn note(&mut self, known: Known) -> bool {
        let before = (self.alone, self.is_found);
        match known {
            Known::Nothing => return false,
            Known::Alone => self.alone |= !self.is_found,
            Known::Found => self.alone = false,
        }
        (self.has_next, self.is_found) = (false, true);
        before != (self.alone, self.is_found)
    }

    /// Wherever it might have been the robot it is another one. Returns areas with a body more.
    pub(super) fn is_another(&mut self) -> impl Iterator<Item = &Hold> {
        let appear = self.holds.iter_mut().filter(|own| own.is_robot);
        appear.map(|own| {
            own.is_robot = false;
            &*own
        })
    }

    /// Takes in the number of a report, none of an old one. Returns whether the process can have reached it: what somebody else says in
    /// its name may be so, too.
    pub(super) fn has_sent(&mut self, sequence: u64) -> Option<bool> {
        if sequence <= self.sequence {
            return None;
        }
        let is_reached = sequence <= self.sequence.saturating_add(MOST_REPORTS);
        if is_reached {
            self.sequence = sequence;
        }
        Some(is_reached)
    }

    /// Its body stands there. Returns whether that is news to others, and to the journal.
    pub(super) fn hold(
        &mut self,
        area: usize,
        is_robot: bool,
        is_found: bool,
        until_ns: u64,
    ) -> (bool, bool) {
        let known = self.holds.iter().position(|own| own.area == area);
        let place = known.unwrap_or_else(|| {
            self.holds.push(Hold::of(area, is_robot));
            self.holds.len() - 1
        });
        let own = &mut self.holds[place];
        own.heard_until_ns = own.heard_until_ns.max(until_ns);
        own.told = false;
        let appears = own.is_robot && !is_robot;
        let is_news = is_found && !own.is_found || own.is_found && appears;
        own.is_found |= is_found;
        own.is_robot &= is_robot;
        (!is_robot && (known.is_none() || appears), is_news)
    }
}
