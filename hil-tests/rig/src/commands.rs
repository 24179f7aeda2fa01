//! The commands that run scenarios: once or many times, through the real programs or on the simulated clock.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use clap::builder::RangedU64ValueParser;
use onboard::cli::Failure;

use crate::campaign::faults::{Ground, Times};
use crate::campaign::shrink::{Again, Shrunk};
use crate::campaign::stepped::Faults;
use crate::campaign::{agreement, faults, processes, stepped};
use crate::output::{end_flag, write};
use crate::run::{Options, Run, finish, record, run};
use crate::scenario::{Changes, Goal, Scenario, load, load_shipped};
use crate::stepped::faults::faulted;
use crate::stepped::{Plans, Stepped};

/// Folder for the output of scenarios, unless told otherwise.
const OUT: &str = "target/rig";
/// Where robots dock, for faults that meet them there.
const DOCKING: &str = "docking";

/// A scenario, and how it is to be run.
#[derive(Clone, Debug)]
pub struct Request {
    /// Scenario file, or the name of one that ships.
    pub scenario: PathBuf,
    /// What is changed in it.
    pub changes: Changes,
    /// No robot drives more rounds than this.
    pub rounds: Option<u32>,
    /// A robot whose goal is laps drives this many.
    pub laps: Option<u32>,
    /// The encoders of each drive have counted as if it had driven for so many hours.
    pub driven_h: Option<f64>,
    /// Seed of the first run.
    pub seed: u64,
    /// How many runs, and by which clock.
    pub many: Many,
    /// Show nothing while it runs.
    pub headless: bool,
    /// Folder for what the runs leave.
    pub out: Option<PathBuf>,
    /// Start a mediator where the site asks for one.
    pub mediator: bool,
    /// Leave the site's coordinations as they are.
    pub nets: bool,
    /// Certificates on every link.
    pub secure: bool,
}

/// Many runs, and the simulated clock.
#[derive(Args, Clone, Debug, Default)]
pub struct Many {
    /// Run on a simulated clock, without threads and devices
    #[arg(long)]
    pub stepped: bool,
    /// Draw faults from the seed of each run, beside those of the scenario (with --stepped)
    #[arg(long, requires = "stepped")]
    pub faults: bool,
    /// Leave out the faults of the scenario's file (with --stepped)
    #[arg(long, requires = "stepped")]
    pub without_faults: bool,
    /// Something that goes wrong, as in a scenario file: '{ at_s = 20.0, for_s = 3.0, what = "unplug", robot = "amr-1" }'
    /// (with --stepped)
    #[arg(long = "fault", value_name = "FAULT", requires = "stepped")]
    pub fault: Vec<String>,
    /// Make all runs, also those that an interrupted campaign has left in the folder (with --stepped)
    #[arg(long, requires = "stepped")]
    pub fresh: bool,
    /// Runs, with this seed and the following ones
    #[arg(long, default_value_t = 1, value_parser = RangedU64ValueParser::<usize>::new().range(1..=1_000_000))]
    pub runs: usize,
    /// Runs at once [default: one; on the simulated clock one for each core]
    #[arg(long)]
    pub jobs: Option<NonZeroUsize>,
}

/// Runs a scenario.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when goals were not reached or something was violated.
pub fn scenario(request: &Request) -> Result<(), Failure> {
    let asked_to_end = end_flag()?;
    let scenario = loaded(request)?;
    let out = folder_of(request, Path::new(OUT).join(&scenario.name));
    let out = request.out.clone().unwrap_or(out);
    if request.many.fresh && request.many.runs == 1 {
        return Err(Failure::refused("--fresh is for many runs"));
    }
    if request.many.stepped && request.secure {
        return Err(Failure::refused(
            "--secure is for real programs: the simulated clock has no network of zenoh",
        ));
    }
    match (request.many.stepped, request.many.runs) {
        (true, 1) => stepped_once(scenario, request, &out, &asked_to_end),
        (true, _) => stepped_often(&scenario, request, &out, &asked_to_end),
        (false, 1) => {
            let options = Options {
                program: std::env::current_exe().map_err(Failure::refused)?,
                onboard: None,
                seed: request.seed,
                out,
                headless: request.headless,
                mediator: request.mediator,
                nets: request.nets,
                secure: request.secure,
            };
            run(&scenario, &options, &asked_to_end)
        }
        (false, _) => processes(&scenario, request, out, &asked_to_end),
    }
}

