//! Protocol 1, as heard by a third party.

use std::collections::BTreeMap;

use contract::wire::Level;

const REQUESTED: u32 = 1;
const GRANTED: u32 = 2;
const ENTERED_OR_RETURNED: u32 = 3;
const RELEASED: u32 = 4;
/// Path of a grant that is given back without entering.
const RETURNING: u32 = 1;

/// A robot had an area.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Owning {
    /// Area.
    pub area: String,
    /// Robot.
    pub robot: String,
    /// Of the grant.
    pub fence: u64,
    /// Of the mediator that its robot followed then: each journal counts fences of its own.
    pub journal: u64,
    /// When its request was heard.
    pub requested_ns: Option<u64>,
    /// When the grant was heard.
    pub granted_ns: u64,
    /// When it said that it entered.
    pub entered_ns: Option<u64>,
    /// When it gave it back; none: it still has it.
    pub released_ns: Option<u64>,
    /// It was given back without having been entered.
    pub returned: bool,
}

impl Owning {
    /// Whether it was in force at this time, within the tolerance.
    #[must_use]
    pub fn covers(&self, at_ns: u64, tolerance_ns: u64) -> bool {
        self.granted_ns <= at_ns.saturating_add(tolerance_ns) && { self.released_ns }
            .is_none_or(|released_ns| released_ns.saturating_add(tolerance_ns) >= at_ns)
    }
}

/// A robot asked for an area.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waiting {
    /// Robot.
    pub robot: String,
    /// Area.
    pub area: String,
    /// When it asked.
    pub from_ns: u64,
    /// When it was granted, or given up; none: it still waits.
    pub to_ns: Option<u64>,
    /// Why it waited, as the mediator told it last; empty: it was never told to wait.
    pub why: String,
}

/// What is new in a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Deeds {
    /// A request.
    pub(super) requested: bool,
    /// A grant.
    pub(super) granted: bool,
    /// The robot entered, left, or gave a grant back.
    pub(super) moved: bool,
}

#[derive(Clone, Debug, Default)]
struct AccessRun {
    run: u32,
    progress: u32,
    /// Of the newest grant, of this run or an earlier one.
    fence: u64,
    /// In the lists of all.
    owning: Option<usize>,
    waiting: Option<usize>,
    /// An operator has cleared the area of it.
    cleared: bool,
}

/// All areas of all robots.
#[derive(Clone, Debug)]
pub(super) struct Accesses {
    capacities: BTreeMap<String, u32>,
    runs: BTreeMap<(String, String), AccessRun>,
    ownings: Vec<Owning>,
    waitings: Vec<Waiting>,
}

impl Accesses {
    pub(super) fn new(capacities: BTreeMap<String, u32>) -> Self {
        Self {
            capacities,
            runs: BTreeMap::new(),
            ownings: Vec::new(),
            waitings: Vec::new(),
        }
    }

    pub(super) fn ownings(&self) -> &[Owning] {
        &self.ownings
    }

    pub(super) fn waitings(&self) -> &[Waiting] {
        &self.waitings
    }

    /// A robot goes by another registration than before: `said`, levels by area, is all that it has. Runs and fences may count
    /// from the first again.
    pub(super) fn begin(&mut self, robot: &str, said: &BTreeMap<&str, &Level>, at_ns: u64) {
        let own = self.runs.iter_mut().filter(|((id, _), _)| id == robot);
        for ((_, area), run) in own {
            let level = { said.get(area.as_str()) }.map(|level| (level.run, level.progress));
            if level < Some((run.run, run.progress)) {
                close(&mut self.ownings, &mut self.waitings, run, at_ns);
                *run = AccessRun::default();
            }
        }
    }

