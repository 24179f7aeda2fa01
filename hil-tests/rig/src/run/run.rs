//! One run of a scenario with a fleet.

use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::Value as Json;
use sim::rt::monotonic_ns;
use sim::world::Truth;

use super::live::Live;
use super::outcome;
use super::stage::{FleetStage, Member, StageSetup};
use crate::cli::Failure;
use crate::goals::{STANDING_M_S, Way};
use crate::judge::{Judge, two_owners};
use crate::record::{Incident, PathPoint, Record};
use crate::scenario::Scenario;

/// How often the judge looks at the world's log.
const LOOK: Duration = Duration::from_millis(20);
/// Points of paths are at least so far apart.
const PATH_NS: u64 = 50_000_000;

/// How a scenario is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The program that becomes mediator and robots: the rig's own.
    pub program: PathBuf,
    /// Decides wheel errors, start offsets, starting times and noise.
    pub seed: u64,
    /// Folder for what the run leaves.
    pub out: PathBuf,
    /// Show nothing while it runs.
    pub headless: bool,
    /// Start the mediator.
    pub mediator: bool,
    /// Leave the site's coordinations as they are.
    pub nets: bool,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// All goals are reached.
    Done,
    /// By a signal.
    Interrupted,
    /// The scenario's patience is over.
    TooSlow,
    /// No robot has moved for the scenario's longest standstill.
    Standstill,
    /// A robot ended by itself.
    RobotEnded(String, ExitStatus),
    /// The mediator ended by itself.
    MediatorEnded(ExitStatus),
}

/// What is known of one robot while it runs.
#[derive(Clone, Debug)]
pub(super) struct Track {
    pub(super) way: Way,
    pub(super) path: Vec<PathPoint>,
    pub(super) truth: Option<Truth>,
    pub(super) fastest_m_s: f64,
    pub(super) symbols: Json,
    path_ns: u64,
    ended_on_purpose: bool,
}

/// A run under way.
pub struct Run {
    /// The scenario.
    pub scenario: Scenario,
    /// World, devices and processes.
    pub stage: FleetStage,
    /// The judge.
    pub judge: Judge,
    pub(super) options: Options,
    pub(super) tracks: Vec<Track>,
    pub(super) incidents: Vec<Incident>,
    moved_ns: u64,
}

/// Runs a scenario to its end, and leaves what there is to know of it.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when goals were not reached or something was violated.
pub fn run(scenario: Scenario, options: Options, asked_to_end: &AtomicBool) -> Result<(), Failure> {
    let mut live = Live::new(options.headless);
    let mut run = Run::start(scenario, options)?;
    let ending = loop {
        std::thread::sleep(LOOK);
        if let Some(ending) = run.look()? {
            break ending;
        }
        live.show(&run);
        if asked_to_end.load(Ordering::Relaxed) {
            break Ending::Interrupted;
        }
    };
    live.end();
    run.finish(&ending)
}

impl Run {
    /// Sets the stage; robots start as their times come.
    ///
    /// # Errors
    /// [`Failure::Refused`] naming what is wrong or cannot be had.
    pub fn start(scenario: Scenario, options: Options) -> Result<Self, Failure> {
        let stage = FleetStage::set(
            &scenario,
            &StageSetup {
                program: options.program.clone(),
                seed: options.seed,
                out: &options.out,
                mediator: options.mediator,
                nets: options.nets,
            },
        )?;
        println!(
            "{}: {} robots in {}, seed {}{}{}; logs in {}",
            scenario.name,
            scenario.robots.len(),
            scenario.site.name,
            options.seed,
            if options.mediator {
                ""
            } else {
                ", WITHOUT mediator"
            },
            if options.nets { "" } else { ", WITHOUT nets" },
            options.out.display()
        );
        let tracks = { scenario.robots.iter() }
            .map(|player| Track {
                way: Way::new(&player.goal),
                path: Vec::new(),
                truth: None,
                fastest_m_s: 0.0,
                symbols: Json::Null,
                path_ns: 0,
                ended_on_purpose: false,
            })
            .collect();
        Ok(Self {
            judge: Judge::new(&scenario, stage.start_ns),
            moved_ns: stage.start_ns,
            tracks,
            incidents: Vec::new(),
            scenario,
            stage,
            options,
        })
    }

