//! Arguments of the commands that run one scenario.

use std::path::PathBuf;

use clap::Args;

use crate::commands::{Many, Request};
use crate::scenario::{Changes, LONGEST_DRIVEN_H};

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
pub(super) struct LapArgs {
    #[command(flatten)]
    driven: Driven,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    run: RunArgs,
}

/// Arguments of scenarios with a fleet.
#[derive(Clone, Debug, Args)]
pub(super) struct FleetArgs {
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
pub(super) struct ScenarioArgs {
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
pub(super) struct TrialArgs {
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    run: RunArgs,
}

/// Arguments of every scenario.
#[derive(Clone, Debug, Args)]
pub(super) struct RunArgs {
    /// Decides wheel errors, start offsets, starting times, noise, and what stands in the way
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    #[command(flatten)]
    pub(super) many: Many,
    /// Show nothing while it runs
    #[arg(long)]
    pub(super) headless: bool,
    /// Folder for summary.json, reports and logs [default: target/rig/SCENARIO, and there `stepped` on the simulated
    /// clock]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
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
    pub(super) fn request(self, scenario: PathBuf) -> Request {
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
    pub(super) fn request(self) -> Request {
        Request {
            changes: self.changes,
            laps: self.driven.laps,
            driven_h: self.driven.driven_h,
            ..self.run.request("lap".into())
        }
    }
}

impl FleetArgs {
    pub(super) fn request(self, scenario: PathBuf) -> Request {
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
    pub(super) fn request(self) -> Request {
        Request {
            changes: self.changes,
            laps: self.driven.laps,
            driven_h: self.driven.driven_h,
            ..self.fleet.request(self.scenario)
        }
    }
}

impl TrialArgs {
    pub(super) fn request(self, scenario: &str) -> Request {
        Request {
            changes: self.changes,
            ..self.run.request(scenario.into())
        }
    }
}
