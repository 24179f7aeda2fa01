//! What tests on the simulated clock have in common: one robot on its [devices](bench), whose faults a test injects, and whole scenarios.

pub mod bench;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use rig::run::{Ending, Run, look_on, record};
use rig::scenario::{Changes, Scenario, load};
use rig::stepped::{Plans, Stepped};
use rig::summary::Summary;

/// A file that ships, by its path below `config`.
pub fn shipped(file: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config")).join(file)
}

/// A scenario that ships.
pub fn scenario(name: &str) -> Scenario {
    let loaded = load(
        &shipped(&format!("scenarios/{name}.toml")),
        &Changes::default(),
    );
    loaded.unwrap_or_else(|failure| panic!("{failure:?}"))
}

pub fn plans(scenario: &Scenario) -> Plans {
    yield_to_programs();
    Plans::of(scenario).unwrap_or_else(|failure| panic!("{failure:?}"))
}

/// One run: how it ended, and its summary.
pub fn ended(scenario: &Scenario, plans: &Plans, seed: u64) -> (Ending, Summary) {
    let stepped = Stepped::new(scenario, plans, seed, true, false);
    let stepped = stepped.unwrap_or_else(|failure| panic!("{failure:?}"));
    let mut run = Run::new(scenario.clone(), stepped, seed);
    let ending = look_on(&mut run, true, &AtomicBool::new(false)).expect("it runs");
    run.stop();
    let summary = record(&run, &ending).summary;
    (ending, summary)
}

/// The same in JSON, to be compared.
pub fn json(summary: &Summary) -> serde_json::Value {
    serde_json::to_value(summary).expect("JSON")
}

/// A test that computes leaves the processor to those that wait for real programs. Of its own thread alone, which ends with it.
pub fn yield_to_programs() {
    let _ = rustix::process::setpriority_process(None, 10);
}
