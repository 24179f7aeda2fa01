//! Other processes with one robot's name, and where their bodies stand.
//!
//! Several may run at once, and come and go: what one of them says ends no hold of another. One that may be a restart, or somebody's
//! late words, holds an area from its last report of standing there until a process counts as silent. One that was *found* beside the
//! one that speaks for the robot is another body: it holds what it was last heard to stand in until it is heard elsewhere, or people
//! say that it was taken away. Silent is not gone. So does one that was refused *alone*, while none that speaks for the robot was
//! heard, until a new one is taken in, which is taken for its next process. Where the robot itself was heard last such a one is the robot,
//! for all that is known, until the robot is heard elsewhere.
//!
//! The process that spoke for the robot before a new one is the robot, too, until that has said where it stands: then that is its next one,
//! and it is nowhere, or it is another body, which was found.

mod second;

use crate::journal::Before;
use second::{Hold, Second};
pub(crate) use second::{Judged, Known, Speaker};

/// More processes of one robot than this are not told from each other. A holder of the robot's certificate can invent any number.
const PROCESSES: usize = 8;

/// All beyond [`PROCESSES`] together; none has that boot epoch. Where one of them is found, people say when nobody is there any more.
const OTHERS: u64 = 0;

/// What a report of such a process says of where it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Said<'a> {
    /// Its boot epoch.
    pub(crate) process: u64,
    /// Of the report.
    pub(crate) sequence: u64,
    /// It is there, too, when it is silent.
    pub(crate) known: Known,
    /// It has heard what was said after a new process was taken in: that is not its next one.
    pub(crate) lives: bool,
    /// Where its body stands,
    pub(crate) areas: &'a [usize],
    /// and where that is the robot's own one, for all that is known.
    pub(crate) with_robot: &'a [usize],
    /// Until then it counts as heard.
    pub(crate) until_ns: u64,
}

