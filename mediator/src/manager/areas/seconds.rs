//! Other processes with one robot's name, and where their bodies stand.
//!
//! Several may run at once, and come and go: what one of them says ends no hold of another. One that may be a restart, or somebody's
//! late words, holds an area from its last report of standing there until a process counts as silent. One that was *found* beside the
//! one that speaks for the robot is another body: it holds what it was last heard to stand in until it is heard elsewhere, or people
//! say that it was taken away. Silent is not gone.

/// More processes of one robot than this are not told from each other. A holder of the robot's certificate can invent any number.
const PROCESSES: usize = 8;

/// All beyond [`PROCESSES`] together; none has that boot epoch. Where one of them is found, people say when nobody is there any more.
const OTHERS: u64 = 0;

/// The body of a process in an area.
#[derive(Clone, Copy, Debug)]
struct Hold {
    area: usize,
    /// Until then it counts as heard there.
    heard_until_ns: u64,
    /// It was found: it is there, too, when it is silent.
    is_found: bool,
    /// People were told that it is silent.
    told: bool,
}

/// A process, and the areas in which its body stands.
#[derive(Clone, Debug)]
struct Second {
    /// Its boot epoch.
    process: u64,
    /// Of its newest report.
    sequence: u64,
    is_found: bool,
    holds: Vec<Hold>,
}

impl Second {
    fn is_in(&self, area: usize) -> bool {
        self.holds.iter().any(|own| own.area == area)
    }

    /// Its body stands there. Returns whether that is news, to others or to the journal.
    fn hold(&mut self, area: usize, is_found: bool, until_ns: u64) -> (bool, bool) {
        let known = self.holds.iter().position(|own| own.area == area);
        let place = known.unwrap_or_else(|| {
            self.holds.push(Hold {
                area,
                heard_until_ns: 0,
                is_found: false,
                told: false,
            });
            self.holds.len() - 1
        });
        let own = &mut self.holds[place];
        own.heard_until_ns = own.heard_until_ns.max(until_ns);
        own.told = false;
        let is_news = is_found && !own.is_found;
        own.is_found |= is_found;
        (known.is_none(), is_news)
    }
}

/// What a report of such a process says of where it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Said<'a> {
    /// Its boot epoch.
    pub(crate) process: u64,
    /// Of the report.
    pub(crate) sequence: u64,
    /// It was found beside the one that speaks for the robot.
    pub(crate) is_found: bool,
    /// Where its body stands.
    pub(crate) areas: &'a [usize],
    /// Until then it counts as heard.
    pub(crate) until_ns: u64,
}

/// What has changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Change {
    /// Areas with a body more, or fewer.
    pub(crate) areas: Vec<usize>,
    /// Those in which a body was found have changed, which the journal must know.
    pub(crate) found: bool,
}

/// The bodies of other processes with one robot's name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seconds(Vec<Second>);

impl Seconds {
    /// Of the journal: processes that were found, where they were heard last. Each has until then to be heard again.
    pub(super) fn restore(&mut self, process: u64, areas: Vec<usize>, until_ns: u64) {
        let place = self.push(process);
        let own = &mut self.0[place];
        own.is_found = process != OTHERS;
        let hold = |area| Hold {
            area,
            heard_until_ns: until_ns,
            is_found: true,
            told: false,
        };
        own.holds = areas.into_iter().map(hold).collect();
    }

    /// A process that does not know where it is any more is heard: one that was found is where it was.
    pub(super) fn hear(&mut self, process: u64, sequence: u64, until_ns: u64) {
        let mut own = { self.0.iter_mut() }.filter(|own| own.process == process);
        let Some(own) = own.find(|own| own.is_found && sequence > own.sequence) else {
            return;
        };
        own.sequence = sequence;
        for hold in &mut own.holds {
            hold.heard_until_ns = hold.heard_until_ns.max(until_ns);
            hold.told = false;
        }
    }

    /// A process says where it stands.
    pub(super) fn take_in(&mut self, said: &Said<'_>) -> Change {
        let place = self.place_of(said.process);
        let own = &mut self.0[place];
        let mut is_found = said.is_found;
        if own.process != OTHERS {
            if said.sequence <= own.sequence {
                return Change::default();
            }
            own.sequence = said.sequence;
            own.is_found |= is_found;
            is_found = own.is_found;
        }
        let mut change = Change::default();
        for &area in said.areas {
            let (is_new, is_found) = own.hold(area, is_found, said.until_ns);
            change.areas.extend(is_new.then_some(area));
            change.found |= is_found;
        }
        if own.is_found {
            let left = (own.holds).extract_if(.., |own| !said.areas.contains(&own.area));
            let before = change.areas.len();
            change.areas.extend(left.map(|own| own.area));
            change.found |= change.areas.len() > before;
        }
        change
    }