    /// Looks at everything once, which should happen some tens of times a second; tells how the run ended, if it did.
    ///
    /// # Errors
    /// [`Failure::Failed`] when a robot cannot be started.
    pub fn look(&mut self) -> Result<Option<Ending>, Failure> {
        self.stage.start_robots()?;
        self.observe();
        for (member, track) in self.stage.members.iter_mut().zip(&self.tracks) {
            member.usage.look();
            let status = member.process().and_then(|process| process.poll());
            if let Some(status) = status
                && !track.ended_on_purpose
            {
                return Ok(Some(Ending::RobotEnded(member.id().to_owned(), status)));
            }
        }
        if let Some(mediator) = &mut self.stage.mediator {
            mediator.usage.look();
            if let Some(status) = mediator.poll() {
                return Ok(Some(Ending::MediatorEnded(status)));
            }
        }
        let now_ns = monotonic_ns();
        let since_s = |from_ns: u64| now_ns.saturating_sub(from_ns) as f64 / 1e9;
        Ok(if outcome::missing(self).is_empty() {
            Some(Ending::Done)
        } else if since_s(self.stage.start_ns) > self.scenario.patience_s {
            Some(Ending::TooSlow)
        } else if since_s(self.moved_ns) > self.scenario.standstill_s {
            Some(Ending::Standstill)
        } else {
            None
        })
    }

    /// Where a robot truly is; none before it was looked at.
    #[must_use]
    pub fn truth(&self, robot: usize) -> Option<Truth> {
        self.tracks.get(robot)?.truth
    }

    /// Kills a robot's process; the run goes on.
    pub fn kill_robot(&mut self, robot: usize) {
        if let (Some(member), Some(track)) = (
            self.stage.members.get_mut(robot),
            self.tracks.get_mut(robot),
        ) && let Some(process) = member.process()
        {
            track.ended_on_purpose = true;
            process.kill();
            let what = format!("{} is killed", member.id());
            self.note(what);
        }
    }

    /// Starts a killed robot again.
    ///
    /// # Errors
    /// [`Failure::Failed`] with the operating system's reason.
    pub fn start_robot_again(&mut self, robot: usize) -> Result<(), Failure> {
        if let (Some(member), Some(track)) = (
            self.stage.members.get_mut(robot),
            self.tracks.get_mut(robot),
        ) {
            member.start()?;
            track.ended_on_purpose = false;
            let what = format!("{} is started again", member.id());
            self.note(what);
        }
        Ok(())
    }

    /// Kills the mediator; the run goes on.
    pub fn kill_mediator(&mut self) {
        if let Some(mediator) = &mut self.stage.mediator {
            mediator.kill();
            self.note("the mediator is killed".to_owned());
        }
    }

    /// Starts the killed mediator again.
    ///
    /// # Errors
    /// [`Failure::Failed`] with the operating system's reason.
    pub fn start_mediator_again(&mut self) -> Result<(), Failure> {
        if let Some(mediator) = &mut self.stage.mediator {
            mediator.start_again().map_err(|error| {
                Failure::failed(format_args!("the mediator cannot be started: {error}"))
            })?;
            self.note("the mediator is started again".to_owned());
        }
        Ok(())
    }

    /// What an operator does with `mediator clear AREA`, having taken these robots away. Returns what the mediator says.
    ///
    /// # Errors
    /// Why it refused or did not answer.
    pub fn clear(&mut self, area: &str, robots: &[&str]) -> Result<String, String> {
        let mediator = self.stage.mediator.as_ref();
        let said = mediator.ok_or("there is no mediator")?.clear(area)?;
        self.judge.cleared(area, robots);
        let mut book = self.stage.listener.book();
        book.cleared(area, robots, monotonic_ns());
        drop(book);
        self.note(format!("area {area} is cleared"));
        Ok(said)
    }

