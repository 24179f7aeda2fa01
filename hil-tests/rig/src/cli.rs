//! The command line.

use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use onboard::cli::EXIT_REFUSED;
pub use onboard::cli::Failure;

use crate::one_robot::{lap, trials};
use crate::{commands, devices, map};

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
    /// Robots and a mediator do what a scenario file says
    Scenario(ScenarioArgs),
    /// A scenario with a fleet many times, with one seed after the other
    Campaign(CampaignArgs),
    /// One robot drives laps of a corridor
    Lap(LapArgs),
    /// One robot over a course that uses every skill
    Course(TrialArgs),
    /// One robot through a corridor with boxes, people and another robot
    Clutter(TrialArgs),
    /// Draw a site file: walls, lanes, areas, zones, starts
    Map(MapArgs),
    /// Run the devices of one robot alone until Ctrl-C
    Devices(DevicesArgs),
}

/// Arguments of `rig lap`.
#[derive(Clone, Debug, Args)]
pub struct LapArgs {
    /// Decides wheel errors, start offset and noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Laps to drive
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    pub laps: u32,
    /// Show no progress line
    #[arg(long)]
    pub headless: bool,
    /// Robot file
    #[arg(long, value_name = "FILE", default_value = "config/robots/amr-1.toml")]
    pub robot: PathBuf,
    /// Site file
    #[arg(
        long,
        value_name = "FILE",
        default_value = "config/sites/corridor.toml"
    )]
    pub site: PathBuf,
    /// Folder for summary.json and report.svg
    #[arg(long, value_name = "DIR", default_value = "target/rig/lap")]
    pub out: PathBuf,
}

/// Arguments of scenarios with a fleet.
#[derive(Clone, Debug, Args)]
pub struct FleetArgs {
    /// Decides wheel errors, start offsets, starting times and noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// No robot drives more rounds than this
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub rounds: Option<u32>,
    /// Show nothing while it runs
    #[arg(long)]
    pub headless: bool,
    /// Folder for summary.json, report.html and logs [default: target/rig/SCENARIO]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Control: start no mediator, so that it must not complete
    #[arg(long)]
    pub without_mediator: bool,
    /// Control: take the site's coordinations out
    #[arg(long)]
    pub without_nets: bool,
}

/// Arguments of `rig scenario`.
#[derive(Clone, Debug, Args)]
pub struct ScenarioArgs {
    /// Scenario file, or the name of one in config/scenarios
    #[arg(value_name = "SCENARIO")]
    pub scenario: PathBuf,
    /// As for the scenarios that ship.
    #[command(flatten)]
    pub fleet: FleetArgs,
}

/// Arguments of `rig campaign`.
#[derive(Clone, Debug, Args)]
pub struct CampaignArgs {
    /// Scenario file, or the name of one in config/scenarios
    #[arg(value_name = "SCENARIO")]
    pub scenario: PathBuf,
    /// Runs, with this seed and the following ones
    #[arg(long, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=100_000))]
    pub runs: usize,
    /// Runs at once; each takes a processor or two
    #[arg(long, default_value_t = 1, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=64))]
    pub jobs: usize,
    /// Seed of the first run
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub seed: u64,
    /// No robot drives more rounds than this
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub rounds: Option<u32>,
    /// Folder for campaign.json and a folder for each run [default: target/rig/campaign/SCENARIO]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `rig course` and `rig clutter`.
#[derive(Clone, Debug, Args)]
pub struct TrialArgs {
    /// Run on a simulated clock, without threads and devices
    #[arg(long)]
    pub stepped: bool,
    /// Runs, with this seed and the following ones
    #[arg(long, default_value_t = 1, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=1_000_000))]
    pub runs: usize,
    /// Decides wheel errors, start offset, noise, and what stands in the way
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Threads for stepped runs [default: one for each core]
    #[arg(long)]
    pub jobs: Option<NonZeroUsize>,
    /// Show no progress line
    #[arg(long)]
    pub headless: bool,
    /// Robot file
    #[arg(long, value_name = "FILE", default_value = "config/robots/amr-1.toml")]
    pub robot: PathBuf,
    /// Site file [default: the scenario's own]
    #[arg(long, value_name = "FILE")]
    pub site: Option<PathBuf>,
    /// Change one value of either file, such as drive.max_speed_m_s=0.3
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Folder for what the runs leave [default: target/rig/SCENARIO]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `rig map`.
#[derive(Clone, Debug, Args)]
pub struct MapArgs {
    /// Site file, or the name of one in config/sites
    #[arg(value_name = "SITE")]
    pub site: PathBuf,
    /// Drawing to write [default: target/rig/map/NAME.svg]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `rig devices`.
#[derive(Clone, Debug, Args)]
pub struct DevicesArgs {
    /// Robot file
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// Site file that says where the walls are
    #[arg(
        long,
        value_name = "FILE",
        default_value = "config/sites/corridor.toml"
    )]
    pub site: PathBuf,
    /// Where the bus is: a network interface, or udp:ADDRESS [default: what the robot file says]
    #[arg(long, value_name = "IFACE|udp:ADDR")]
    pub ethercat: Option<String>,
    /// Symbolic link to make to the lidar's terminal
    #[arg(long, value_name = "PATH")]
    pub lidar: Option<PathBuf>,
    /// Decides wheel errors and noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Runs the program with these arguments, the first being its name.
pub fn main_from(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors; the code follows.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(EXIT_REFUSED));
        }
    };
    let result = match cli.command {
        Command::Overtaking(arguments) => commands::shipped("overtaking", &arguments),
        Command::Docking(arguments) => commands::shipped("docking", &arguments),
        Command::TJunction(arguments) => commands::shipped("t-junction", &arguments),
        Command::Scenario(arguments) => commands::scenario(&arguments),
        Command::Campaign(arguments) => commands::many(&arguments),
        Command::Lap(arguments) => lap::lap(&arguments),
        Command::Course(arguments) => trials::course(&arguments),
        Command::Clutter(arguments) => trials::clutter(&arguments),
        Command::Map(arguments) => map::map(&arguments),
        Command::Devices(arguments) => devices::devices(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(),
    }
}