/// Runs a scenario many times: on the simulated clock, or through the real programs, each run a process of its own, even if it
/// is one run.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when a run failed.
pub fn campaign(request: &Request) -> Result<(), Failure> {
    let asked_to_end = end_flag()?;
    let scenario = loaded(request)?;
    let out = folder_of(request, campaigns(&scenario));
    let out = request.out.clone().unwrap_or(out);
    if request.many.stepped {
        stepped_often(&scenario, request, &out, &asked_to_end)
    } else {
        processes(&scenario, request, out, &asked_to_end)
    }
}

/// Steps the seeds of a campaign of the real programs, and compares; times as well in so many of them at least, or in all.
///
/// # Errors
/// [`Failure::Refused`] when nothing can be compared, [`Failure::Failed`] when they do not come to the same.
pub fn agreement(timed: Option<usize>, request: &Request) -> Result<(), Failure> {
    let mut scenario = loaded(request)?;
    // Leave is withheld on the simulated clock only: the real programs ask their mediator for it.
    scenario.withholds_areas = false;
    let real = { request.out.clone() }.unwrap_or_else(|| campaigns(&scenario));
    agreement::agreement(&scenario, &plans(&scenario, request)?, &real, timed)
}

/// Where campaigns of a scenario leave what they leave, unless told otherwise.
fn campaigns(scenario: &Scenario) -> PathBuf {
    Path::new(OUT).join("campaign").join(&scenario.name)
}

/// Where runs leave what they leave: those on the simulated clock apart from those of the real programs.
fn folder_of(request: &Request, folder: PathBuf) -> PathBuf {
    if request.many.stepped {
        folder.join("stepped")
    } else {
        folder
    }
}

/// Loads the scenario: a path is a file; a name without an extension is a scenario that ships, unless a file has that name.
pub(crate) fn loaded(request: &Request) -> Result<Scenario, Failure> {
    let path = &request.scenario;
    let is_name = path.components().count() == 1 && path.extension().is_none();
    let mut scenario = match path.to_str().filter(|_| is_name && !path.is_file()) {
        Some(name) => load_shipped(name, &request.changes),
        None => load(path, &request.changes),
    }?;
    for player in &mut scenario.robots {
        player.driven_h = request.driven_h.unwrap_or(player.driven_h);
    }
    let goals = scenario.robots.iter_mut().map(|player| &mut player.goal);
    if let Some(wanted) = request.laps {
        for goal in goals {
            if let Goal::Laps(laps) = goal {
                *laps = wanted;
            }
        }
    }
    if request.many.without_faults {
        scenario.faults.clear();
    }
    scenario.add_faults(&request.many.fault)?;
    Ok(match request.rounds {
        Some(rounds) => scenario.with_at_most(rounds),
        None => scenario,
    })
}

/// What the command line changes in a scenario, for another command line.
pub(crate) fn arguments(request: &Request) -> Vec<String> {
    let mut arguments = Vec::new();
    let mut add = |key: &str, value: String| arguments.extend([key.to_owned(), value]);
    if let Some(rounds) = request.rounds {
        add("--rounds", rounds.to_string());
    }
    let Changes { robot, site, set } = &request.changes;
    for (key, file) in [("--robot", robot), ("--site", site)] {
        if let Some(file) = file {
            add(key, file.display().to_string());
        }
    }
    for value in set {
        add("--set", value.clone());
    }
    if let Some(laps) = request.laps {
        add("--laps", laps.to_string());
    }
    if let Some(hours) = request.driven_h {
        add("--driven-h", hours.to_string());
    }
    for (key, wanted) in [
        ("--without-mediator", !request.mediator),
        ("--without-nets", !request.nets),
        ("--secure", request.secure),
    ] {
        arguments.extend(wanted.then(|| key.to_owned()));
    }
    arguments
}

fn processes(
    scenario: &Scenario,
    request: &Request,
    out: PathBuf,
    asked_to_end: &AtomicBool,
) -> Result<(), Failure> {
    let setup = processes::Setup {
        scenario: request.scenario.clone(),
        arguments: arguments(request),
        first_seed: request.seed,
        runs: request.many.runs,
        jobs: request.many.jobs.map_or(1, NonZeroUsize::get),
        out,
    };
    processes::campaign(scenario, &setup, asked_to_end)
}

