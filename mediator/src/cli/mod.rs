//! The command line.

mod check;
mod run;
mod status;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use config::SiteConfig;

use crate::runtime::{Folder, Question};

/// Exit code for a mistake in files, arguments or names: nothing was started.
pub const EXIT_REFUSED: u8 = 2;
/// Exit code for a failure while running.
pub const EXIT_FAILED: u8 = 1;

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
    /// Validate a site file and its nets, and print what the mediator would do
    Check {
        /// Site file, such as config/sites/corridor.toml
        #[arg(long, value_name = "FILE")]
        site: PathBuf,
    },
    /// Print a net of the site as a DOT graph
    Show {
        /// Site file
        #[arg(long, value_name = "FILE")]
        site: PathBuf,
        /// Name of the net
        #[arg(long, value_name = "NAME")]
        net: String,
        /// Mark it as it begins in this situation; by default in the first
        #[arg(long, value_name = "NAME")]
        situation: Option<String>,
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
    /// Say what a robot waits for, who has it, and since when
    Why {
        /// Id of the robot
        robot: String,
        #[command(flatten)]
        which: Which,
    },
    /// Say that no silent robot is in an area: whoever was is taken out of it
    Clear {
        /// Id of the area
        area: String,
        #[command(flatten)]
        which: Which,
    },
}

/// Which running mediator.
#[derive(Debug, Args)]
struct Which {
    /// Name of the site; may be left out while only one mediator runs
    #[arg(long, value_name = "NAME")]
    site: Option<String>,
    /// Folder for the sockets of running mediators [default: $XDG_RUNTIME_DIR/mediator, or /tmp/mediator-UID]
    #[arg(long, value_name = "DIR", env = "MEDIATOR_RUNTIME_DIR")]
    runtime: Option<PathBuf>,
}

/// Why a command did not do what it should.
#[derive(Debug)]
enum Failure {
    /// A mistake in files, arguments or names.
    Refused(String),
    /// It was right, and did not work.
    Failed(String),
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
        Command::Check { site } => check::check(&site),
        Command::Show {
            site,
            net,
            situation,
        } => check::show(&site, &net, situation.as_deref()),
        Command::Run(arguments) => run::run(arguments),
        Command::Status { which, json } => status::status(&which, json),
        Command::Why { robot, which } => status::order(&which, &Question::Why { robot }),
        Command::Clear { area, which } => status::order(&which, &Question::Clear { area }),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Refused(text)) => {
            eprintln!("{text}");
            ExitCode::from(EXIT_REFUSED)
        }
        Err(Failure::Failed(text)) => {
            eprintln!("mediator: {text}");
            ExitCode::from(EXIT_FAILED)
        }
    }
}

/// Reads a site file; every problem in it is named.
fn load_site(path: &Path) -> Result<SiteConfig, Failure> {
    config::load_site(path, &[])
        .map_err(|error| Failure::Refused(format!("{:?}", miette::Report::new(error))))
}

impl Which {
    /// The socket of the mediator that is meant.
    fn socket(&self) -> Result<PathBuf, Failure> {
        let site = match &self.site {
            Some(site) => site.clone(),
            None => {
                let running = Folder::sites(self.runtime.clone()).map_err(Failure::Refused)?;
                match running.as_slice() {
                    [only] => only.clone(),
                    [] => return Err(Failure::Refused("no mediator runs here".to_owned())),
                    several => {
                        return Err(Failure::Refused(format!(
                            "several mediators run: {}; name one with --site",
                            several.join(", ")
                        )));
                    }
                }
            }
        };
        let folder = Folder::new(self.runtime.clone(), &site).map_err(Failure::Refused)?;
        Ok(folder.socket())
    }
}
