//! Log lines that would come again and again: each at most once a minute, and of one kind at most a few.

use std::collections::HashMap;
use std::mem::Discriminant;

use crate::manager::Alarm;

/// A line comes again at most once in this time,
const PAUSE_NS: u64 = 60_000_000_000;
/// and so many different ones of a kind, of each robot, area and coordination of the site, and of all others together: whoever floods the
/// mediator may make up any number of names.
const OF_A_KIND: usize = 8;

/// Which lines were said of late, by kind and subject.
#[derive(Debug, Default)]
pub(super) struct Repeats(HashMap<(Discriminant<Alarm>, Option<String>), Kind>);

#[derive(Debug)]
struct Kind {
    since_ns: u64,
    /// Lines of this minute.
    said: Vec<String>,
    left_out: u64,
    /// The last of those that were left out.
    last: String,
}

impl Repeats {
    /// What to log of an alarm now, if anything.
    pub(super) fn say(&mut self, alarm: &Alarm, now_ns: u64) -> Option<String> {
        let line = alarm.to_string();
        let of = (
            std::mem::discriminant(alarm),
            alarm.subject().map(str::to_owned),
        );
        let kind = { self.0.entry(of) }.or_insert_with(|| Kind {
            since_ns: now_ns,
            said: Vec::new(),
            left_out: 0,
            last: String::new(),
        });
        if kind.said.len() == OF_A_KIND || kind.said.contains(&line) {
            kind.left_out += 1;
            kind.last = line;
            return None;
        }
        kind.said.push(line.clone());
        Some(line)
    }

    /// How many were left out in minutes that are over.
    pub(super) fn left_out(&mut self, now_ns: u64) -> Vec<String> {
        let mut lines = Vec::new();
        self.0.retain(|_, kind| {
            let lasts = now_ns < kind.since_ns.saturating_add(PAUSE_NS);
            if !lasts && kind.left_out > 0 {
                let (left_out, last) = (kind.left_out, &kind.last);
                lines.push(format!(
                    "{left_out} more like this in the last minute: {last}"
                ));
            }
            lasts
        });
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alarm(robot: &str) -> Alarm {
        Alarm::UnknownRobot(robot.to_owned())
    }

    #[test]
    fn a_line_comes_once_a_minute_with_how_often_it_was_left_out() {
        let mut repeats = Repeats::default();
        assert!(
            repeats
                .say(&alarm("amr-9"), 0)
                .is_some_and(|line| line.contains("amr-9"))
        );
        assert!((1..4).all(|step| repeats.say(&alarm("amr-9"), step * PAUSE_NS / 4).is_none()));
        assert!(repeats.left_out(PAUSE_NS - 1).is_empty());
        let lines = repeats.left_out(PAUSE_NS);
        assert!(
            lines.len() == 1 && lines[0].starts_with("3 more like this"),
            "{lines:?}"
        );
        assert!(repeats.say(&alarm("amr-9"), PAUSE_NS).is_some());
        // Nothing was left out since.
        assert!(repeats.left_out(2 * PAUSE_NS).is_empty() && repeats.0.is_empty());
    }

    #[test]
    fn however_many_names_there_are_few_are_logged() {
        let mut repeats = Repeats::default();
        let said = (0..10_000)
            .filter_map(|number| repeats.say(&alarm(&format!("amr-{number}")), 0))
            .count();
        assert_eq!(said, OF_A_KIND);
        let lines = repeats.left_out(PAUSE_NS);
        assert!(
            lines[0].starts_with("9992 more") && lines[0].contains("amr-9999"),
            "{lines:?}"
        );
    }

    #[test]
    fn each_coordination_that_stands_still_and_each_area_with_too_many_is_named() {
        let mut repeats = Repeats::default();
        let still = |number: u32| Alarm::Still {
            coordination: format!("gate-{number}"),
            since_s: 30,
            what: String::new(),
        };
        let overfull = |number: u32| Alarm::Overfull {
            area: number.to_string(),
            capacity: 1,
            found: 2,
            robots: String::new(),
        };
        for number in 0..50 {
            assert!(repeats.say(&still(number), 0).is_some(), "{number}");
            assert!(repeats.say(&overfull(number), 0).is_some(), "{number}");
        }
    }

    #[test]
    fn no_robot_of_the_site_takes_the_lines_of_another() {
        let mut repeats = Repeats::default();
        let intruder = |robot: u32, area: u32| Alarm::Intruder {
            robot: format!("amr-{robot}"),
            area: area.to_string(),
        };
        let mut said = |robot| {
            let lines = (0..100).filter_map(|area| repeats.say(&intruder(robot, area), 0));
            lines.count()
        };
        assert_eq!((0..20).map(&mut said).sum::<usize>(), 20 * OF_A_KIND);
    }
}