/// Each kind of fault some times while robots of the scenario drive, and each pair of kinds once where they are wanted.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when a run was unsafe or did not come to its goals.
pub fn fault_campaign(request: &Request, times: &Times) -> Result<(), Failure> {
    let asked_to_end = end_flag()?;
    let out = { request.out.clone() }.unwrap_or_else(|| Path::new(OUT).join("campaign/faults"));
    let ground = |request: &Request| {
        let scenario = loaded(request)?;
        let plans = plans(&scenario, request)?;
        let setup = setup(&scenario, request, &out);
        let ground = Ground::new(scenario, plans, setup.again.clone());
        Ok::<_, Failure>((ground, setup))
    };
    let docking = Request {
        scenario: DOCKING.into(),
        rounds: Some(1),
        ..request.clone()
    };
    let (driving, setup) = ground(request)?;
    let (docking, _) = ground(&docking)?;
    faults::faults([&driving, &docking], &setup, times, &asked_to_end)
}

/// Many runs on the simulated clock: none may have a violation, and the scenario's share must reach all goals.
fn stepped_often(
    scenario: &Scenario,
    request: &Request,
    out: &Path,
    asked_to_end: &AtomicBool,
) -> Result<(), Failure> {
    let many = &request.many;
    let (plans, runs) = (plans(scenario, request)?, many.runs);
    let setup = setup(scenario, request, out);
    let statistics = stepped::campaign(scenario, &plans, &setup, asked_to_end)?;
    if statistics.runs < runs {
        return Err(Failure::failed(format_args!(
            "interrupted after {} of {runs} runs, {} passed: the same command goes on from there{}",
            statistics.runs,
            statistics.passed,
            if many.fresh { ", without --fresh" } else { "" }
        )));
    }
    let share = statistics.done as f64 / statistics.runs.max(1) as f64;
    if statistics.clean == runs && share >= scenario.least_done_share {
        return Ok(());
    }
    Err(Failure::failed(format_args!(
        "{} of {runs} runs failed",
        runs - statistics.passed
    )))
}

fn setup<'a>(scenario: &Scenario, request: &Request, out: &'a Path) -> stepped::Setup<'a> {
    let cores = || std::thread::available_parallelism().ok();
    let many = &request.many;
    let drawn = many.faults;
    let of_file = scenario.faults.len() > many.fault.len();
    stepped::Setup {
        seeds: request.seed..request.seed + many.runs as u64,
        faults: if drawn { Faults::Drawn } else { Faults::None },
        mediator: request.mediator,
        nets: request.nets,
        jobs: many.jobs.or_else(cores).map_or(1, NonZeroUsize::get),
        again: Again {
            scenario: request.scenario.clone(),
            arguments: arguments(request),
            has_faults: many.without_faults || of_file,
        },
        fresh: many.fresh,
        out,
    }
}

fn plans(scenario: &Scenario, request: &Request) -> Result<Plans, Failure> {
    let program = std::env::current_exe().map_err(Failure::refused)?;
    let plans = Plans::of(scenario)?.with_janitor(&program)?;
    Ok(match (request.mediator, request.nets) {
        (false, _) => plans.without_mediator(),
        (true, false) => plans.without_nets(),
        (true, true) => plans,
    })
}

/// One run on the simulated clock, with drawings and traces.
fn stepped_once(
    scenario: Scenario,
    request: &Request,
    out: &Path,
    asked_to_end: &AtomicBool,
) -> Result<(), Failure> {
    let plans = plans(&scenario, request)?;
    let setup = setup(&scenario, request, out);
    let faulted = if request.many.faults {
        faulted(&scenario, request.seed)
    } else {
        scenario.clone()
    };
    let faults = faulted.faults.clone();
    let stepped = Stepped::new(&faulted, &plans, request.seed, true, true)?;
    let mut run = Run::new(faulted, stepped, request.seed);
    let ending = run.run_to_end(request.headless, asked_to_end);
    if let Some(traces) = run.stage.take_traces() {
        for (robot, trace) in run.scenario.robots.iter().zip(&traces.robots) {
            let id = &robot.id;
            write(out, &format!("trace-{id}.csv"), &trace.table.text())?;
            let notes = trace.notes.join("\n") + "\n";
            write(out, &format!("notes-{id}.txt"), &notes)?;
        }
        let others = write(out, "others.csv", &traces.others.text())?;
        onboard::say!(
            "wrote {}, and traces and notes of each robot",
            others.display()
        );
    }
    run.scenario.name.push_str(" (stepped)");
    let before = record(&run, &ending).summary;
    let finished = finish(run, out, &ending);
    if finished.is_err() && !faults.is_empty() && !asked_to_end.load(Ordering::Relaxed) {
        onboard::say!("the run failed, and is made again with fewer faults:");
        let shrinker = setup.shrinker(&scenario, &plans, asked_to_end);
        let shrunk = shrinker.shrink(&[(&before, faults)], |run, _| !run.passed())?;
        shrunk.iter().for_each(Shrunk::print);
    }
    finished
}