/// A process that was found, as the journal knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Found {
    /// Its boot epoch.
    pub(crate) process: u64,
    /// Of a report that it has sent: older ones say nothing of where it is.
    pub(crate) sequence: u64,
    /// It was refused while none that speaks for the robot was heard.
    pub(crate) alone: bool,
    /// Where it stands, for all that is known,
    pub(crate) areas: Vec<usize>,
    /// and where its body is the robot's own one, for all that is known.
    pub(crate) with_robot: Vec<usize>,
    /// It spoke for the robot before a new process, which has not said yet where it stands.
    pub(crate) before: Option<Before>,
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
    pub(super) fn restore(&mut self, found: Found, until_ns: u64) {
        let place = self.push(found.process);
        let own = &mut self.0[place];
        own.is_found = found.process != OTHERS;
        own.sequence = found.sequence;
        (own.alone, own.before) = (found.alone, found.before);
        let hold = |(area, is_robot)| Hold {
            heard_until_ns: until_ns,
            is_found: true,
            ..Hold::of(area, is_robot)
        };
        let areas = found.areas.into_iter().map(|area| (area, false));
        let with_robot = found.with_robot.into_iter().map(|area| (area, true));
        own.holds = areas.chain(with_robot).map(hold).collect();
    }

    /// A process that does not know where it is any more is heard: it is where it was, whatever it says.
    pub(super) fn hear(&mut self, said: &Said<'_>, beside: bool) -> Change {
        let mut change = Change::default();
        let mut is_found = said.known != Known::Nothing;
        let own = self.find(said.process);
        // Where one was that is not told from others nobody knows: in all areas of these, then.
        let Some(place) = own.or_else(|| self.find(OTHERS).filter(|_| is_found)) else {
            return change;
        };
        let own = &mut self.0[place];
        if own.process != OTHERS {
            change.found |= own.note(said.known);
            change.found |= own.hears(said.lives);
            is_found = own.is_found;
            if own.has_sent(said.sequence).is_none() {
                return change;
            }
        }
        if beside {
            for appears in own.is_another() {
                change.areas.push(appears.area);
                change.found |= appears.is_found;
            }
        }
        for hold in &mut own.holds {
            hold.heard_until_ns = hold.heard_until_ns.max(said.until_ns);
            hold.told = false;
            change.found |= is_found && !hold.is_found;
            hold.is_found |= is_found;
        }
        change
    }

    /// A process says where it stands.
    pub(super) fn take_in(&mut self, said: &Said<'_>) -> Change {
        let place = self.place_of(said.process);
        let own = &mut self.0[place];
        let mut change = Change::default();
        let (mut is_found, mut moves) = (said.known != Known::Nothing, false);
        if own.process != OTHERS {
            let Some(is_reached) = own.has_sent(said.sequence) else {
                return change;
            };
            change.found |= own.note(said.known);
            change.found |= own.hears(said.lives);
            is_found = own.is_found;
            moves = is_found && is_reached;
        }
        let areas = said.areas.iter().map(|&area| (area, false));
        let with_robot = said.with_robot.iter().map(|&area| (area, true));
        for (area, is_robot) in areas.chain(with_robot) {
            let (is_new, is_found) = own.hold(area, is_robot, is_found, said.until_ns);
            change.areas.extend(is_new.then_some(area));
            change.found |= is_found;
        }
        if moves {
            let is_said =
                |area: &usize| said.areas.contains(area) || said.with_robot.contains(area);
            for left in (own.holds).extract_if(.., |own| !is_said(&own.area)) {
                change.areas.push(left.area);
                change.found = true;
            }
        }
        change
    }

    /// The robot is heard elsewhere: whoever might have been the robot there is another one. Returns whether the journal must know.
    pub(super) fn robot_leaves(&mut self, area: usize) -> bool {
        // One before is judged by all that the robot says of where it stands.
        let all = self.0.iter_mut().filter(|own| own.before.is_none());
        let all = all.flat_map(|own| &mut own.holds);
        let appear = all.filter(|own| own.is_robot && own.area == area);
        appear.fold(false, |is_news, own| {
            own.is_robot = false;
            is_news || own.is_found
        })
    }

    /// Where the process is, or is put.
    fn place_of(&mut self, process: u64) -> usize {
        if let Some(place) = self.find(process) {
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
        self.find(OTHERS).unwrap_or_else(|| self.push(OTHERS))
    }

    fn find(&self, process: u64) -> Option<usize> {
        self.0.iter().position(|own| own.process == process)
    }

    fn push(&mut self, process: u64) -> usize {
        self.0.push(Second {
            process,
            sequence: 0,
            is_found: false,
            alone: false,
            has_next: false,
            before: None,
            holds: Vec::new(),
        });
        self.0.len() - 1
    }

    /// Of bodies besides the robot's.
    fn all_holds(&self) -> impl Iterator<Item = &Hold> {
        let all = self.0.iter().flat_map(|own| &own.holds);
        all.filter(|own| !own.is_robot)
    }

    fn holds(&self, area: usize) -> impl Iterator<Item = &Hold> {
        self.all_holds().filter(move |own| own.area == area)
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
        sorted(self.all_holds().map(|own| own.area).collect())
    }

    /// Processes that were found, and where they stand for all that is known. Of one that is nowhere its number counts, too.
    pub(crate) fn found(&self) -> impl Iterator<Item = Found> + '_ {
        self.0.iter().filter_map(|own| {
            let areas = |is_robot: bool| -> Vec<usize> {
                let all = own.holds.iter().filter(|own| own.is_found);
                let all = all.filter(|own| own.is_robot == is_robot);
                all.map(|own| own.area).collect()
            };
            let found = Found {
                process: own.process,
                sequence: own.sequence,
                alone: own.alone,
                areas: areas(false),
                with_robot: areas(true),
                before: own.before,
            };
            let is_anywhere = !found.areas.is_empty() || !found.with_robot.is_empty();
            (own.is_found || is_anywhere).then_some(found)
        })
    }

    /// Ends the holds of processes that were heard too long ago, unless they were found.
    pub(super) fn drop_silent(&mut self, now_ns: u64) -> Change {
        let mut change = Change::default();
        for own in &mut self.0 {
            let ends = |hold: &Hold| !hold.is_found || own.has_next;
            let is_over = |hold: &mut Hold| ends(hold) && now_ns > hold.heard_until_ns;
            for hold in own.holds.extract_if(.., is_over) {
                change.areas.push(hold.area);
                change.found |= hold.is_found;
            }
        }
        let stays = |own: &Second| own.is_found && !own.has_next || !own.holds.is_empty();
        self.0.retain(stays);
        change
    }

    /// Areas in which one that was found has fallen silent now.
    pub(super) fn fall_silent(&mut self, now_ns: u64) -> Vec<usize> {
        let all = self.0.iter_mut().flat_map(|own| &mut own.holds);
        let all = all.filter(|own| own.is_found && !own.told && !own.is_robot);
        let silent = all.filter(|own| now_ns > own.heard_until_ns);
        sorted(
            silent
                .map(|own| {
                    own.told = true;
                    own.area
                })
                .collect(),
        )
    }

    /// The process speaks for the robot. One that is new is the next one of those that reported alone, unless these are heard beside it; one
    /// that spoke before they did is another one. Returns the areas that it held itself, and those with a body more.
    pub(super) fn promote(&mut self, process: u64, is_new: bool) -> (Vec<usize>, Vec<usize>) {
        let own = self.0.extract_if(.., |own| own.process == process);
        let areas = own.flat_map(|own| own.holds).map(|own| own.area).collect();
        let mut appear = Vec::new();
        for own in self.0.iter_mut().filter(|own| own.alone) {
            own.has_next |= is_new;
            if !is_new {
                appear.extend(own.is_another().map(|own| own.area));
            }
        }
        (areas, appear)
    }

    /// A new process speaks for the robot, or may. Until one has said where it stands, those before it are one body with the first of them, which
    /// had said so.
    pub(super) fn note_before(&mut self, speaker: Speaker, stood: Before, areas: &[usize]) {
        let is_known = |own: &Second| own.before.is_some() || own.process == speaker.process;
        if !self.0.iter().any(is_known) {
            self.0.push(Second::of_before(speaker, stood, areas));
        }
    }

    /// It is taken for the one before, until the new one has said where it stands.
    pub(super) fn is_before(&self, process: u64) -> bool {
        let mut own = self.0.iter().filter(|own| own.process == process);
        own.any(|own| own.before.is_some())
    }

    /// The process that speaks for the robot says where it stands. Returns what became of the one before.
    pub(super) fn judge_before(&mut self, stands_in: &[usize]) -> Option<Judged> {
        let place = self.0.iter().position(|own| own.before.is_some())?;
        let own = self.0.remove(place);
        if own.leads_to(stands_in) {
            let beside = own.holds.iter().filter(|hold| !hold.is_robot);
            return Some(Judged::Next(beside.map(|hold| hold.area).collect()));
        }
        let (process, sequence) = (own.process, own.sequence);
        let areas: Vec<usize> = own.holds.iter().map(|hold| hold.area).collect();
        let place = self.place_of(process);
        let room = &mut self.0[place];
        if room.process != OTHERS {
            (room.sequence, room.is_found) = (sequence, true);
        }
        for hold in own.holds {
            room.hold(hold.area, false, true, hold.heard_until_ns);
        }
        let told = { room.holds.iter_mut() }.filter(|hold| areas.contains(&hold.area));
        told.for_each(|hold| hold.told = true);
        Some(Judged::Another { process, areas })
    }

    /// The process that speaks for the robot does not know where it is. Where it `has` nothing any more the one before is all the same. Returns
    /// areas with a body more.
    pub(super) fn keep_before(&mut self, has: impl Fn(usize) -> bool) -> Vec<usize> {
        let before = self.0.iter_mut().filter(|own| own.before.is_some());
        let holds = before.flat_map(|own| &mut own.holds);
        let appear = holds.filter(|hold| hold.is_robot && !has(hold.area));
        appear
            .map(|hold| {
                (hold.is_robot, hold.told) = (false, false);
                hold.area
            })
            .collect()
    }

    /// An operator says that none is in the area of those that are not heard. Returns whether there were any.
    pub(super) fn leave_silent(&mut self, area: usize, now_ns: u64) -> bool {
        let left = self.are_silent_in(area, now_ns);
        // Who is the robot itself, for all that is known, goes with it.
        self.end(area, |own| !own.is_robot && now_ns > own.heard_until_ns);
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
mod before_tests;
#[cfg(test)]
mod tests;
