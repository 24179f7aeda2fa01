//! The commands that run scenarios.

use std::path::{Path, PathBuf};

use crate::cli::{CampaignArgs, Failure, FleetArgs, ScenarioArgs};
use crate::one_robot::stage::end_flag;

/// Where the scenarios that ship are.
const SCENARIOS: &str = "config/scenarios";
/// Where scenarios leave what they leave, unless told otherwise.
const OUT: &str = "target/rig";

/// `rig overtaking` and the like: a scenario that ships.
///
/// # Errors
/// As [`scenario`].
pub fn shipped(name: &str, arguments: &FleetArgs) -> Result<(), Failure> {
    scenario(&ScenarioArgs {
        scenario: PathBuf::from(name),
        fleet: arguments.clone(),
    })
}

/// `rig scenario`: robots and a mediator do what a scenario file says.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when goals were not reached or something was violated.
pub fn scenario(arguments: &ScenarioArgs) -> Result<(), Failure> {
    let asked_to_end = end_flag()?;
    let own = &arguments.fleet;
    let mut scenario = crate::scenario::load(&scenario_file(&arguments.scenario))?;
    if let Some(rounds) = own.rounds {
        scenario = scenario.with_at_most(rounds);
    }
    let out = { own.out.clone() }.unwrap_or_else(|| Path::new(OUT).join(&scenario.name));
    let options = crate::run::run::Options {
        program: std::env::current_exe().map_err(Failure::refused)?,
        seed: own.seed,
        out,
        headless: own.headless,
        mediator: !own.without_mediator,
        nets: !own.without_nets,
    };
    crate::run::run::run(scenario, options, &asked_to_end)
}

/// `rig campaign`: a scenario many times.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when a run failed.
pub fn many(arguments: &CampaignArgs) -> Result<(), Failure> {
    let file = scenario_file(&arguments.scenario);
    let scenario = crate::scenario::load(&file)?;
    let out = { arguments.out.clone() }
        .unwrap_or_else(|| Path::new(OUT).join("campaign").join(&scenario.name));
    crate::campaign::processes::campaign(arguments, &scenario, &file, &out)
}

/// A scenario's file: the path itself, or the name of one that ships.
#[must_use]
pub fn scenario_file(scenario: &Path) -> PathBuf {
    let shipped = Path::new(SCENARIOS).join(scenario).with_extension("toml");
    let is_name = scenario.components().count() == 1 && scenario.extension().is_none();
    if is_name && !scenario.is_file() {
        shipped
    } else {
        scenario.to_owned()
    }
}
