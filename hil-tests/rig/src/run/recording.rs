//! What is left of a run: its record and figures.

use super::ending::Ending;
use super::execution::{Execution, MediatorRuns};
use super::watch::{Run, Track};
use crate::machine::{Machine, round};
use crate::network::mediator_status::CoordinationSeen;
use crate::network::observations::Observations;
use crate::record::{Record, RobotRecord, Span, StateChange, Wait};
use crate::scenario::Player;
use crate::stalls::{LongStall, StallWatch};
use crate::summary::{
    AreaSummary, CoordinationSummary, DONE, FiringSummary, Holding, Latency, PartSummary,
    RobotSummary, Summary,
};

/// A request that was granted sooner than this did not wait.
const NO_WAIT_S: f64 = 0.1;

/// All that is known of a run, after everything was stopped.
pub fn record<E: Execution>(run: &Run<E>, ending: &Ending) -> Record {
    let now_ns = run.stage.now_ns();
    let seconds = |at_ns: u64| round(run.stage.seconds(at_ns));
    let heard = run
        .stage
        .heard(|observations| Heard::of(observations, &seconds));
    let mediator = run.stage.mediator();
    let stranded = match ending {
        Ending::Stranded(fault, since_ns) => Some((*fault, seconds(*since_ns))),
        _ => None,
    };
    let watch = run.stage.stall_watch();
    let summary = Summary {
        scenario: run.scenario.name.clone(),
        outcome: in_words(run, ending),
        stranded_by: stranded.map(|(fault, _)| fault.to_owned()),
        stranded_since_s: stranded.map(|(_, since_s)| since_s),
        seed: run.seed,
        duration_s: seconds(now_ns),
        machine: Machine::here(),
        stalls: watch.map(StallWatch::stalls),
        long_stalls: { watch.into_iter() }
            .flat_map(StallWatch::long)
            .map(|stall| LongStall {
                from_s: seconds(stall.start),
                to_s: seconds(stall.end),
            })
            .collect(),
        spoiled: None,
        robots: { 0..run.tracks.len() }
            .map(|robot| robot_summary(run, robot))
            .collect(),
        mediator: mediator.as_ref().map(|mediator| mediator.summary),
        areas: areas(run, &heard, seconds(now_ns)),
        coordinations: coordinations(run),
        grants: Latency::of(&heard.grant_latency_ms),
        commands: Latency::of(&heard.command_latency_ms),
        during: run.judge.rules(),
        violations: run.judge.violations().to_vec(),
    };
    let waited = |wait: &Wait| wait.to_s.is_none_or(|to_s| to_s - wait.from_s > NO_WAIT_S);
    Record {
        about: run.scenario.about.clone(),
        site: run.scenario.site.clone(),
        nets: run.scenario.nets.clone(),
        limits: run.scenario.limits,
        robots: { run.scenario.robots.iter().zip(&run.tracks) }
            .map(|(player, track)| robot(run, player, track, &heard))
            .collect(),
        obstacles: run.stage.obstacles(),
        holdings: heard.holdings,
        waits: heard.waits.into_iter().filter(waited).collect(),
        mediator: { mediator.iter() }
            .flat_map(|MediatorRuns { spans_ns, .. }| spans_ns)
            .map(|&(from_ns, to_ns)| Span {
                from_s: seconds(from_ns),
                to_s: seconds(to_ns.unwrap_or(now_ns)),
            })
            .collect(),
        incidents: run.incidents.clone(),
        grant_latency_ms: heard.grant_latency_ms,
        command_latency_ms: heard.command_latency_ms,
        summary,
    }
}

/// What was heard on the network, with times in seconds.
struct Heard {
    holdings: Vec<Holding>,
    waits: Vec<Wait>,
    /// Each with its robot.
    states: Vec<(String, StateChange)>,
    grant_latency_ms: Vec<f64>,
    command_latency_ms: Vec<f64>,
}

impl Heard {
    fn of(observations: &Observations, seconds: &impl Fn(u64) -> f64) -> Self {
        let ms = |measured: &[u64]| measured.iter().map(|&ns| ns as f64 / 1e6).collect();
        Self {
            holdings: { observations.ownings().iter() }
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
                .collect(),
            waits: { observations.waitings().iter() }
                .map(|own| Wait {
                    robot: own.robot.clone(),
                    area: own.area.clone(),
                    from_s: seconds(own.from_ns),
                    to_s: own.to_ns.map(seconds),
                    why: own.why.clone(),
                })
                .collect(),
            states: { observations.steps().iter() }
                .map(|step| {
                    let change = StateChange {
                        at_s: seconds(step.at_ns),
                        state: step.state.clone(),
                        area: step.area.clone(),
                        skill: step.skill.clone(),
                        believed_m: step.believed_m,
                    };
                    (step.robot.clone(), change)
                })
                .collect(),
            grant_latency_ms: ms(&observations.latencies().grants_ns),
            command_latency_ms: ms(&observations.latencies().commands_ns),
        }
    }
}

