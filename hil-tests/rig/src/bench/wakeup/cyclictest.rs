//! `cyclictest` of rt-tests, as a program of its own.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::time::Duration;

use onboard::cli::Failure;
use serde::Deserialize;

use crate::bench::cycle::Cycle;
use crate::bench::samples::Sample;
use crate::bench::windows::Contender;
use crate::folder::Folder;

const PROGRAM: &str = "cyclictest";
/// It counts wake-ups that are later than this, in µs, as such.
const LATEST_US: u64 = 50_000;

/// The program, one process for each window.
pub(super) struct Cyclictest(Cycle);

/// What it writes. Its page: cyclictest(8), `--json`.
#[derive(Deserialize)]
struct Written {
    thread: BTreeMap<String, Thread>,
}

#[derive(Deserialize)]
struct Thread {
    /// Wake-ups by how late they were, µs.
    histogram: BTreeMap<String, u64>,
    /// All wake-ups.
    cycles: u64,
    /// The latest, µs.
    max: u64,
}

impl Cyclictest {
    /// Looks for the program.
    ///
    /// # Errors
    /// What to install.
    pub(super) fn find(cycle: Cycle) -> Result<Self, String> {
        find(PROGRAM).map(|()| Self(cycle))
    }
}

fn find(program: &str) -> Result<(), String> {
    let mut command = Command::new(program);
    let found = command.arg("--help").stdin(Stdio::null()).output();
    found.map(drop).map_err(|error| {
        format!(
            "{program} is left out ({error}); Debian has it in the package rt-tests: \
             sudo apt install rt-tests"
        )
    })
}

impl Contender for Cyclictest {
    fn name(&self) -> String {
        PROGRAM.to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let (cycle, folder) = (self.0, Folder::new()?);
        let file = folder.path().join("cyclictest.json");
        let output = Command::new(PROGRAM)
            .args(["--quiet", "--mlockall", "--threads=1"])
            .arg(format!("--priority={}", cycle.place.priority.unwrap_or(0)))
            .arg(format!("--interval={}", cycle.period.as_micros()))
            .arg(format!("--affinity={}", cycle.place.core))
            // None would be for ever.
            .arg(format!("--loops={}", cycle.count(length).max(1)))
            .arg(format!("--histogram={LATEST_US}"))
            .arg(format!("--json={}", file.display()))
            .stdin(Stdio::null())
            .output()
            .map_err(Failure::failed)?;
        let text = std::fs::read_to_string(&file);
        let written = { text.ok() }.and_then(|text| serde_json::from_str::<Written>(&text).ok());
        let Some(thread) = written.and_then(|written| written.thread.into_values().next()) else {
            let said = String::from_utf8_lossy(&output.stderr);
            let said = said.lines().last().unwrap_or("it said nothing");
            return Err(Failure::failed(format_args!(
                "it left no result ({}): {said}",
                output.status
            )));
        };
        into.extend(thread.samples());
        Ok(())
    }
}

impl Thread {
    /// All wake-ups. Those that it does not count by µs were as late as the latest, as far as anybody knows.
    fn samples(&self) -> impl Iterator<Item = Sample> {
        let counted: u64 = self.histogram.values().sum();
        let later = (self.max, self.cycles.saturating_sub(counted));
        let all = { self.histogram.iter() }
            .filter_map(|(late_us, count)| Some((late_us.parse().ok()?, *count)))
            .chain([later]);
        all.flat_map(|(late_us, count): (u64, u64)| {
            (0..count).map(move |_| Sample::counted_in_us(late_us.saturating_mul(1_000)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::place::{Place, last_core};

    #[test]
    fn a_result_is_read_with_what_was_later_than_it_counts() {
        let text = r#"{ "file_version": 1, "thread": { "0": {
            "histogram": { "7": 3, "12": 2 }, "cycles": 6, "min": 7, "max": 61000, "avg": 12.0, "cpu": 1, "node": 0 } } }"#;
        let written = serde_json::from_str::<Written>(text).expect("a result");
        let late_us: Vec<f64> = { written.thread["0"].samples() }
            .map(|sample| sample.value / 1e3)
            .collect();
        assert_eq!(late_us, [12.0, 12.0, 7.0, 7.0, 7.0, 61_000.0]);
    }

    #[test]
    fn a_program_that_is_missing_is_named_with_its_package() {
        let why = find("no-such-cyclictest").expect_err("nobody has it");
        assert!(why.contains("no-such-cyclictest is left out"), "{why}");
        assert!(why.contains("sudo apt install rt-tests"), "{why}");
    }

    #[test]
    fn where_it_is_installed_and_may_run_it_measures_each_wake_up() {
        let (place, without) = Place::wanted(10, last_core());
        let period = Duration::from_millis(1);
        let mut rival = match Cyclictest::find(Cycle { period, place }) {
            Ok(rival) => rival,
            Err(why) => return eprintln!("SKIPPED: {why}"),
        };
        let mut samples = Vec::new();
        match rival.window(20 * period, &mut samples) {
            Ok(()) => assert_eq!(samples.len(), 20),
            Err(failure) => assert!(without.is_some(), "{failure:?}"),
        }
    }
}
