//! What a run prints when it is over.

use std::path::Path;

use super::repeat::SPOILED;
use crate::figures::Figures;
use crate::machine::Machine;
use crate::summary::{Latency, RobotSummary, Summary};

/// Prints what a summary says.
pub(super) fn print(summary: &Summary, out: &Path) {
    onboard::say!(
        "outcome: {} after {:.1} s",
        summary.outcome,
        summary.duration_s
    );
    if let Some(stalls) = summary.stalls.filter(|stalls| stalls.count > 0) {
        onboard::say!("{stalls}; the host took {:.0} ms", stalls.steal_ms);
    }
    if let Some(spoiled) = &summary.spoiled {
        onboard::say!(
            "it was made once more: before, {} ({}); what that run left is in {}",
            spoiled.reason,
            spoiled.stalls,
            out.join(SPOILED).display()
        );
    }
    for robot in &summary.robots {
        print_robot(robot);
        if summary.robots.len() == 1 {
            print_details(robot, &summary.machine);
        }
        if let Some(figures) = &robot.figures {
            print_figures(figures);
        }
    }
    if let Some(mediator) = &summary.mediator {
        onboard::say!(
            "mediator: started {} times{}",
            mediator.starts,
            usage(mediator.rss_mib, mediator.cpu_percent)
        );
    }
    for coordination in &summary.coordinations {
        let length = coordination.duration_s.map_or_else(
            || "not over".to_owned(),
            |duration_s| format!("{duration_s:.1} s"),
        );
        onboard::say!(
            "coordination {} {} ({}): {length}, {} firings",
            coordination.id,
            coordination.number,
            coordination.situation,
            coordination.firings.len()
        );
    }
    let latency = |what: &str, own: &Latency| {
        let ms = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        onboard::say!(
            "{what}: {} measured, p50 {} ms, p99 {} ms, max {} ms",
            own.count,
            ms(own.p50_ms),
            ms(own.p99_ms),
            ms(own.max_ms)
        );
    };
    if summary.mediator.is_some() {
        latency("request to grant when free", &summary.grants);
        latency("robot's flag to mediator's command", &summary.commands);
    }
    for rule in &summary.during {
        onboard::say!(
            "{}: checked for {:.1} s, broken for {:.1} s",
            rule.rule,
            rule.checked_s,
            rule.broken_s
        );
    }
    for violation in &summary.violations {
        onboard::say!(
            "VIOLATION {} of {} at {:.1} s: {}",
            violation.kind,
            violation.robot,
            violation.at_s,
            violation.detail
        );
    }
    onboard::say!(
        "wrote {} and report.html",
        out.join("summary.json").display()
    );
}

fn print_robot(robot: &RobotSummary) {
    onboard::say!(
        "{} ({}): {} of {} rounds, {:.2} m, {} collisions, clearance at least {:.3} m, lateral error at most {:.3} m{}, \
         {} lost frames, {} scans dropped",
        robot.id,
        robot.role,
        robot.laps,
        robot.wanted,
        robot.distance_m,
        robot.collisions,
        robot.min_clearance_m,
        robot.max_lateral_error_m,
        usage(robot.rss_mib, robot.cpu_percent),
        robot.ethercat.lost_frames,
        robot.lidar.dropped
    );
    if robot.resets > 0 {
        onboard::say!("  reset {} times", robot.resets);
    }
    if robot.driven_out > 0 {
        onboard::say!("  driven out by hand {} times", robot.driven_out);
    }
    if robot.restarted > 0 {
        onboard::say!("  restarted {} times", robot.restarted);
    }
}

/// What a process took of the machine; nothing where it was not one.
fn usage(rss_mib: Option<f64>, cpu_percent: Option<f64>) -> String {
    { rss_mib.zip(cpu_percent) }.map_or_else(String::new, |(rss_mib, cpu_percent)| {
        format!(", {rss_mib:.1} MiB, {cpu_percent:.1} % of one core")
    })
}

/// Devices and threads of a robot that is alone.
fn print_details(robot: &RobotSummary, machine: &Machine) {
    onboard::say!(
        "  EtherCAT: {} cycles, {} lost, {} wrong counters; lidar: {} scans, {} dropped; on {}, {} cores",
        robot.ethercat.cycles,
        robot.ethercat.lost_frames,
        robot.ethercat.wkc_errors,
        robot.lidar.scans,
        robot.lidar.dropped,
        machine.processor,
        machine.cores
    );
    for (name, thread) in robot.threads.as_object().into_iter().flatten() {
        let of = |what: &str, part: &str| thread[what][part].as_f64().unwrap_or(0.0);
        onboard::say!(
            "  {name:<14} wake-up p50 {:>6.0} p99 {:>6.0} max {:>7.0} µs; execution p50 {:>5.0} p99 {:>6.0} max {:>7.0} µs; {} overruns of {}",
            of("wakeup_us", "p50"),
            of("wakeup_us", "p99"),
            of("wakeup_us", "max"),
            of("exec_us", "p50"),
            of("exec_us", "p99"),
            of("exec_us", "max"),
            thread["overruns"],
            thread["cycles"]
        );
    }
}

/// What the judge found out about one robot.
fn print_figures(figures: &Figures) {
    let list = |errors: &[f64]| {
        let errors: Vec<String> = errors.iter().map(|error| format!("{error:+.3}")).collect();
        if errors.is_empty() {
            "none".to_owned()
        } else {
            errors.join(", ")
        }
    };
    onboard::say!(
        "  pose error in view at most {:.3} m, {:.2}°; docking {} m; stops at a pose {} m, before an area {} m",
        figures.max_pose_error_m,
        figures.max_heading_error_rad.to_degrees(),
        list(&figures.dock_errors_m),
        list(&figures.pose_stop_errors_m),
        list(&figures.border_stop_errors_m)
    );
    let skills: Vec<&str> = figures.skills.iter().map(String::as_str).collect();
    onboard::say!(
        "  {} skills ran: {}; run into {} times while standing; held {:.1} s",
        skills.len(),
        skills.join(", "),
        figures.run_into,
        figures.held_s
    );
}