    /// Takes in a level of either side, which goes by this journal and fence.
    pub(super) fn learn(
        &mut self,
        robot: &str,
        area: &str,
        level: &Level,
        (journal, fence): (u64, u64),
        at_ns: u64,
    ) -> Deeds {
        let mut deeds = Deeds::default();
        let key = (robot.to_owned(), area.to_owned());
        let run = self.runs.entry(key).or_default();
        // Robots that are registered anew may count their runs from the first again; fences only grow.
        let counts_anew = fence > run.fence && (level.run < run.run || run.progress >= GRANTED);
        if !counts_anew && (level.run, level.progress) <= (run.run, run.progress) {
            return deeds;
        }
        if counts_anew || level.run > run.run {
            // The run before has ended unheard, or the mediator gave it up.
            deeds.moved |= close(&mut self.ownings, &mut self.waitings, run, at_ns);
            *run = AccessRun {
                run: level.run,
                fence: run.fence,
                ..AccessRun::default()
            };
        }
        let reaches = |flag: u32| level.progress >= flag && run.progress < flag;
        if reaches(REQUESTED) {
            run.waiting = Some(self.waitings.len());
            self.waitings.push(Waiting {
                robot: robot.to_owned(),
                area: area.to_owned(),
                from_ns: at_ns,
                to_ns: None,
                why: String::new(),
            });
            deeds.requested = true;
        }
        run.fence = run.fence.max(fence);
        if reaches(GRANTED) {
            let waiting = run.waiting.and_then(|index| self.waitings.get_mut(index));
            let requested_ns = waiting.map(|waiting| {
                waiting.to_ns = Some(at_ns);
                waiting.from_ns
            });
            run.owning = Some(self.ownings.len());
            self.ownings.push(Owning {
                area: area.to_owned(),
                robot: robot.to_owned(),
                fence,
                journal,
                requested_ns,
                granted_ns: at_ns,
                entered_ns: None,
                released_ns: None,
                returned: false,
            });
            deeds.granted = true;
        }
        let owning = run.owning.and_then(|index| self.ownings.get_mut(index));
        if let Some(owning) = owning {
            if reaches(ENTERED_OR_RETURNED) {
                deeds.moved = true;
                if level.path == RETURNING {
                    owning.returned = true;
                    owning.released_ns = Some(at_ns);
                } else {
                    owning.entered_ns = Some(at_ns);
                }
            }
            if reaches(RELEASED) {
                deeds.moved = true;
                owning.released_ns = Some(at_ns);
            }
        }
        run.progress = level.progress;
        deeds
    }

    /// Notes why a request waits.
    pub(super) fn explain(&mut self, robot: &str, area: &str, why: &str) {
        let key = (robot.to_owned(), area.to_owned());
        let waiting = { self.runs.get(&key) }
            .and_then(|run| run.waiting)
            .and_then(|index| self.waitings.get_mut(index))
            .filter(|waiting| waiting.to_ns.is_none());
        if let Some(waiting) = waiting
            && !why.is_empty()
        {
            why.clone_into(&mut waiting.why);
        }
    }

    /// The robot no longer has the area, nor waits for it.
    pub(super) fn give_up(&mut self, robot: &str, area: &str, at_ns: u64) {
        let key = (robot.to_owned(), area.to_owned());
        if let Some(run) = self.runs.get_mut(&key) {
            run.cleared |= close(&mut self.ownings, &mut self.waitings, run, at_ns);
        }
    }

    /// Takes in that the mediator says that a robot has an area: also one that was cleared of it before the robot said that it has it,
    /// as where a mediator has lost its journal.
    pub(super) fn confirm(&mut self, robot: &str, area: &str, level: &Level, fence: u64) {
        let key = (robot.to_owned(), area.to_owned());
        let Some(run) = self.runs.get_mut(&key) else {
            return;
        };
        let has = is_grant(level);
        let same = (level.run, level.progress, fence) == (run.run, run.progress, run.fence);
        if !(run.cleared && has && same) {
            return;
        }
        // As if it had only asked for it: `learn` takes the grant in anew.
        *run = AccessRun {
            run: run.run,
            progress: REQUESTED,
            fence,
            ..AccessRun::default()
        };
    }

    /// Whether the other robots fill the area.
    pub(super) fn is_full_for(&self, robot: &str, area: &str) -> bool {
        let holders = { self.ownings.iter() }
            .filter(|own| own.area == area && own.robot != robot && own.released_ns.is_none())
            .count();
        let capacity = self.capacities.get(area).copied().unwrap_or(0);
        holders >= capacity as usize
    }

    /// Whether a request of this robot could be granted at once: there is room, and nobody else waits.
    pub(super) fn is_free_for(&self, robot: &str, area: &str) -> bool {
        let others_wait = { self.waitings.iter() }.any(|waiting| {
            waiting.area == area && waiting.robot != robot && waiting.to_ns.is_none()
        });
        !others_wait && !self.is_full_for(robot, area)
    }
}

/// Whether who is at this level has the area.
pub(super) fn is_grant(level: &Level) -> bool {
    (GRANTED..RELEASED).contains(&level.progress) && level.path != RETURNING
}

/// Ends what a run still has. Returns whether that was an area.
fn close(ownings: &mut [Owning], waitings: &mut [Waiting], run: &AccessRun, at_ns: u64) -> bool {
    if let Some(waiting) = run.waiting.and_then(|index| waitings.get_mut(index)) {
        waiting.to_ns.get_or_insert(at_ns);
    }
    let owning = run.owning.and_then(|index| ownings.get_mut(index));
    match owning {
        Some(owning) if owning.released_ns.is_none() => {
            owning.released_ns = Some(at_ns);
            true
        }
        _ => false,
    }
}
