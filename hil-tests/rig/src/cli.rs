//! The command line.

use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use onboard::cli::Failure;

use crate::campaign::faults::Times;
use crate::commands::{self, Many, Request};
use crate::scenario::{Changes, LONGEST_DRIVEN_H, Scenario};
use crate::{bench, devices, map};

/// The campaign of single faults,
const FAULTS: &str = "faults";
/// and the scenario in which they happen.
const FAULTS_IN: &str = "overtaking";

#[derive(Debug, Parser)]
#[command(
    name = "rig",
    version,
    about = "Simulated devices, robots as processes, and a judge"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// A faster robot overtakes a slower one, which a mediator sends into a lay-by
    Overtaking(FleetArgs),
    /// Two small robots and a big one share the access to their docks
    Docking(FleetArgs),
    /// Three robots cross a junction
    TJunction(FleetArgs),
    /// Robots do what a scenario file says
    Scenario(ScenarioArgs),
    /// A scenario many times, with one seed after the other, through the real programs or on a simulated clock
    Campaign(CampaignArgs),
    /// The runs of a campaign through the real programs, again on the simulated clock: do both come to the same?
    Agreement(AgreementArgs),
    /// One robot drives laps of a corridor
    Lap(LapArgs),
    /// One robot over a course that uses every skill
    Course(TrialArgs),
    /// One robot through a corridor with boxes, people and another robot
    Clutter(TrialArgs),
    /// Draw a site file: walls, lanes, areas, zones, starts
    Map(MapArgs),
    /// How fast and how punctual the parts of a robot are on this machine, each beside a rival
    Bench(bench::options::Options),
    /// Run the devices of one robot alone until Ctrl-C
    Devices(devices::Setup),
}

/// Laps, and the state of the drive before them.
#[derive(Clone, Copy, Debug, Args)]
struct Driven {
    /// Laps to drive, where a robot's goal is laps [default: as the scenario says]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    laps: Option<u32>,
    /// The encoders of each drive have counted as if it had driven for so many hours at its top speed
    #[arg(long, value_name = "HOURS", value_parser = hours)]
    driven_h: Option<f64>,
}

/// Arguments of `rig lap`.
#[derive(Clone, Debug, Args)]
struct LapArgs {
    #[command(flatten)]
    driven: Driven,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    run: RunArgs,
}

/// Arguments of scenarios with a fleet.
#[derive(Clone, Debug, Args)]
struct FleetArgs {
    /// No robot drives more rounds than this
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Control run: start no mediator; the scenario must then fail
    #[arg(long)]
    without_mediator: bool,
    /// Control run: remove the site's coordinations
    #[arg(long)]
    without_nets: bool,
    /// Certificates on every link between robots and mediator (not with --stepped)
    #[arg(long)]
    secure: bool,
    #[command(flatten)]
    run: RunArgs,
}

/// Arguments of `rig scenario`.
#[derive(Clone, Debug, Args)]
struct ScenarioArgs {
    /// Scenario file, or the name of one in config/scenarios
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    #[command(flatten)]
    fleet: FleetArgs,
    #[command(flatten)]
    driven: Driven,
    #[command(flatten)]
    changes: Changes,
}

/// Arguments of `rig course` and `rig clutter`.
#[derive(Clone, Debug, Args)]
struct TrialArgs {
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    run: RunArgs,
}

