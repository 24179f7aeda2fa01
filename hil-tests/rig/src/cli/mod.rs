//! The command line.

mod campaigns;
mod scenarios;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use onboard::cli::Failure;

use crate::commands;
use crate::scenario::Scenario;
use crate::{bench, devices, map};

use campaigns::{AgreementArgs, CampaignArgs};
use scenarios::{FleetArgs, LapArgs, ScenarioArgs, TrialArgs};

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
        Command::Agreement(own) => own.run(),
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
    use crate::commands::Request;

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
