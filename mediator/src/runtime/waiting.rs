//! What waits for management, bounded whatever arrives: of each process of each robot its newest report, and questions.
//!
//! A report says all that there is to know, so a newer one of the same process replaces an older one: however long the disk takes,
//! management then takes in what robots have said last, and no robot crowds out another.

use std::collections::{HashMap, VecDeque};

use contract::wire::RobotReport;

use super::input::{Asked, Input};

/// Processes of one robot that may wait at a time: one, and those that should not be there. The oldest report gives way.
const PROCESSES: usize = 4;
/// Reports of robots that the site does not list. They get a refusal, as far as there is time.
const STRANGERS: usize = 16;
/// Questions of operators.
const QUESTIONS: usize = 64;

/// What waits for management.
pub struct Waiting {
    robots: HashMap<String, usize>,
    /// By robot, the oldest first.
    reports: Vec<VecDeque<Box<RobotReport>>>,
    /// Robots of which reports wait, in the order in which the first of them came.
    order: VecDeque<usize>,
    strangers: VecDeque<Box<RobotReport>>,
    questions: VecDeque<Asked>,
    /// Reports and questions that found no room.
    dropped: u64,
}

impl Waiting {
    /// Nothing yet; for the robots that the site lists.
    #[must_use]
    pub fn new(robots: impl IntoIterator<Item = String>) -> Self {
        let robots: HashMap<String, usize> = { robots.into_iter().enumerate() }
            .map(|(number, id)| (id, number))
            .collect();
        Self {
            reports: robots.iter().map(|_| VecDeque::new()).collect(),
            robots,
            order: VecDeque::new(),
            strangers: VecDeque::new(),
            questions: VecDeque::new(),
            dropped: 0,
        }
    }

    /// The site lists this robot.
    #[must_use]
    pub fn knows(&self, robot_id: &str) -> bool {
        self.robots.contains_key(robot_id)
    }

    /// How many robots the site lists.
    #[must_use]
    pub fn robots(&self) -> usize {
        self.robots.len()
    }

    /// A report has come.
    pub fn report(&mut self, report: Box<RobotReport>) {
        let Some(&robot) = self.robots.get(&report.robot_id) else {
            if self.strangers.len() == STRANGERS {
                self.strangers.pop_front();
                self.dropped += 1;
            }
            self.strangers.push_back(report);
            return;
        };
        let own = &mut self.reports[robot];
        if own.is_empty() {
            self.order.push_back(robot);
        }
        let before = own
            .iter_mut()
            .find(|own| own.boot_epoch == report.boot_epoch);
        match before {
            Some(before) if before.sequence < report.sequence => *before = report,
            // A late one: what it says is known.
            Some(_) => {}
            None => {
                if own.len() == PROCESSES {
                    own.pop_front();
                    self.dropped += 1;
                }
                own.push_back(report);
            }
        }
    }

    /// An operator asks. Returns whether there is room for the question.
    pub fn ask(&mut self, asked: Asked) -> bool {
        let fits = self.questions.len() < QUESTIONS;
        if fits {
            self.questions.push_back(asked);
        } else {
            self.dropped += 1;
        }
        fits
    }

    /// Nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.order.is_empty() && self.strangers.is_empty() && self.questions.is_empty()
    }

    /// The next thing to take in: robots of the site in turn, then questions, then strangers.
    pub fn take_next(&mut self) -> Option<Input> {
        if let Some(&robot) = self.order.front() {
            let own = &mut self.reports[robot];
            let report = own.pop_front();
            if own.is_empty() {
                self.order.pop_front();
            }
            if let Some(report) = report {
                return Some(Input::Report(report));
            }
        }
        let asked = self.questions.pop_front().map(Input::Question);
        asked.or_else(|| self.strangers.pop_front().map(Input::Report))
    }

    /// What has found no room since the start.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::super::input::Asker;
    use super::super::question::Question;
    use super::*;

    fn report(robot: &str, boot_epoch: u64, sequence: u64) -> Box<RobotReport> {
        Box::new(RobotReport {
            robot_id: robot.to_owned(),
            boot_epoch,
            sequence,
            ..RobotReport::default()
        })
    }

    fn waiting() -> Waiting {
        Waiting::new(["amr-1", "amr-2"].map(str::to_owned))
    }

    /// Robot, boot and sequence of all reports, in the order in which they are taken in.
    fn taken(waiting: &mut Waiting) -> Vec<(String, u64, u64)> {
        std::iter::from_fn(|| waiting.take_next())
            .map(|input| match input {
                Input::Report(own) => (own.robot_id.clone(), own.boot_epoch, own.sequence),
                Input::Question(_) => ("question".to_owned(), 0, 0),
            })
            .collect()
    }

    #[test]
    fn the_newest_report_of_each_process_waits_and_robots_take_turns() {
        let mut waiting = waiting();
        for sequence in [1, 3, 2] {
            waiting.report(report("amr-1", 7, sequence));
            waiting.report(report("amr-2", 5, sequence));
        }
        waiting.report(report("amr-1", 8, 1));
        let expected = [("amr-1", 7, 3), ("amr-1", 8, 1), ("amr-2", 5, 3)];
        let expected = expected.map(|(id, boot, sequence)| (id.to_owned(), boot, sequence));
        assert_eq!(taken(&mut waiting), expected);
        assert!(waiting.is_empty() && waiting.dropped() == 0);
        // It may come again.
        waiting.report(report("amr-1", 7, 4));
        assert_eq!(taken(&mut waiting), [("amr-1".to_owned(), 7, 4)]);
    }

    #[test]
    fn whoever_floods_it_crowds_out_no_other_robot() {
        let mut waiting = waiting();
        waiting.report(report("amr-2", 5, 1));
        for number in 1..10_000 {
            waiting.report(report("amr-1", number, 1));
            waiting.report(report(&format!("stranger-{number}"), 1, 1));
        }
        let taken = taken(&mut waiting);
        assert_eq!(taken.len(), 1 + PROCESSES + STRANGERS);
        assert_eq!(taken[0], ("amr-2".to_owned(), 5, 1));
        assert!(waiting.dropped() > 19_000);
    }

    #[test]
    fn questions_are_bounded_and_come_after_robots() {
        let mut waiting = waiting();
        for number in 0..100 {
            let asked = Asked::new(Question::Status, Asker::default(), Box::new(drop));
            assert_eq!(waiting.ask(asked), number < QUESTIONS);
        }
        waiting.report(report("amr-1", 7, 1));
        let taken = taken(&mut waiting);
        assert_eq!((taken.len(), taken[0].1), (QUESTIONS + 1, 7));
    }
}
