//! Log lines that would come again and again: each at most once a minute, and of one kind at most a few.

use std::collections::HashMap;
use std::mem::Discriminant;

use crate::manager::Alarm;

/// A line comes again at most once in this time,
const PAUSE_NS: u64 = 60_000_000_000;
/// and so many different ones of a kind, since whoever floods the mediator may make up any number of names.
const OF_A_KIND: usize = 8;

/// Which lines were said of late, by kind.
#[derive(Debug, Default)]
pub(super) struct Repeats(HashMap<Discriminant<Alarm>, Kind>);

#[derive(Debug)]
struct Kind {
    since_ns: u64,
    /// Lines of this minute.
    said: Vec<String>,
    left_out: u64,
}

impl Repeats {
    /// What to log of an alarm now, if anything.
    pub(super) fn say(&mut self, alarm: &Alarm, now_ns: u64) -> Option<String> {
        let line = alarm.to_string();
        let kind = { self.0.entry(std::mem::discriminant(alarm)) }.or_insert_with(|| Kind {
            since_ns: now_ns,
            said: Vec::new(),
            left_out: 0,
        });
        if kind.said.len() == OF_A_KIND || kind.said.contains(&line) {
            kind.left_out += 1;
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
            if !lasts && let (Some(last), 1..) = (kind.said.pop(), kind.left_out) {
                lines.push(format!(
                    "{} more like this in the last minute: {last}",
                    kind.left_out
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
        assert!(lines[0].starts_with("9992 more"), "{lines:?}");
    }
}
