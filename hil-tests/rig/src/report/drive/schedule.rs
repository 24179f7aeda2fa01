//! Where the schedule changed: the first change to each state in full, later ones as places only.

use crate::record::StateChange;

/// More states than this are counted, not listed.
const MOST_ENTRIES: usize = 24;
/// Most places of later changes that are drawn.
const MOST_LATER: usize = 1000;

/// The changes of one robot.
#[derive(Debug, Default)]
pub(super) struct Schedule<'a> {
    /// The first change to each state, in order.
    pub(super) entries: Vec<Entry<'a>>,
    /// States that are not listed.
    pub(super) unlisted: usize,
    /// Where it changed to a listed state again.
    pub(super) later_m: Vec<[f64; 2]>,
}

/// A state of the robot's machine that it changed to.
#[derive(Debug)]
pub(super) struct Entry<'a> {
    /// The first time.
    pub(super) first: &'a StateChange,
    /// How often in all.
    pub(super) times: usize,
}

impl<'a> Schedule<'a> {
    pub(super) fn new(changes: &'a [StateChange]) -> Self {
        let mut schedule = Self::default();
        let own = changes.iter().filter(|change| {
            !change.skill.is_empty() && change.believed_m.iter().all(|value| value.is_finite())
        });
        for change in own {
            let same = |entry: &&mut Entry<'_>| {
                entry.first.skill == change.skill && entry.first.state == change.state
            };
            if let Some(entry) = schedule.entries.iter_mut().find(same) {
                entry.times += 1;
                if schedule.later_m.len() < MOST_LATER {
                    schedule.later_m.push(change.believed_m);
                }
            } else if schedule.entries.len() < MOST_ENTRIES {
                schedule.entries.push(Entry {
                    first: change,
                    times: 1,
                });
            } else {
                schedule.unlisted += 1;
            }
        }
        schedule
    }
}