/// Arguments of every scenario.
#[derive(Clone, Debug, Args)]
struct RunArgs {
    /// Decides wheel errors, start offsets, starting times, noise, and what stands in the way
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    many: Many,
    /// Show nothing while it runs
    #[arg(long)]
    headless: bool,
    /// Folder for summary.json, reports and logs [default: target/rig/SCENARIO, and there `stepped` on the simulated
    /// clock]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Arguments of `rig campaign`.
#[derive(Clone, Debug, Args)]
struct CampaignArgs {
    /// Scenario file, or the name of one in config/scenarios; or `faults`: each kind of fault at a moment at which a robot of
    /// the scenario `overtaking` drives, or one of `docking` docks, on the simulated clock
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// Runs, with this seed and the following ones; of `faults` for each kind
    #[arg(long, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=100_000))]
    runs: usize,
    /// Run on a simulated clock, without threads and devices
    #[arg(long)]
    stepped: bool,
    /// Draw faults from the seed of each run (with --stepped)
    #[arg(long, requires = "stepped")]
    faults: bool,
    /// Each pair of kinds of faults once, besides (of `faults`)
    #[arg(long)]
    pairs: bool,
    /// Only these kinds of faults, as their rows are called (of `faults`)
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    only: Vec<String>,
    /// Make all runs, also those that an interrupted campaign has left in the folder (with --stepped)
    #[arg(long, requires = "stepped")]
    fresh: bool,
    /// Runs at once; through the real programs each takes a processor or two [default: one; on the simulated clock one for
    /// each core]
    #[arg(long)]
    jobs: Option<NonZeroUsize>,
    /// Seed of the first run
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    seed: u64,
    /// No robot drives more rounds than this
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Folder for campaign.json and what each run leaves: a folder, or a line of runs.jsonl on the simulated clock [default:
    /// target/rig/campaign/SCENARIO, and there `stepped` on the simulated clock]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn hours(text: &str) -> Result<f64, String> {
    let hours = text.parse::<f64>().map_err(|error| error.to_string())?;
    if (0.0..=LONGEST_DRIVEN_H).contains(&hours) {
        Ok(hours)
    } else {
        Err(format!("found {hours}, expected 0 to {LONGEST_DRIVEN_H}"))
    }
}

impl RunArgs {
    fn request(self, scenario: PathBuf) -> Request {
        Request {
            scenario,
            changes: Changes::default(),
            rounds: None,
            laps: None,
            driven_h: None,
            seed: self.seed,
            many: self.many,
            headless: self.headless,
            out: self.out,
            mediator: true,
            nets: true,
            secure: false,
        }
    }
}

impl LapArgs {
    fn request(self) -> Request {
        Request {
            changes: self.changes,
            laps: self.driven.laps,
            driven_h: self.driven.driven_h,
            ..self.run.request("lap".into())
        }
    }
}

impl FleetArgs {
    fn request(self, scenario: PathBuf) -> Request {
        Request {
            rounds: self.rounds,
            mediator: !self.without_mediator,
            nets: !self.without_nets,
            secure: self.secure,
            ..self.run.request(scenario)
        }
    }
}

impl ScenarioArgs {
    fn request(self) -> Request {
        Request {
            changes: self.changes,
            laps: self.driven.laps,
            driven_h: self.driven.driven_h,
            ..self.fleet.request(self.scenario)
        }
    }
}

impl TrialArgs {
    fn request(self, scenario: &str) -> Request {
        Request {
            changes: self.changes,
            ..self.run.request(scenario.into())
        }
    }
}

impl CampaignArgs {
    fn run(self) -> Result<(), Failure> {
        let times = Times {
            runs: self.runs,
            pairs: self.pairs,
            only: self.only.clone(),
        };
        let of_faults = self.scenario == Path::new(FAULTS);
        let kinds = times.pairs || !times.only.is_empty();
        match (of_faults, kinds, self.faults) {
            (false, true, _) => Err(Failure::refused(
                "--pairs and --only are for `rig campaign faults`",
            )),
            (true, _, true) => Err(Failure::refused(
                "found --faults, expected none: `rig campaign faults` says itself what goes wrong",
            )),
            (true, _, false) => {
                let scenario = FAULTS_IN.into();
                commands::fault_campaign(&Self { scenario, ..self }.request(), &times)
            }
            (false, false, _) => commands::campaign(&self.request()),
        }
    }

