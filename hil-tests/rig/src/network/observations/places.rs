//! Where processes say that they stand, by robot.
//!
//! Several may speak with one robot's name. What one of them says ends when it says otherwise, or is silent.

use std::collections::BTreeMap;

use contract::timing::SILENT_AFTER_NS;
use contract::wire::RobotReport;

/// Of all robots.
#[derive(Clone, Debug, Default)]
pub(super) struct Places(BTreeMap<String, BTreeMap<u64, Process>>);

#[derive(Clone, Debug, Default)]
struct Process {
    sequence: u64,
    heard_ns: u64,
    /// Since when it says that it stands there.
    since_ns: BTreeMap<String, u64>,
}

impl Places {
    pub(super) fn take_in(&mut self, report: &RobotReport, at_ns: u64) {
        let processes = self.0.entry(report.robot_id.clone()).or_default();
        processes.retain(|_, own| at_ns <= own.heard_ns.saturating_add(SILENT_AFTER_NS));
        let own = processes.entry(report.boot_epoch).or_default();
        if report.sequence <= own.sequence {
            return;
        }
        (own.sequence, own.heard_ns) = (report.sequence, at_ns);
        if report.located {
            own.since_ns
                .retain(|area, _| report.stands_in.contains(area));
            for area in &report.stands_in {
                own.since_ns.entry(area.clone()).or_insert(at_ns);
            }
        }
    }

    /// Since when a process with the robot's name says that it stands in the area; the first one, where several say so.
    pub(super) fn since_ns(&self, robot: &str, area: &str) -> Option<u64> {
        let processes = self.0.get(robot)?.values();
        processes
            .filter_map(|own| own.since_ns.get(area).copied())
            .min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn say(places: &mut Places, boot_epoch: u64, at: u64, stands_in: &[&str]) {
        let report = RobotReport {
            robot_id: "amr-1".to_owned(),
            boot_epoch,
            sequence: at,
            located: !stands_in.is_empty(),
            stands_in: stands_in.iter().map(|&area| area.to_owned()).collect(),
            ..RobotReport::default()
        };
        places.take_in(&report, at * SILENT_AFTER_NS / 10);
    }

    #[test]
    fn each_process_stands_where_it_says_until_it_says_otherwise_or_is_silent() {
        let mut places = Places::default();
        let since = |places: &Places, area| {
            { places.since_ns("amr-1", area) }.map(|ns| ns / (SILENT_AFTER_NS / 10))
        };
        say(&mut places, 7, 1, &["4"]);
        say(&mut places, 8, 2, &[]);
        assert_eq!([since(&places, "4"), since(&places, "1")], [Some(1), None]);
        say(&mut places, 8, 3, &["1", "4"]);
        say(&mut places, 7, 4, &["5"]);
        assert_eq!(since(&places, "4"), Some(3), "of the second one");
        say(&mut places, 8, 5, &["1"]);
        // It does not know any more, and may stand there yet; an older report means nothing.
        say(&mut places, 8, 6, &[]);
        say(&mut places, 8, 4, &["4"]);
        assert_eq!([since(&places, "4"), since(&places, "1")], [None, Some(3)]);
        say(&mut places, 7, 17, &["5"]);
        assert_eq!([since(&places, "5"), since(&places, "1")], [Some(17), None]);
        assert_eq!(places.since_ns("amr-2", "5"), None);
    }
}