    /// Where the process is, or is put.
    fn place_of(&mut self, process: u64) -> usize {
        let find = |own: &Self, process| own.0.iter().position(|second| second.process == process);
        if let Some(place) = find(self, process) {
            return place;
        }
        let is_told_apart = |second: &&Second| second.process != OTHERS;
        if self.0.iter().filter(is_told_apart).count() < PROCESSES {
            return self.push(process);
        }
        // One that is nowhere makes room.
        let nowhere = |second: &Second| is_told_apart(&second) && second.holds.is_empty();
        if let Some(place) = self.0.iter().position(nowhere) {
            self.0.remove(place);
            return self.push(process);
        }
        find(self, OTHERS).unwrap_or_else(|| self.push(OTHERS))
    }

    fn push(&mut self, process: u64) -> usize {
        self.0.push(Second {
            process,
            sequence: 0,
            is_found: false,
            holds: Vec::new(),
        });
        self.0.len() - 1
    }

    fn holds(&self, area: usize) -> impl Iterator<Item = &Hold> {
        let all = self.0.iter().flat_map(|own| &own.holds);
        all.filter(move |own| own.area == area)
    }

    /// How many bodies are in the area.
    pub(crate) fn bodies(&self, area: usize) -> usize {
        self.holds(area).count()
    }

    /// At least one is in the area.
    pub(crate) fn are_in(&self, area: usize) -> bool {
        self.holds(area).next().is_some()
    }

    /// At least one that was found is in the area.
    pub(crate) fn are_found_in(&self, area: usize) -> bool {
        self.holds(area).any(|own| own.is_found)
    }

    /// This one is in the area.
    pub(crate) fn is_in(&self, process: u64, area: usize) -> bool {
        let mut own = self.0.iter().filter(|own| own.process == process);
        own.any(|own| own.is_in(area))
    }

    /// At least one that is heard is in the area.
    pub(crate) fn are_heard_in(&self, area: usize, now_ns: u64) -> bool {
        self.holds(area).any(|own| now_ns <= own.heard_until_ns)
    }

    /// At least one that is not heard is in the area.
    pub(crate) fn are_silent_in(&self, area: usize, now_ns: u64) -> bool {
        self.holds(area).any(|own| now_ns > own.heard_until_ns)
    }

    /// Areas with such a body, sorted.
    pub(crate) fn areas(&self) -> Vec<usize> {
        let all = self.0.iter().flat_map(|own| &own.holds);
        sorted(all.map(|own| own.area).collect())
    }

    /// Processes that were found, and where they stand for all that is known.
    pub(crate) fn found(&self) -> impl Iterator<Item = (u64, Vec<usize>)> + '_ {
        let found = self.0.iter().map(|own| {
            let holds = own.holds.iter().filter(|own| own.is_found);
            (own.process, holds.map(|own| own.area).collect())
        });
        found.filter(|(_, areas): &(u64, Vec<usize>)| !areas.is_empty())
    }

    /// Ends the holds of processes that were heard too long ago, unless they were found. Returns their areas.
    pub(super) fn drop_silent(&mut self, now_ns: u64) -> Vec<usize> {
        let mut free = Vec::new();
        for own in &mut self.0 {
            let is_over = |own: &mut Hold| !own.is_found && now_ns > own.heard_until_ns;
            free.extend(own.holds.extract_if(.., is_over).map(|own| own.area));
        }
        self.0.retain(|own| own.is_found || !own.holds.is_empty());
        free
    }

    /// Areas in which one that was found has fallen silent now.
    pub(super) fn fall_silent(&mut self, now_ns: u64) -> Vec<usize> {
        let all = self.0.iter_mut().flat_map(|own| &mut own.holds);
        let silent = all.filter(|own| own.is_found && !own.told && now_ns > own.heard_until_ns);
        sorted(
            silent
                .map(|own| {
                    own.told = true;
                    own.area
                })
                .collect(),
        )
    }

    /// The process speaks for the robot from now on. Returns the areas that it held beside it.
    pub(super) fn promote(&mut self, process: u64) -> Vec<usize> {
        let own = self.0.extract_if(.., |own| own.process == process);
        own.flat_map(|own| own.holds).map(|own| own.area).collect()
    }

    /// An operator says that none is in the area of those that are not heard. Returns whether there were any.
    pub(super) fn leave_silent(&mut self, area: usize, now_ns: u64) -> bool {
        let left = self.are_silent_in(area, now_ns);
        self.end(area, |own| now_ns > own.heard_until_ns);
        left
    }

    /// An operator says that none is in the area.
    pub(super) fn leave(&mut self, area: usize) {
        self.end(area, |_| true);
    }

    fn end(&mut self, area: usize, which: impl Fn(&Hold) -> bool) {
        for own in &mut self.0 {
            own.holds.retain(|own| own.area != area || !which(own));
        }
    }
}

fn sorted(mut areas: Vec<usize>) -> Vec<usize> {
    areas.sort_unstable();
    areas.dedup();
    areas
}

#[cfg(test)]
mod tests {
    use super::{Change, PROCESSES, Said, Seconds};

