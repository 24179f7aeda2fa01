//! The thread table: every activity on exactly one thread, on one that suits it.

use crate::diagnostic::ProblemKind;
use crate::loaded::RobotConfig;
use crate::report::Report;
use description::threads::{ActivityKind, Scheduling, ThreadConfig, Trigger};

/// Linux cuts longer names.
const LONGEST_NAME: usize = 15;

pub(super) fn check(robot: &RobotConfig, report: &Report) {
    for thread in &robot.threads {
        let key = format!("threads.{}", thread.name);
        if thread.name.len() > LONGEST_NAME {
            report.wrong(
                ProblemKind::OutOfRange,
                &key,
                format!("a name of {} characters", thread.name.len()),
                format!("a thread's name, at most {LONGEST_NAME} characters"),
            );
        }
        if thread.activities.is_empty() && !report.touched(&[&key]) {
            report.wrong(
                ProblemKind::OutOfRange,
                &format!("{key}.activities"),
                "an empty array",
                "at least one activity",
            );
        }
    }
    // A misspelt activity would be missing, too: one problem for one mistake.
    let readable = !report.touched(&["threads"]);
    for &kind in ActivityKind::ALL {
        once(robot, kind, readable, report);
    }
    if !report.touched(&["threads"]) {
        robot
            .threads
            .iter()
            .for_each(|thread| suits(thread, report));
    }
}

fn once(robot: &RobotConfig, kind: ActivityKind, readable: bool, report: &Report) {
    let places: Vec<(&ThreadConfig, String)> = robot
        .threads
        .iter()
        .flat_map(|thread| {
            let of_kind = move |(index, activity): (usize, &ActivityKind)| {
                let key = format!("threads.{}.activities[{index}]", thread.name);
                (*activity == kind).then_some((thread, key))
            };
            thread.activities.iter().enumerate().filter_map(of_kind)
        })
        .collect();
    match places.as_slice() {
        [] if readable => {
            let names: Vec<&str> = robot
                .threads
                .iter()
                .map(|thread| thread.name.as_str())
                .collect();
            let problem = report
                .problem(
                    ProblemKind::MissingKey,
                    "threads",
                    format!("activity `{kind}` on no thread"),
                    format!("`{kind}` in `activities` of exactly one thread"),
                )
                .with_hint(format!(
                    "the threads are {}",
                    description::keys::quoted_list(&names, "and")
                ));
            report.push(problem);
        }
        [] | [_] => {}
        [(first, first_key), rest @ ..] => {
            for (thread, key) in rest {
                let found = format!(
                    "`{kind}` on thread `{}` and on `{}`",
                    first.name, thread.name
                );
                let expected = "each activity on exactly one thread";
                let problem = report.problem(ProblemKind::Duplicate, key, found, expected);
                report.push(report.origin.also(problem, first_key, "first here"));
            }
        }
    }
}

/// What an activity needs of its thread.
fn suits(thread: &ThreadConfig, report: &Report) {
    let key = format!("threads.{}", thread.name);
    let runs = |kind| thread.activities.contains(&kind);
    let wrong = |name: &str, found: String, expected: &str| {
        report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.{name}"),
            found,
            expected,
        );
    };
    if runs(ActivityKind::Communication) {
        if thread.activities.len() > 1 {
            let found = format!("{} other activities beside it", thread.activities.len() - 1);
            wrong(
                "activities",
                found,
                "`communication` on a thread of its own: the network may block it",
            );
        }
        if thread.trigger != Trigger::Async {
            wrong(
                "trigger",
                shown(thread.trigger),
                "`async`, which `communication` runs on",
            );
        }
        if let Scheduling::Fifo { priority } = thread.scheduling {
            let found = format!("`fifo` {priority}");
            wrong(
                "scheduling",
                found,
                "`normal`: `communication` is no real-time activity",
            );
        }
    } else if thread.trigger == Trigger::Async {
        let expected = "`period`, `lidar` or `scan`: only `communication` is asynchronous";
        wrong("trigger", shown(thread.trigger), expected);
    }
    if thread.trigger == Trigger::Lidar && thread.activities != [ActivityKind::Lidar] {
        let expected = "another trigger, or no activity but `lidar`, which waits for the device";
        wrong("trigger", shown(thread.trigger), expected);
    }
    if runs(ActivityKind::Lidar) && thread.trigger != Trigger::Lidar {
        wrong(
            "trigger",
            shown(thread.trigger),
            "`lidar`, which the lidar activity waits for",
        );
    }
    for kind in [ActivityKind::Drive, ActivityKind::Control] {
        if runs(kind) && !matches!(thread.trigger, Trigger::Period { .. }) {
            let expected = format!("`period`: `{kind}` must run at a steady rate");
            wrong("trigger", shown(thread.trigger), &expected);
        }
    }
}

fn shown(trigger: Trigger) -> String {
    format!("`{}`", trigger.name())
}