    /// Stops everything, and leaves what there is to know.
    ///
    /// # Errors
    /// [`Failure::Failed`] when goals were not reached or something was violated.
    pub fn finish(mut self, ending: &Ending) -> Result<(), Failure> {
        // Before they end: afterwards there is nothing to look into.
        for robot in 0..self.tracks.len() {
            self.tracks[robot].symbols = self.stage.symbols(robot);
        }
        self.stop();
        let record = Record::of(&self, ending);
        let out = &self.options.out;
        outcome::leave(out, &record)?;
        outcome::print(&record, out);
        if *ending == Ending::Done && record.summary.violations.is_empty() {
            return Ok(());
        }
        Err(Failure::failed(format_args!(
            "{}; {} violations{}",
            record.summary.outcome,
            record.summary.violations.len(),
            self.last_words(ending)
        )))
    }

    /// Stops robots, then the mediator; what they leave is judged.
    fn stop(&mut self) {
        let mut found: Vec<(&str, String, String)> = Vec::new();
        let has_ended = |member: &mut Member| {
            { member.process() }.is_some_and(|process| process.poll().is_some())
        };
        let ended: Vec<bool> = self.stage.members.iter_mut().map(has_ended).collect();
        self.stage.tell_robots_to_stop();
        let members = self.stage.members.iter_mut();
        for ((member, track), by_itself) in members.zip(&self.tracks).zip(ended) {
            let id = member.id().to_owned();
            let Some(process) = member.process() else {
                continue;
            };
            let status = process.stop();
            if !track.ended_on_purpose && (by_itself || !status.success()) {
                let how = if by_itself { " by itself" } else { "" };
                let detail = format!("the robot ended{how} with {status}, expected success");
                found.push(("robot-end", id, detail));
            }
        }
        self.observe();
        for (member, player) in self.stage.members.iter().zip(&self.scenario.robots) {
            for (kind, detail) in
                crate::one_robot::stage::device_violations(&player.config, &member.devices)
            {
                found.push((kind, player.id.clone(), detail));
            }
        }
        if let Some(mediator) = &mut self.stage.mediator {
            let ended = mediator.poll();
            if let Some(status) = mediator.stop()
                && (ended.is_some() || !status.success())
            {
                let detail = format!("the mediator ended with {status}, expected success");
                found.push(("mediator-end", "mediator".to_owned(), detail));
            }
        }
        let now_ns = monotonic_ns();
        for (kind, robot, detail) in found {
            self.judge.report(kind, &robot, now_ns, detail);
        }
        let ownings = self.stage.listener.book().ownings().to_vec();
        for (robot, at_ns, detail) in two_owners(&self.scenario.site, &ownings, now_ns) {
            self.judge.report("two-owners", &robot, at_ns, detail);
        }
    }

    /// Takes in what the world has logged since the last look.
    fn observe(&mut self) {
        let records = self.stage.new_truths();
        let book = self.stage.listener.book();
        for record in &records {
            let (robot, truth) = (record.robot, &record.truth);
            self.judge.observe(robot, truth, &book);
            let Some(track) = self.tracks.get_mut(robot) else {
                continue;
            };
            track.way.observe(truth);
            track.truth = Some(*truth);
            let speed_m_s = truth.twist.v_m_s.abs();
            track.fastest_m_s = track.fastest_m_s.max(speed_m_s);
            if speed_m_s > STANDING_M_S {
                self.moved_ns = self.moved_ns.max(truth.time_ns);
            }
            if truth.time_ns >= track.path_ns + PATH_NS {
                track.path_ns = truth.time_ns;
                track.path.push(PathPoint {
                    at_s: truth.time_ns.saturating_sub(self.stage.start_ns) as f64 / 1e9,
                    pose: truth.pose,
                    speed_m_s: truth.twist.v_m_s,
                    clearance_m: truth.clearance_m,
                });
            }
        }
    }

    fn note(&mut self, what: String) {
        let at_s = self.stage.seconds(monotonic_ns());
        self.incidents.push(Incident { at_s, what });
    }

    /// The end of the log of whoever failed.
    fn last_words(&mut self, ending: &Ending) -> String {
        let log = match ending {
            Ending::RobotEnded(id, _) => {
                let member = self.stage.members.iter().find(|member| member.id() == id);
                member.map(|member| tail(member.log()))
            }
            Ending::MediatorEnded(_) => Some(tail(&self.options.out.join("mediator.log"))),
            _ => None,
        };
        log.map_or(String::new(), |log| format!("; the last words:\n{log}"))
    }
}

fn tail(log: &Path) -> String {
    crate::process::log_tail(log, 12)
}
