//! The commands and their arguments.

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use super::failure::{EXIT_FAILED, EXIT_REFUSED, EXIT_UNDECIDED, Failure};
use super::which::Which;
use super::{check, keys, run, status};
use crate::runtime::Question;

#[derive(Debug, Parser)]
#[command(
    name = "mediator",
    version,
    about = "Decides which robot of a fleet may be in which area of a site, and coordinates them with Petri nets"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Validate a site file and its nets, and print what the mediator would do (exit code 2: refused, 3: not decided)
    Check {
        /// Site file, such as config/sites/corridor.toml
        #[arg(long, value_name = "FILE")]
        site: PathBuf,
    },
    /// Print a net of the site, as a DOT graph
    Show {
        /// Site file
        #[arg(long, value_name = "FILE")]
        site: PathBuf,
        /// Name of the net
        #[arg(long, value_name = "NAME")]
        net: String,
        /// Marking at the start of this situation [default: the first one]
        #[arg(long, value_name = "NAME")]
        situation: Option<String>,
        /// As PNML instead (ISO/IEC 15909-2), for the Petri net tools of others
        #[arg(long)]
        pnml: bool,
    },
    /// Make and revoke the certificates of a site's mediator, robots and operators
    Keys {
        #[command(subcommand)]
        command: keys::Command,
    },
    /// Run until SIGINT or SIGTERM
    Run(run::Arguments),
    /// List areas with their owners, waiting robots, and running nets of a running mediator
    Status {
        #[command(flatten)]
        which: Which,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Say what a robot waits for, who has that, and since when
    Why {
        /// Id of the robot
        robot: String,
        #[command(flatten)]
        which: Which,
    },
    /// Tell the mediator that no silent robot is in an area: whoever was there loses it
    Clear {
        /// Id of the area
        area: String,
        /// The silent robot that stands in it, for all that is known, was taken away
        #[arg(long)]
        taken_away: bool,
        #[command(flatten)]
        which: Which,
    },
    /// Let nobody into an area any more, until it is opened again: those in it may leave
    Close {
        /// Id of the area
        area: String,
        /// Why, for people
        #[arg(long, value_name = "TEXT", default_value = "")]
        because: String,
        #[command(flatten)]
        which: Which,
    },
    /// Let robots into a closed area again
    Open {
        /// Id of the area
        area: String,
        #[command(flatten)]
        which: Which,
    },
    /// End a coordination: its robots get out of the way where the site says how, and are let go the second time
    End {
        /// Its id, its number, or both as in `overtaking/3`
        coordination: String,
        #[command(flatten)]
        which: Which,
    },
    /// Tell the mediator that a silent robot is nowhere on the floor: it loses all areas, and nobody waits for it
    Absent {
        /// Id of the robot
        robot: String,
        /// It was taken away, though it stands in an area, for all that is known
        #[arg(long)]
        taken_away: bool,
        #[command(flatten)]
        which: Which,
    },
    /// List what operators have ordered: when, who, and what became of it
    Orders {
        #[command(flatten)]
        which: Which,
    },
}

/// Runs the program with these arguments, the first being its name. Ends the process after `--help` and wrong usage.
pub fn main_from(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let result = match Cli::parse_from(arguments).command {
        Command::Check { site } => check::check(&site),
        Command::Show {
            site,
            net,
            situation,
            pnml,
        } => check::show(&site, &net, situation.as_deref(), pnml),
        Command::Keys { command } => keys::run(command),
        Command::Run(arguments) => run::run(arguments),
        Command::Status { which, json } => status::status(&which, json),
        Command::Why { robot, which } => status::order(&which, &Question::Why { robot }),
        Command::Clear {
            area,
            taken_away,
            which,
        } => status::order(&which, &Question::Clear { area, taken_away }),
        Command::Close {
            area,
            because: why,
            which,
        } => status::order(&which, &Question::Close { area, why }),
        Command::Open { area, which } => status::order(&which, &Question::Open { area }),
        Command::End {
            coordination,
            which,
        } => status::order(&which, &Question::End { coordination }),
        Command::Absent {
            robot,
            taken_away,
            which,
        } => status::order(&which, &Question::Absent { robot, taken_away }),
        Command::Orders { which } => status::orders(&which),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Refused(text)) => {
            let _ = writeln!(std::io::stderr(), "{text}");
            ExitCode::from(EXIT_REFUSED)
        }
        Err(Failure::Failed(text)) => {
            let _ = writeln!(std::io::stderr(), "mediator: {text}");
            ExitCode::from(EXIT_FAILED)
        }
        Err(Failure::Undecided(text)) => {
            let _ = writeln!(std::io::stderr(), "{text}");
            ExitCode::from(EXIT_UNDECIDED)
        }
    }
}
