//! What a run comes to: what is missing, its record, files and figures.

use std::path::Path;

use sim::rt::monotonic_ns;

use super::run::{Ending, Run};
use crate::cli::Failure;
use crate::network::observations::Book;
use crate::one_robot::stage::{robot_summary, write};
use crate::one_robot::summary::{Machine, RobotSummary, round};
use crate::record::{CoordinationRecord, Holding, Record, RobotRecord, Span, StateChange, Wait};
use crate::report;
use crate::summary::{
    AreaSummary, CoordinationSummary, FiringSummary, FleetSummary, Latency, MediatorSummary,
    MemberSummary, OwnerSummary, PartSummary,
};

/// A request that was granted sooner did not wait.
const NO_WAIT_S: f64 = 0.1;

/// What has not been reached yet, in words; empty: all goals are reached.
pub(super) fn missing(run: &Run) -> Vec<String> {
    let mut missing = Vec::new();
    for (player, track) in run.scenario.robots.iter().zip(&run.tracks) {
        let way = &track.way;
        if let Some(next) = way.next() {
            missing.push(format!(
                "{} has driven {} of {} rounds and has to go to {next}",
                player.id,
                way.rounds(),
                way.wanted()
            ));
        }
    }
    for (id, wanted) in &run.scenario.coordinations {
        let ended = ended(run, id);
        if ended < *wanted {
            missing.push(format!(
                "coordination {id} has run to its end {ended} of {wanted} times"
            ));
        }
    }
    if missing.is_empty() {
        let never = run.judge.rules().into_iter();
        missing.extend(
            never
                .filter(|rule| rule.checked_s <= 0.0)
                .map(|rule| format!("it was never so that {}", rule.rule)),
        );
    }
    missing
}

/// How many runs of a coordination have come to a declared end of their net.
fn ended(run: &Run, id: &str) -> u32 {
    let Some(board) = &run.stage.board else {
        return 0;
    };
    let is_end = |net: &str, marking: &[String]| {
        let net = run.scenario.nets.iter().find(|own| own.name == net);
        net.is_some_and(|net| {
            { net.ends.iter() }.any(|end| end.places.iter().all(|place| marking.contains(place)))
        })
    };
    let seen = board.seen();
    let ended = seen.courses.values().filter(|course| {
        let status = &course.status;
        status.over && status.id == id && is_end(&status.net, &status.marking)
    });
    u32::try_from(ended.count()).unwrap_or(u32::MAX)
}

impl Record {
    /// All that is known of a run, after everything was stopped.
    pub(super) fn of(run: &Run, ending: &Ending) -> Self {
        let now_ns = monotonic_ns();
        let seconds = |at_ns: u64| round(run.stage.seconds(at_ns));
        let book = run.stage.listener.book();
        let holdings: Vec<Holding> = { book.ownings().iter() }
            .map(|own| Holding {
                area: own.area.clone(),
                robot: own.robot.clone(),
                fence: own.fence,
                requested_s: own.requested_ns.map(seconds),
                granted_s: seconds(own.granted_ns),
                entered_s: own.entered_ns.map(seconds),
                released_s: own.released_ns.map(seconds),
                returned: own.returned,
            })
            .collect();
        let waits: Vec<Wait> = { book.waitings().iter() }
            .map(|own| Wait {
                robot: own.robot.clone(),
                area: own.area.clone(),
                from_s: seconds(own.from_ns),
                to_s: own.to_ns.map(seconds),
                why: own.why.clone(),
            })
            .collect();
        let coordinations = coordinations(run);
        let ms =
            |measured: &[u64]| -> Vec<f64> { measured.iter().map(|&ns| ns as f64 / 1e6).collect() };
        let grant_latency_ms = ms(&book.latencies().grants_ns);
        let command_latency_ms = ms(&book.latencies().commands_ns);
        let robots = robots(run, &book);
        drop(book);
        let summary = FleetSummary {
            scenario: run.scenario.name.clone(),
            outcome: in_words(run, ending),
            seed: run.options.seed,
            duration_s: seconds(now_ns),
            machine: Machine::here(),
            robots: members(run),
            mediator: { run.stage.mediator.as_ref() }.map(|mediator| MediatorSummary {
                starts: u32::try_from(mediator.spans_ns().len()).unwrap_or(u32::MAX),
                rss_mib: round(mediator.usage.largest_rss_mib()),
                cpu_percent: round(mediator.usage.cpu_percent()),
            }),
            areas: areas(run, &holdings, &waits, seconds(now_ns)),
            coordinations: coordinations.iter().map(in_short).collect(),
            grants: Latency::of(&grant_latency_ms),
            commands: Latency::of(&command_latency_ms),
            during: run.judge.rules(),
            violations: run.judge.violations().to_vec(),
        };
        Self {
            scenario: run.scenario.name.clone(),
            about: run.scenario.about.clone(),
            site: run.scenario.site.clone(),
            nets: run.scenario.nets.clone(),
            robots,
            holdings,
            waits: { waits.into_iter() }
                .filter(|wait| wait.to_s.is_none_or(|to_s| to_s - wait.from_s > NO_WAIT_S))
                .collect(),
            coordinations,
            mediator: { run.stage.mediator.iter() }
                .flat_map(|mediator| mediator.spans_ns())
                .map(|&(from_ns, to_ns)| Span {
                    from_s: seconds(from_ns),
                    to_s: seconds(to_ns.unwrap_or(now_ns)),
                })
                .collect(),
            incidents: run.incidents.clone(),
            grant_latency_ms,
            command_latency_ms,
            summary,
        }
    }
}

