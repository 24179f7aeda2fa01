//! Tests on the simulated clock: figures are judged here, where no load of the machine spoils them.
//!
//! - [`bench`] is one robot on its devices, whose faults a test injects: [`bus`], [`drive`], [`lidar`], [`obstacle`], and
//!   [`straying`] from the lane; [`hung`] are threads of its own that hang, [`panics`] those that panic; [`ending`] is a process that is told to end; [`placing`] is an operator's word for where it stands,
//!   [`resets`] what is answered to a reset, [`teleop`] a person who drives it by hand;
//! - [`trials`] are whole scenarios of one robot, [`fleets`] those with a mediator; [`faults`] are those of a scenario,
//!   [`found`] what campaigns have found, [`controls`] what the judge must find, [`docked`] robots that start again in the dock, [`scripted`] what is never drawn.

mod bench;
mod bus;
mod controls;
mod docked;
mod drive;
mod ending;
mod faults;
mod fleets;
mod found;
mod hung;
mod lidar;
mod obstacle;
mod panics;
mod placing;
mod resets;
mod scripted;
mod sleep;
mod straying;
mod teleop;
mod trials;
mod wheels;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use rig::run::{Ending, Run, look_on, record};
use rig::scenario::{Changes, Scenario, load};
use rig::stepped::{Plans, Stepped};
use rig::summary::Summary;

/// A file that ships, by its path below `config`.
fn shipped(file: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config")).join(file)
}

/// A scenario that ships.
fn scenario(name: &str) -> Scenario {
    let loaded = load(
        &shipped(&format!("scenarios/{name}.toml")),
        &Changes::default(),
    );
    loaded.unwrap_or_else(|failure| panic!("{failure:?}"))
}

fn plans(scenario: &Scenario) -> Plans {
    Plans::of(scenario).unwrap_or_else(|failure| panic!("{failure:?}"))
}

/// One run: how it ended, and its summary.
fn ended(scenario: &Scenario, plans: &Plans, seed: u64) -> (Ending, Summary) {
    let stepped = Stepped::new(scenario, plans, seed, true, false);
    let stepped = stepped.unwrap_or_else(|failure| panic!("{failure:?}"));
    let mut run = Run::new(scenario.clone(), stepped, seed);
    let ending = look_on(&mut run, true, &AtomicBool::new(false)).expect("it runs");
    run.stop();
    let summary = record(&run, &ending).summary;
    (ending, summary)
}

/// The same in JSON, to be compared.
fn json(summary: &Summary) -> serde_json::Value {
    serde_json::to_value(summary).expect("JSON")
}