    fn said(process: u64, sequence: u64, areas: &[usize], until_ns: u64) -> Said<'_> {
        Said {
            process,
            sequence,
            is_found: false,
            areas,
            until_ns,
        }
    }

    #[test]
    fn what_one_process_says_ends_no_hold_of_another() {
        let mut seconds = Seconds::default();
        assert_eq!(seconds.take_in(&said(7, 1, &[3], 10)).areas, [3]);
        assert_eq!(seconds.take_in(&said(8, 1, &[3, 4], 20)).areas, [3, 4]);
        let again = seconds.take_in(&said(8, 2, &[3], 15));
        assert_eq!(again, Change::default(), "the same body");
        assert_eq!((seconds.bodies(3), seconds.bodies(4)), (2, 1));
        assert!(seconds.drop_silent(10).is_empty());
        assert_eq!(seconds.drop_silent(16), [3]);
        assert_eq!(seconds.areas(), [3, 4]);
        assert!(seconds.promote(9).is_empty());
        assert_eq!(seconds.promote(8), [3, 4]);
        assert!(seconds.areas().is_empty());
        seconds.take_in(&said(8, 3, &[3, 4], 20));
        seconds.leave(3);
        assert!(!seconds.are_in(3) && seconds.are_in(4));
    }

    #[test]
    fn one_that_was_found_holds_where_it_was_heard_last() {
        let mut seconds = Seconds::default();
        seconds.take_in(&said(7, 1, &[3], 10));
        let found = |sequence, areas, until_ns| Said {
            is_found: true,
            ..said(7, sequence, areas, until_ns)
        };
        let change = |areas: &[usize]| Change {
            areas: areas.to_vec(),
            found: true,
        };
        assert_eq!(seconds.take_in(&found(2, &[3], 20)), change(&[]));
        assert_eq!(seconds.take_in(&found(3, &[3], 20)), Change::default());
        assert!(seconds.are_heard_in(3, 20) && !seconds.are_heard_in(3, 21));
        assert!(seconds.fall_silent(20).is_empty());
        assert_eq!(
            (seconds.fall_silent(21), seconds.fall_silent(22)),
            (vec![3], vec![])
        );
        assert!(seconds.drop_silent(1000).is_empty() && seconds.are_in(3));
        assert_eq!(seconds.found().collect::<Vec<_>>(), [(7, vec![3])]);
        // A late report.
        assert_eq!(seconds.take_in(&found(2, &[5], 30)), Change::default());
        assert_eq!(seconds.take_in(&found(4, &[4], 30)), change(&[4, 3]));
        assert_eq!(seconds.take_in(&found(5, &[], 30)), change(&[4]));
        seconds.restore(9, vec![6], 0);
        assert!(seconds.are_in(6) && !seconds.are_heard_in(6, 1));
        assert_eq!(seconds.fall_silent(1), [6]);
        seconds.take_in(&found(6, &[6], 30));
        assert!(seconds.leave_silent(6, 30) && !seconds.leave_silent(6, 30));
        assert!(seconds.are_in(6), "one is heard there");
    }

    #[test]
    fn invented_processes_are_one_body_more_in_each_area() {
        let mut seconds = Seconds::default();
        for process in 1..1000 {
            seconds.take_in(&said(process, 1, &[3], 10));
        }
        assert_eq!(seconds.bodies(3), PROCESSES + 1);
        assert_eq!(seconds.take_in(&said(2000, 1, &[4], 10)).areas, [4]);
        assert!((seconds.take_in(&said(2001, 1, &[4], 10)).areas).is_empty());
        // Who is gone makes room for others.
        seconds.drop_silent(11);
        assert!(seconds.areas().is_empty());
        assert_eq!(seconds.take_in(&said(2002, 1, &[3], 20)).areas, [3]);
        assert!(seconds.is_in(2002, 3));
    }

    #[test]
    fn one_that_is_found_among_too_many_holds_as_well() {
        let mut seconds = Seconds::default();
        let found = |process, sequence, areas| Said {
            is_found: true,
            ..said(process, sequence, areas, 10)
        };
        for process in 1..=PROCESSES as u64 {
            seconds.take_in(&found(process, 1, &[3]));
        }
        let none = Change::default();
        assert!(!seconds.take_in(&said(20, 1, &[4], 10)).found);
        assert!(seconds.take_in(&found(21, 1, &[5])).found);
        // Of one that is not told from others nobody knows what it has left.
        assert_eq!(seconds.take_in(&found(22, 1, &[5])), none);
        assert_eq!(seconds.take_in(&found(21, 2, &[])), none);
        assert_eq!(seconds.drop_silent(11), [4]);
        assert_eq!(
            (seconds.fall_silent(11), seconds.areas()),
            (vec![3, 5], vec![3, 5])
        );
        let mut restored = Seconds::default();
        seconds
            .found()
            .for_each(|(process, areas)| restored.restore(process, areas, 0));
        assert!(restored.drop_silent(100).is_empty());
        assert_eq!(restored.areas(), [3, 5]);
        assert!(restored.leave_silent(5, 100) && !restored.are_in(5));
    }
}
