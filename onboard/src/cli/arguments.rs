//! What the command line says, and the command that it names.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use super::check;
use super::doctor;
use super::teleop::{TeleopArgs, teleop};
use crate::composition::files::Files;
use crate::process::ctl::Request;
use crate::process::runtime::Runtime;
use crate::process::{ctl, inspect, run};

#[derive(Debug, Parser)]
#[command(
    name = "onboard",
    version,
    about = "Drives one robot: EtherCAT drive, lidar, navigation, fleet network"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Validate robot and site file and print the resolved plan, touching no device
    Check(Files),
    /// Look at this computer: what may stop the robot or make it late, and the commands that help; changes nothing
    Doctor {
        #[command(flatten)]
        files: Files,
        #[command(flatten)]
        runtime: RuntimeArgs,
        #[command(flatten)]
        state: StateArgs,
        /// Print JSON, one object a line
        #[arg(long)]
        json: bool,
    },
    /// Run the robot until SIGINT or SIGTERM
    Run {
        #[command(flatten)]
        files: Files,
        #[command(flatten)]
        runtime: RuntimeArgs,
        #[command(flatten)]
        state: StateArgs,
        /// Drive a real bus though real-time priority is not granted: the robot may stop at any moment because its threads are late
        #[arg(long)]
        without_real_time: bool,
    },
    /// List every symbol and thread of a running robot, or those of a name
    Inspect {
        /// Only what has this name: a datatype, a model, both (`load/robot`), or a thread
        name: Option<String>,
        /// Robot to look into; may be left out while only one runs
        #[arg(long)]
        robot: Option<String>,
        /// Print again every second until Ctrl-C
        #[arg(long)]
        watch: bool,
        /// Print JSON, one object a line
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        runtime: RuntimeArgs,
    },
    /// Drive a running robot by hand, while a dead-man is held
    Teleop(TeleopArgs),
    /// Talk to a running robot
    Ctl {
        /// What to ask of it
        #[command(subcommand)]
        request: Request,
        /// Robot to talk to; may be left out while only one runs
        #[arg(long, global = true)]
        robot: Option<String>,
        /// Folder for the names of running robots [default: $XDG_RUNTIME_DIR/onboard, or /tmp/onboard-UID]
        #[arg(
            long = "runtime",
            value_name = "DIR",
            env = "ONBOARD_RUNTIME_DIR",
            global = true
        )]
        folder: Option<PathBuf>,
    },
}

#[derive(Clone, Debug, Args)]
struct RuntimeArgs {
    /// Folder for the names of running robots [default: $XDG_RUNTIME_DIR/onboard, or /tmp/onboard-UID]
    #[arg(long = "runtime", value_name = "DIR", env = "ONBOARD_RUNTIME_DIR")]
    folder: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
struct StateArgs {
    /// Folder on disk, for what outlives the computer's being switched off [default: that of --runtime if given, else $XDG_STATE_HOME/onboard, or ~/.local/state/onboard]
    #[arg(long = "state", value_name = "DIR", env = "ONBOARD_STATE_DIR")]
    on_disk: Option<PathBuf>,
}

/// Runs the program with these arguments, the first being its name. Ends the process after `--help` and wrong usage.
pub fn main_from(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    contract::private::by_default();
    let result = match Cli::parse_from(arguments).command {
        Command::Check(files) => check::check(&files),
        Command::Run {
            files,
            runtime,
            state,
            without_real_time,
        } => Runtime::new(runtime.folder).and_then(|runtime| {
            let runtime = runtime.lasting_in(state.on_disk);
            run::run(&files, &runtime, without_real_time)
        }),
        Command::Doctor {
            files,
            runtime,
            state,
            json,
        } => Runtime::new(runtime.folder).and_then(|runtime| {
            let runtime = runtime.lasting_in(state.on_disk);
            doctor::doctor(&files, &runtime, json)
        }),
        Command::Inspect {
            name,
            robot,
            watch,
            json,
            runtime,
        } => Runtime::new(runtime.folder).and_then(|runtime| {
            let of = (robot.as_deref(), name.as_deref());
            inspect::inspect(&runtime, of, watch, json)
        }),
        Command::Teleop(arguments) => teleop(arguments),
        Command::Ctl {
            request,
            robot,
            folder,
        } => {
            Runtime::new(folder).and_then(|runtime| ctl::send(&runtime, robot.as_deref(), &request))
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_commands_of_the_package_are_commands_of_the_program() {
        let files = [
            include_str!("../../debian/onboard-doctor"),
            include_str!("../../debian/onboard.service"),
        ];
        for file in files {
            let (_, command) = file.split_once("/usr/bin/onboard ").expect("it has one");
            let command = command.lines().next().expect("a line");
            let words = { command.split_whitespace() }.filter(|word| *word != "\"$@\"");
            let parsed = Cli::try_parse_from(["onboard"].into_iter().chain(words));
            assert!(parsed.is_ok(), "{command}: {parsed:?}");
        }
    }
}
