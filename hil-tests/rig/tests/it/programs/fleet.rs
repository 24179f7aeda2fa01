//! One run of a scenario that ships, step by step.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use onboard::cli::Failure;
use rig::run::stage::Stage;
use rig::run::{Ending, Options};
use rig::scenario::{self, Changes, Scenario};
use tempfile::TempDir;

use crate::programs::late;
use crate::programs::turn::Turn;

/// The program under test.
pub const RIG: &str = env!("CARGO_BIN_EXE_rig");
/// The user's files that ship.
pub const CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");

/// Overtaking as it ships, but shorter: the slower robot is a little faster, and both are done soon after the net has ended.
pub fn overtaking() -> Scenario {
    let shipped = Path::new(CONFIG).join("scenarios/overtaking.toml");
    let mut text = std::fs::read_to_string(shipped).expect("a scenario");
    for (from, to) in [
        ("\"../", &*format!("\"{CONFIG}/")),
        ("max_speed_m_s=0.20", "max_speed_m_s=0.25"),
        ("    { area = \"3\" },\n] }", "] }"),
        ("    { area = \"4\" },\n] }", "] }"),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("overtaking.toml");
    std::fs::write(&file, text).expect("written");
    scenario::load(&file, &Changes::default()).unwrap_or_else(|failure| panic!("{failure:?}"))
}

/// A run through the real programs.
pub type Run = rig::run::Run<Stage>;

/// A run under way, and where it leaves what it leaves.
pub struct Bench {
    /// The run.
    pub run: Run,
    folder: TempDir,
    _turn: Turn,
}

impl Bench {
    /// Sets the stage.
    pub fn start(scenario: Scenario) -> Self {
        Self::start_with(scenario, false)
    }

    /// Sets the stage, with certificates on every link.
    pub fn start_secured(scenario: Scenario) -> Self {
        Self::start_with(scenario, true)
    }

    fn start_with(scenario: Scenario, secure: bool) -> Self {
        let turn = Turn::of_robots_for_long(scenario.robots.len());
        let folder = tempfile::tempdir().expect("a temporary folder");
        let options = Options {
            program: PathBuf::from(RIG),
            onboard: None,
            seed: 3,
            out: folder.path().join("out"),
            headless: true,
            mediator: true,
            nets: true,
            secure,
        };
        let run = Run::start(scenario, &options).unwrap_or_else(|failure| panic!("{failure:?}"));
        Self {
            run,
            folder,
            _turn: turn,
        }
    }

    /// Looks on until this holds; the run must not end before.
    pub fn until(&mut self, what: &str, patience: Duration, mut holds: impl FnMut(&Run) -> bool) {
        let began = Instant::now();
        while !holds(&self.run) {
            assert!(began.elapsed() < patience, "{what}\n{}", self.logs());
            if let Some(ending) = self.look() {
                panic!("{what}, and it ended: {ending:?}\n{}", self.logs());
            }
        }
    }

    /// Looks on for a time, throughout which this must hold.
    pub fn holds_for(&mut self, what: &str, time: Duration, mut holds: impl FnMut(&Run) -> bool) {
        let began = Instant::now();
        while began.elapsed() < time {
            assert!(holds(&self.run), "{what}\n{}", self.logs());
            if let Some(ending) = self.look() {
                panic!("{what}, and it ended: {ending:?}\n{}", self.logs());
            }
        }
    }

    /// Looks on until the run ends.
    pub fn until_end(&mut self) -> Ending {
        self.until_end_with(|_| ())
    }

    /// Looks on until the run ends, and does this each time.
    pub fn until_end_with(&mut self, mut act: impl FnMut(&Run)) -> Ending {
        loop {
            act(&self.run);
            if let Some(ending) = self.look() {
                return ending;
            }
        }
    }

    fn look(&mut self) -> Option<Ending> {
        let looked = self.run.step();
        late::note_kinds(self.run.judge.violations().iter().map(|own| own.kind));
        looked.unwrap_or_else(|failure| panic!("{failure:?}"))
    }

    /// Stops everything. Returns what it came to, the summary, and the report.
    pub fn finish(self, ending: &Ending) -> (Result<(), Failure>, serde_json::Value, String) {
        let out = self.folder.path().join("out");
        // Seen if the test fails.
        println!("{}", self.logs());
        let result = rig::run::finish(self.run, &out, ending);
        let text = |name: &str| std::fs::read_to_string(out.join(name)).expect(name);
        let summary = serde_json::from_str(&text("summary.json")).expect("JSON");
        late::note_violations(&summary);
        (result, summary, text("report.html"))
    }

    fn logs(&self) -> String {
        let out = self.folder.path().join("out");
        let logs = { std::fs::read_dir(out).into_iter() }.flatten().flatten();
        logs.map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|own| own == "log"))
            .map(|path| {
                format!(
                    "{}:\n{}\n",
                    path.display(),
                    rig::process::log_tail(&path, 40)
                )
            })
            .collect()
    }
}

/// Whether a robot has an area, as the listener heard.
pub fn has(run: &Run, robot: &str, area: &str) -> bool {
    let observations = run.stage.listener.observations();
    observations
        .ownings()
        .iter()
        .any(|own| own.robot == robot && own.area == area && own.released_ns.is_none())
}

/// Whether a robot waits for an area, as the listener heard.
pub fn waits(run: &Run, robot: &str, area: &str) -> bool {
    let observations = run.stage.listener.observations();
    observations
        .waitings()
        .iter()
        .any(|own| own.robot == robot && own.area == area && own.to_ns.is_none())
}