    fn request(self) -> Request {
        let run = RunArgs {
            seed: self.seed,
            many: Many {
                stepped: self.stepped,
                faults: self.faults,
                without_faults: false,
                fault: Vec::new(),
                fresh: self.fresh,
                runs: self.runs,
                jobs: self.jobs,
            },
            headless: true,
            out: self.out,
        };
        Request {
            rounds: self.rounds,
            ..run.request(self.scenario)
        }
    }
}

/// Arguments of `rig agreement`.
#[derive(Clone, Debug, Args)]
struct AgreementArgs {
    /// Scenario file, or the name of one in config/scenarios
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// No robot drives more rounds than this, as in the campaign
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Folder of the campaign, with a folder for each seed; agreement.json is left there. Order of grants, firings and violations must be the
    /// same, durations within 2 s or 2 %, largest lateral errors within 3 cm [default: target/rig/campaign/SCENARIO]
    #[arg(long, value_name = "DIR")]
    real: Option<PathBuf>,
    /// Orders are enough: succeed also where the machine stalled in every real run, so that no times were compared
    #[arg(long)]
    untimed: bool,
}

impl AgreementArgs {
    fn request(self) -> Request {
        let run = RunArgs {
            seed: 1,
            many: Many {
                stepped: true,
                ..Many::default()
            },
            headless: true,
            out: self.real,
        };
        Request {
            rounds: self.rounds,
            ..run.request(self.scenario)
        }
    }
}

/// Arguments of `rig map`.
#[derive(Clone, Debug, Args)]
struct MapArgs {
    /// Site file, or the name of one in config/sites
    #[arg(value_name = "SITE")]
    site: PathBuf,
    /// Drawing to write [default: target/rig/map/NAME.svg]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// What a line of `rig scenario` asks for, as a campaign prints it of a run that failed: the scenario, with the faults of the line, and its
/// seed. The first of the words is the program's name.
///
/// # Errors
/// [`Failure::Refused`] when it is no such line, or the scenario cannot be loaded.
pub fn asked(words: impl IntoIterator<Item = String>) -> Result<(Scenario, u64), Failure> {
    match Cli::try_parse_from(words)
        .map_err(Failure::refused)?
        .command
    {
        Command::Scenario(own) => {
            let request = own.request();
            Ok((commands::loaded(&request)?, request.seed))
        }
        _ => Err(Failure::refused(
            "found another command, expected `rig scenario`",
        )),
    }
}

/// Runs the program with these arguments, the first being its name. Ends the process after `--help` and wrong usage.
pub fn main_from(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let result = match Cli::parse_from(arguments).command {
        Command::Overtaking(own) => commands::scenario(&own.request("overtaking".into())),
        Command::Docking(own) => commands::scenario(&own.request("docking".into())),
        Command::TJunction(own) => commands::scenario(&own.request("t-junction".into())),
        Command::Scenario(own) => commands::scenario(&own.request()),
        Command::Campaign(own) => own.run(),
        Command::Agreement(own) => commands::agreement(own.untimed, &own.request()),
        Command::Lap(own) => commands::scenario(&own.request()),
        Command::Course(own) => commands::scenario(&own.request("course")),
        Command::Clutter(own) => commands::scenario(&own.request("clutter")),
        Command::Map(own) => map::map(&own.site, own.out),
        Command::Bench(own) => bench::command::bench(&own),
        Command::Devices(own) => devices::devices(&own),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(words: &[String]) -> Request {
        let parsed = Cli::try_parse_from(["rig".to_owned()].iter().chain(words));
        match parsed.unwrap_or_else(|error| panic!("{error}")).command {
            Command::Lap(own) => own.request(),
            Command::Docking(own) => own.request("docking".into()),
            Command::Scenario(own) => own.request(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_the_command_line_changes_reaches_the_process_of_a_run() {
        for line in [
            "lap --laps 1 --driven-h 24.5 --set a.b=1 --robot r.toml --site s.toml",
            "docking --rounds 2 --without-mediator --without-nets",
            "docking --secure",
        ] {
            let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            let wanted = request(&words);
            let again = ["scenario".to_owned(), wanted.scenario.display().to_string()];
            let again: Vec<String> = { again.into_iter() }
                .chain(commands::arguments(&wanted))
                .collect();
            // All but the seed, how often, and by which clock, which each run has of its own.
            let all = |own: &Request| format!("{own:?}");
            assert_eq!(all(&request(&again)), all(&wanted), "{again:?}");
        }
    }
}
