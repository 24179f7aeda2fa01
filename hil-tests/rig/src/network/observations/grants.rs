//! What a mediator itself has granted, and when that has reached its robot: that a robot says so is no grant.

use std::collections::BTreeMap;

/// A mediator's word of one grant.
#[derive(Clone, Copy, Debug)]
struct Word {
    journal: u64,
    fence: u64,
    said_ns: u64,
    /// Known only where it is known which messages arrive, on the simulated clock.
    reached_ns: Option<u64>,
}

/// All words, by robot and area, in the order in which they were said first.
#[derive(Clone, Debug, Default)]
pub(super) struct Grants {
    words: BTreeMap<String, BTreeMap<String, Vec<Word>>>,
    /// It is known which messages arrive.
    delivers: bool,
}

impl Grants {
    /// A mediator says that a robot has an area by this fence of this journal.
    pub(super) fn said(
        &mut self,
        robot: &str,
        area: &str,
        (journal, fence): (u64, u64),
        at_ns: u64,
    ) {
        if self.find(robot, area, (journal, fence)).is_some() {
            return;
        }
        let of_robot = self.words.entry(robot.to_owned()).or_default();
        of_robot.entry(area.to_owned()).or_default().push(Word {
            journal,
            fence,
            said_ns: at_ns,
            reached_ns: None,
        });
    }

    /// From now on it is known which messages arrive.
    pub(super) fn deliver(&mut self) {
        self.delivers = true;
    }

    /// That has reached the robot.
    pub(super) fn reached(&mut self, robot: &str, area: &str, by: (u64, u64), at_ns: u64) {
        if let Some(word) = self.find(robot, area, by) {
            word.reached_ns.get_or_insert(at_ns);
        }
    }

    /// Whether the robot knew of it by then.
    pub(super) fn was_given(&self, robot: &str, area: &str, by: (u64, u64), at_ns: u64) -> bool {
        let all = self.words.get(robot).and_then(|own| own.get(area));
        let mut words = all.into_iter().flatten().rev();
        words.any(|word| {
            let known_ns = if self.delivers {
                word.reached_ns
            } else {
                Some(word.said_ns)
            };
            (word.journal, word.fence) == by && known_ns.is_some_and(|known_ns| known_ns <= at_ns)
        })
    }

    fn find(&mut self, robot: &str, area: &str, by: (u64, u64)) -> Option<&mut Word> {
        let all = self.words.get_mut(robot)?.get_mut(area)?;
        // The newest ones are the likely ones.
        { all.iter_mut().rev() }.find(|word| (word.journal, word.fence) == by)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grant_counts_from_when_it_was_said_and_where_that_is_known_from_when_it_arrived() {
        let mut grants = Grants::default();
        let given =
            |grants: &Grants, fence, at_ns| grants.was_given("amr-1", "gate", (7, fence), at_ns);
        assert!(!given(&grants, 3, 100));
        grants.said("amr-1", "gate", (7, 3), 100);
        grants.said("amr-1", "gate", (7, 3), 500);
        assert!(
            !given(&grants, 3, 99) && given(&grants, 3, 100),
            "the first time"
        );
        assert!(!given(&grants, 4, 100), "another fence");
        assert!(
            !grants.was_given("amr-1", "gate", (8, 3), 100),
            "another journal"
        );
        assert!(!grants.was_given("amr-2", "gate", (7, 3), 100));
        grants.deliver();
        grants.said("amr-1", "gate", (7, 4), 600);
        grants.reached("amr-1", "gate", (7, 4), 700);
        grants.reached("amr-1", "gate", (7, 4), 900);
        assert!(!given(&grants, 4, 699) && given(&grants, 4, 700));
        assert!(!given(&grants, 3, 1000), "it was lost");
        grants.reached("amr-1", "gate", (7, 5), 900);
        assert!(!given(&grants, 5, 1000), "nobody has said so");
    }
}
