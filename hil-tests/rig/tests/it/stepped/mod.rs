//! What tests on the simulated clock have in common: one robot on its [devices](bench), whose faults a test injects, and whole scenarios.

pub mod bench;
#[path = "../../../../../mediator/tests/it/model/cores.rs"]
mod cores;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use rig::record::Record;
use rig::run::{Ending, Execution, Run, record};
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
    let (ending, record) = watched(scenario, scenario, plans, seed, f64::INFINITY);
    (ending, record.summary)
}

/// A run of what is `driven`, which the judge of another scenario looks at, to its end, or to this time.
pub fn watched(
    told: &Scenario,
    driven: &Scenario,
    plans: &Plans,
    seed: u64,
    to_s: f64,
) -> (Ending, Record) {
    let _core = cores::Core::wait();
    let stepped = Stepped::new(driven, plans, seed, true, false);
    let stepped = stepped.unwrap_or_else(|failure| panic!("{failure:?}"));
    let mut run = Run::new(told.clone(), stepped, seed);
    let ending = loop {
        if let Some(ending) = run.step().expect("it runs") {
            break ending;
        }
        if run.stage.seconds(run.stage.now_ns()) >= to_s {
            break Ending::Interrupted;
        }
    };
    run.stop();
    let record = record(&run, &ending);
    (ending, record)
}

/// The run of a scenario without faults, made once for all tests that compare with it.
pub fn without_faults(scenario: &Scenario, seed: u64) -> Summary {
    type Runs = BTreeMap<(String, u64), Arc<OnceLock<Summary>>>;
    static RUNS: Mutex<Runs> = Mutex::new(Runs::new());
    assert_eq!(scenario.faults, []);
    // All that decides a run.
    let key = (format!("{scenario:?}"), seed);
    let run = Arc::clone(
        RUNS.lock()
            .expect("no test holds it")
            .entry(key)
            .or_default(),
    );
    let run = run.get_or_init(|| ended(scenario, &plans(scenario), seed).1);
    run.clone()
}

/// The same in JSON, to be compared.
pub fn json(summary: &Summary) -> serde_json::Value {
    serde_json::to_value(summary).expect("JSON")
}

/// A test that computes leaves the processor to those that wait for real programs. Of its own thread alone, which ends with it.
pub fn yield_to_programs() {
    let _ = rustix::process::setpriority_process(None, 10);
}