fn robots(run: &Run, book: &Book) -> Vec<RobotRecord> {
    let seconds = |at_ns: u64| round(run.stage.seconds(at_ns));
    { run.scenario.robots.iter() }
        .zip(&run.tracks)
        .map(|(player, track)| RobotRecord {
            id: player.id.clone(),
            role: role(run, &player.id),
            footprint: player.config.footprint,
            path: track.path.clone(),
            states: { book.steps().iter() }
                .filter(|step| step.robot == player.id)
                .map(|step| StateChange {
                    at_s: seconds(step.at_ns),
                    state: step.state.clone(),
                    area: step.area.clone(),
                    skill: step.skill.clone(),
                })
                .collect(),
        })
        .collect()
}

fn role(run: &Run, id: &str) -> String {
    let robot = run.scenario.site.robots.get(id);
    robot.map_or(String::new(), |robot| robot.role.clone())
}

fn members(run: &Run) -> Vec<MemberSummary> {
    { run.scenario.robots.iter() }
        .zip(run.tracks.iter().zip(&run.stage.members))
        .map(|(player, (track, member))| MemberSummary {
            robot: RobotSummary {
                laps: track.way.rounds(),
                max_speed_m_s: round(track.fastest_m_s),
                ..robot_summary(
                    &player.config,
                    &member.devices,
                    &member.usage,
                    track.truth.as_ref(),
                    &track.symbols,
                )
            },
            role: role(run, &player.id),
            wanted: track.way.wanted(),
            done_s: { track.way.done_ns() }.map(|at_ns| round(run.stage.seconds(at_ns))),
        })
        .collect()
}

fn areas(run: &Run, holdings: &[Holding], waits: &[Wait], now_s: f64) -> Vec<AreaSummary> {
    { run.scenario.site.areas.iter() }
        .map(|area| AreaSummary {
            id: area.id.clone(),
            capacity: area.capacity,
            owners: { holdings.iter() }
                .filter(|own| own.area == area.id)
                .map(|own| OwnerSummary {
                    robot: own.robot.clone(),
                    fence: own.fence,
                    requested_s: own.requested_s,
                    granted_s: own.granted_s,
                    entered_s: own.entered_s,
                    released_s: own.released_s,
                })
                .collect(),
            longest_wait_s: { waits.iter() }
                .filter(|wait| wait.area == area.id)
                .map(|wait| round(wait.to_s.unwrap_or(now_s) - wait.from_s))
                .fold(0.0, f64::max),
        })
        .collect()
}

fn coordinations(run: &Run) -> Vec<CoordinationRecord> {
    let Some(board) = &run.stage.board else {
        return Vec::new();
    };
    let seconds = |at_ns: u64| round(run.stage.seconds(at_ns));
    let seen = board.seen();
    { seen.courses.values() }
        .map(|course| CoordinationRecord {
            number: course.status.number,
            id: course.status.id.clone(),
            net: course.status.net.clone(),
            situation: course.status.situation.clone(),
            robots: course.status.robots.clone(),
            from_s: seconds(course.from_ns),
            to_s: course.to_ns.map(seconds),
            firings: { course.firings.iter() }
                .map(|(transition, at_ns)| (transition.clone(), seconds(*at_ns)))
                .collect(),
            marking: course.status.marking.clone(),
        })
        .collect()
}

