//! The command line.

pub mod check;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use config::Override;

use crate::process::ctl::Request;
use crate::process::runtime::Runtime;
use crate::process::{ctl, inspect, run};

/// Exit code for a mistake in files, arguments or names: nothing was started.
pub const EXIT_REFUSED: u8 = 2;
/// Exit code for a failure while running.
pub const EXIT_FAILED: u8 = 1;

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
    /// Run the robot until SIGINT or SIGTERM
    Run {
        #[command(flatten)]
        files: Files,
        #[command(flatten)]
        runtime: RuntimeArgs,
    },
    /// List every symbol and thread of a running robot
    Inspect {
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
    /// Talk to a running robot
    Ctl {
        /// What it is to do
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

/// The files of a robot and what the command line changes in them.
#[derive(Clone, Debug, Args)]
pub struct Files {
    /// Robot file, such as config/robots/amr-1.toml
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// Site file, such as config/sites/corridor.toml
    #[arg(long, value_name = "FILE")]
    pub site: PathBuf,
    /// Change one value of either file, such as drive.max_speed_m_s=0.3
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

#[derive(Clone, Debug, Args)]
struct RuntimeArgs {
    /// Folder for the names of running robots [default: $XDG_RUNTIME_DIR/onboard, or /tmp/onboard-UID]
    #[arg(long = "runtime", value_name = "DIR", env = "ONBOARD_RUNTIME_DIR")]
    folder: Option<PathBuf>,
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
        Command::Check(files) => check::check(&files),
        Command::Run { files, runtime } => {
            Runtime::new(runtime.folder).and_then(|runtime| run::run(&files, &runtime))
        }
        Command::Inspect {
            robot,
            watch,
            json,
            runtime,
        } => Runtime::new(runtime.folder)
            .and_then(|runtime| inspect::inspect(&runtime, robot.as_deref(), watch, json)),
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

/// Why the program ends with an error.
#[derive(Debug)]
pub enum Failure {
    /// Nothing was started: files, arguments or names are wrong.
    Refused(miette::Report),
    /// It failed while running.
    Failed(miette::Report),
}

impl Failure {
    /// A refusal with one sentence.
    pub fn refused(sentence: impl std::fmt::Display) -> Self {
        Self::Refused(miette::miette!("{sentence}"))
    }

    /// A failure with one sentence.
    pub fn failed(sentence: impl std::fmt::Display) -> Self {
        Self::Failed(miette::miette!("{sentence}"))
    }

    /// Prints it and gives the exit code that goes with it.
    #[must_use]
    pub fn print(self) -> ExitCode {
        let (code, report) = match self {
            Self::Refused(report) => (EXIT_REFUSED, report),
            Self::Failed(report) => (EXIT_FAILED, report),
        };
        eprintln!("{report:?}");
        ExitCode::from(code)
    }
}

/// The `--set` arguments, parsed.
///
/// # Errors
/// [`Failure::Refused`] naming the argument.
pub fn overrides(set: &[String]) -> Result<Vec<Override>, Failure> {
    set.iter()
        .map(|text| {
            Override::parse(text).map_err(|error| Failure::Refused(miette::Report::new(error)))
        })
        .collect()
}