/// States are those that were heard; without a network, those that were believed.
fn robot<E>(run: &Run<E>, player: &Player, track: &Track, heard: &Heard) -> RobotRecord {
    let mut states: Vec<StateChange> = { heard.states.iter() }
        .filter(|(robot, _)| *robot == player.id)
        .map(|(_, change)| change.clone())
        .collect();
    if states.is_empty() {
        states.clone_from(&track.states);
    }
    RobotRecord {
        id: player.id.clone(),
        role: role(run, &player.id),
        model: player.config.identity.model.clone(),
        max_speed_m_s: player.config.drive.limits.max_speed_m_s,
        footprint: player.config.footprint,
        path: track.path.points().to_vec(),
        states,
    }
}

fn role<E>(run: &Run<E>, id: &str) -> String {
    let robot = run.scenario.site.robots.get(id);
    robot.map_or(String::new(), |robot| robot.role.clone())
}

fn robot_summary<E: Execution>(run: &Run<E>, robot: usize) -> RobotSummary {
    let (player, track) = (&run.scenario.robots[robot], &run.tracks[robot]);
    RobotSummary {
        role: role(run, &player.id),
        laps: track.progress.rounds(),
        wanted: track.progress.wanted(),
        done_s: { track.progress.done_ns() }.map(|at_ns| round(run.stage.seconds(at_ns))),
        max_lateral_error_m: round(run.judge.max_lateral_error_m(robot)),
        max_speed_m_s: round(track.fastest_m_s),
        withheld: track.withheld(),
        figures: { run.scenario.looks_inside() }.then(|| run.judge.figures(robot).clone()),
        ..run.stage.robot_summary(robot, track.truth.as_ref())
    }
}

fn areas<E>(run: &Run<E>, heard: &Heard, now_s: f64) -> Vec<AreaSummary> {
    { run.scenario.site.areas.iter() }
        .map(|area| AreaSummary {
            id: area.id.clone(),
            capacity: area.capacity,
            owners: { heard.holdings.iter() }
                .filter(|own| own.area == area.id)
                .cloned()
                .collect(),
            longest_wait_s: { heard.waits.iter() }
                .filter(|wait| wait.area == area.id)
                .map(|wait| round(wait.to_s.unwrap_or(now_s) - wait.from_s))
                .fold(0.0, f64::max),
        })
        .collect()
}

fn coordinations<E: Execution>(run: &Run<E>) -> Vec<CoordinationSummary> {
    let seconds = |at_ns: u64| round(run.stage.seconds(at_ns));
    let summary = |seen: &CoordinationSeen| {
        let status = &seen.status;
        let from_s = seconds(seen.from_ns);
        CoordinationSummary {
            number: status.number,
            id: status.id.clone(),
            net: status.net.clone(),
            situation: status.situation.clone(),
            robots: { status.robots.iter().cloned() }
                .map(|(role, robot)| PartSummary { role, robot })
                .collect(),
            from_s,
            duration_s: seen.to_ns.map(|to_ns| round(seconds(to_ns) - from_s)),
            firings: { seen.firings.iter().cloned() }
                .map(|(transition, at_ns)| FiringSummary {
                    transition,
                    at_s: seconds(at_ns),
                })
                .collect(),
            marking: status.marking.clone(),
        }
    };
    run.stage.told(|told| {
        let seen = told
            .into_iter()
            .flat_map(|told| told.coordinations.values());
        seen.map(summary).collect()
    })
}

fn in_words<E: Execution>(run: &Run<E>, ending: &Ending) -> String {
    let not_complete = |why: String| format!("not complete: {why}: {}", run.missing().join("; "));
    match ending {
        Ending::Done => DONE.to_owned(),
        Ending::Interrupted => "interrupted".to_owned(),
        Ending::TooSlow => not_complete(format!("{} s are over", run.scenario.longest_s())),
        Ending::Standstill => not_complete(format!(
            "no robot has moved for {} s",
            run.scenario.standstill_s
        )),
        Ending::Stranded(fault, _) => not_complete(format!(
            "fault {fault} waits for an operator, after {:.0} s",
            run.stage.seconds(run.stage.now_ns())
        )),
        Ending::RobotEnded(id, status) => format!("robot {id} ended by itself with {status}"),
        Ending::BrokenOff(why) => format!("broken off: {why}"),
        Ending::MediatorEnded(status) => format!("the mediator ended by itself with {status}"),
    }
}