fn in_short(record: &CoordinationRecord) -> CoordinationSummary {
    CoordinationSummary {
        number: record.number,
        id: record.id.clone(),
        net: record.net.clone(),
        situation: record.situation.clone(),
        robots: { record.robots.iter() }
            .map(|(role, robot)| PartSummary {
                role: role.clone(),
                robot: robot.clone(),
            })
            .collect(),
        from_s: record.from_s,
        duration_s: record.to_s.map(|to_s| round(to_s - record.from_s)),
        firings: { record.firings.iter() }
            .map(|(transition, at_s)| FiringSummary {
                transition: transition.clone(),
                at_s: *at_s,
            })
            .collect(),
    }
}

fn in_words(run: &Run, ending: &Ending) -> String {
    let not_complete = |why: String| format!("not complete: {why}: {}", missing(run).join("; "));
    match ending {
        Ending::Done => "done".to_owned(),
        Ending::Interrupted => "interrupted".to_owned(),
        Ending::TooSlow => not_complete(format!("{} s are over", run.scenario.patience_s)),
        Ending::Standstill => not_complete(format!(
            "no robot has moved for {} s",
            run.scenario.standstill_s
        )),
        Ending::RobotEnded(id, status) => format!("robot {id} ended by itself with {status}"),
        Ending::MediatorEnded(status) => format!("the mediator ended by itself with {status}"),
    }
}

/// Writes what a run leaves.
pub(super) fn leave(out: &Path, record: &Record) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(&record.summary).map_err(Failure::failed)?;
    write(out, "summary.json", &json)?;
    write(out, "report.html", &report::fleet::html(record))?;
    Ok(())
}

/// Prints what a summary says.
pub(super) fn print(record: &Record, out: &Path) {
    let summary = &record.summary;
    println!(
        "outcome: {} after {:.1} s",
        summary.outcome, summary.duration_s
    );
    for member in &summary.robots {
        let robot = &member.robot;
        println!(
            "{} ({}): {} of {} rounds, {:.2} m, {} collisions, clearance at least {:.3} m, {:.1} MiB, {:.1} % of one core, {} lost frames, {} scans dropped",
            robot.id,
            member.role,
            robot.laps,
            member.wanted,
            robot.distance_m,
            robot.collisions,
            robot.min_clearance_m,
            robot.rss_mib,
            robot.cpu_percent,
            robot.ethercat.lost_frames,
            robot.lidar.dropped
        );
    }
    if let Some(mediator) = &summary.mediator {
        println!(
            "mediator: started {} times, {:.1} MiB, {:.1} % of one core",
            mediator.starts, mediator.rss_mib, mediator.cpu_percent
        );
    }
    for coordination in &summary.coordinations {
        let length = coordination.duration_s.map_or_else(
            || "not over".to_owned(),
            |duration_s| format!("{duration_s:.1} s"),
        );
        println!(
            "coordination {} {} ({}): {length}, {} firings",
            coordination.id,
            coordination.number,
            coordination.situation,
            coordination.firings.len()
        );
    }
    let latency = |what: &str, own: &Latency| {
        let ms = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        println!(
            "{what}: {} measured, p50 {} ms, p99 {} ms, max {} ms",
            own.count,
            ms(own.p50_ms),
            ms(own.p99_ms),
            ms(own.max_ms)
        );
    };
    latency("request to grant when free", &summary.grants);
    latency("robot's flag to mediator's command", &summary.commands);
    for rule in &summary.during {
        println!(
            "{}: checked for {:.1} s, broken for {:.1} s",
            rule.rule, rule.checked_s, rule.broken_s
        );
    }
    for violation in &summary.violations {
        println!(
            "VIOLATION {} of {} at {:.1} s: {}",
            violation.kind, violation.robot, violation.at_s, violation.detail
        );
    }
    println!(
        "wrote {} and report.html",
        out.join("summary.json").display()
    );
}
