//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use onboard::cli::EXIT_REFUSED;
pub use onboard::cli::Failure;

use crate::{devices, lap};

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
    /// One robot drives laps of a corridor
    Lap(LapArgs),
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
        Command::Lap(arguments) => lap::lap(&arguments),
        Command::Devices(arguments) => devices::devices(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(),
    }
}
