//! `runs.jsonl`: finished runs of a stepped campaign, so that one that was interrupted goes on where it was.
//!
//! The first line says what decides a run; a run of the same seed would be the same again. Each other line is a finished run,
//! written at once: whatever ends the program, at most a line that was being written is lost.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use onboard::cli::Failure;
use serde::{Deserialize, Serialize};

use crate::output::make_folder;
use crate::summary::Summary;

/// Name of the file.
const FILE: &str = "runs.jsonl";

/// What decides the run of a seed: the file's first line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// Name of the scenario.
    pub scenario: String,
    /// Fingerprint of all that the scenario's files and the changes to them say.
    pub files: String,
    /// What goes wrong besides what the scenario says: `none`, `drawn` from the seed, or a case.
    pub faults: String,
    /// A mediator runs where the site asks for one.
    pub mediator: bool,
    /// The site's coordinations are as they are.
    pub nets: bool,
    /// Version and build of the program.
    pub program: String,
}

/// A finished run.
#[derive(Debug, Serialize, Deserialize)]
struct Line {
    /// Since the run before it was finished, or the session had begun.
    elapsed_s: f64,
    run: Summary,
}

/// The file, under way.
#[derive(Debug)]
pub struct Ledger {
    path: PathBuf,
    open: Mutex<Open>,
    /// Runs that were there before, and whether they passed.
    before: BTreeMap<u64, bool>,
    /// Why what was there before does not count.
    starts_over: Option<String>,
}

#[derive(Debug)]
struct Open {
    file: File,
    /// When the last run was finished.
    last: Instant,
}

impl Ledger {
    /// Opens the file in a folder for a campaign. What is there counts if its first line is this one, unless all runs are to
    /// be made `fresh`.
    ///
    /// # Errors
    /// [`Failure::Refused`] when the file cannot be used, or another campaign is writing it.
    pub fn open(out: &Path, head: &Head, fresh: bool) -> Result<Self, Failure> {
        make_folder(out)?;
        let path = out.join(FILE);
        let refused = |why: String| Failure::refused(format_args!("{}: {why}", path.display()));
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options
            .open(&path)
            .map_err(|error| refused(error.to_string()))?;
        // A file system without locks is no reason not to run.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(refused("another campaign is writing it".to_owned()));
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)
            .map_err(|error| refused(error.to_string()))?;
        let (found, lines, good) = parse(&bytes);
        let starts_over = match found {
            _ if bytes.is_empty() => None,
            _ if fresh => Some("as --fresh says".to_owned()),
            None => Some("what is there is not the record of a campaign".to_owned()),
            Some(found) => head.differs_from(&found),
        };
        let counts = !bytes.is_empty() && starts_over.is_none();
        let keep = if counts { good as u64 } else { 0 };
        { file.set_len(keep) }
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .map_err(|error| refused(error.to_string()))?;
        if !counts {
            write_line(&mut file, head).map_err(refused)?;
        }
        let before = { lines.iter().filter(|_| counts) }
            .map(|line| (line.run.seed, line.run.passed()))
            .collect();
        let last = Instant::now();
        Ok(Self {
            open: Mutex::new(Open { file, last }),
            path,
            before,
            starts_over,
        })
    }

    /// Why what was there before does not count; none: it does, or nothing was there.
    #[must_use]
    pub fn starts_over(&self) -> Option<&str> {
        self.starts_over.as_deref()
    }

    /// Whether the run of this seed was made before, and passed.
    #[must_use]
    pub fn passed_before(&self, seed: u64) -> Option<bool> {
        self.before.get(&seed).copied()
    }

    /// Writes down a finished run, without areas and coordinations.
    ///
    /// # Errors
    /// [`Failure::Failed`] when it cannot be written.
    pub fn add(&self, mut run: Summary) -> Result<(), Failure> {
        run.areas.clear();
        run.coordinations.clear();
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let elapsed_s = now.duration_since(open.last).as_secs_f64();
        open.last = now;
        let failed = |why| Failure::failed(format_args!("{}: {why}", self.path.display()));
        write_line(&mut open.file, &Line { elapsed_s, run }).map_err(failed)
    }

    /// The runs of these seeds, in their order, and how long they took.
    ///
    /// # Errors
    /// [`Failure::Failed`] when the file cannot be read.
    pub fn runs(&self, seeds: &Range<u64>) -> Result<(Vec<Summary>, f64), Failure> {
        let bytes = std::fs::read(&self.path).map_err(Failure::failed)?;
        let lines = { parse(&bytes).1.into_iter() }.map(|line| (line.run.seed, line));
        let lines: BTreeMap<u64, Line> = lines.collect();
        let lines: Vec<Line> = { lines.into_iter() }
            .filter_map(|(seed, line)| seeds.contains(&seed).then_some(line))
            .collect();
        let elapsed_s = lines.iter().map(|line| line.elapsed_s).sum();
        Ok((lines.into_iter().map(|line| line.run).collect(), elapsed_s))
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        // Not by closing alone: a program that another thread is starting has the file, and with it the lock, for an instant more.
        let _ = self.file.unlock();
    }
}

impl Head {
    /// Why the runs of another head do not count; none: they do.
    fn differs_from(&self, other: &Self) -> Option<String> {
        let differences = [
            ("the scenario", self.scenario != other.scenario),
            ("its files or settings", self.files != other.files),
            ("--faults", self.faults != other.faults),
            ("the mediator", self.mediator != other.mediator),
            ("the nets", self.nets != other.nets),
            ("the build of this program", self.program != other.program),
        ];
        let different: Vec<&str> = { differences.iter() }
            .filter_map(|(what, differs)| differs.then_some(*what))
            .collect();
        (!different.is_empty()).then(|| format!("different now: {}", different.join(", ")))
    }
}

/// Head and runs up to the first line that is not whole, and how many bytes these are.
fn parse(bytes: &[u8]) -> (Option<Head>, Vec<Line>, usize) {
    let mut whole =
        { bytes.split_inclusive(|byte| *byte == b'\n') }.take_while(|line| line.ends_with(b"\n"));
    let first = whole.next().unwrap_or_default();
    let Ok(head) = serde_json::from_slice(first) else {
        return (None, Vec::new(), 0);
    };
    let (mut lines, mut good) = (Vec::new(), first.len());
    for text in whole {
        let Ok(line) = serde_json::from_slice(text) else {
            break;
        };
        lines.push(line);
        good += text.len();
    }
    (Some(head), lines, good)
}

/// A line at once: a kill between two writes would leave half of one.
fn write_line(file: &mut File, value: &impl Serialize) -> Result<(), String> {
    let mut line = serde_json::to_string(value).map_err(|error| error.to_string())?;
    line.push('\n');
    file.write_all(line.as_bytes())
        .map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;
    use crate::summary::{AreaSummary, DONE, RobotSummary};

    fn head() -> Head {
        Head {
            scenario: "overtaking".to_owned(),
            files: "1".to_owned(),
            faults: "none".into(),
            mediator: true,
            nets: true,
            program: "0".to_owned(),
        }
    }

    fn run(seed: u64) -> Summary {
        Summary {
            scenario: "overtaking".to_owned(),
            outcome: DONE.to_owned(),
            seed,
            robots: vec![RobotSummary {
                min_clearance_m: f64::INFINITY,
                ..RobotSummary::default()
            }],
            areas: vec![AreaSummary {
                id: "1".to_owned(),
                capacity: 1,
                owners: Vec::new(),
                longest_wait_s: 0.0,
            }],
            ..Summary::default()
        }
    }

    fn open(folder: &Folder, head: &Head, fresh: bool) -> Ledger {
        let ledger = Ledger::open(folder.path(), head, fresh);
        ledger.unwrap_or_else(|failure| panic!("{failure:?}"))
    }

    fn add(ledger: &Ledger, seed: u64) {
        ledger.add(run(seed)).expect("written");
    }

    /// Seeds from 1 to 9 that are known from before.
    fn known(ledger: &Ledger) -> Vec<u64> {
        let seeds = (1..10).filter(|seed| ledger.passed_before(*seed).is_some());
        seeds.collect()
    }

    fn change(folder: &Folder, how: impl FnOnce(&mut Vec<u8>)) {
        let path = folder.path().join(FILE);
        let mut bytes = std::fs::read(&path).expect("there");
        how(&mut bytes);
        std::fs::write(&path, bytes).expect("written");
    }

    #[test]
    fn what_was_finished_is_there_the_next_time() {
        let folder = Folder::new().expect("a folder");
        let first = open(&folder, &head(), false);
        assert_eq!((known(&first), first.starts_over()), (vec![], None));
        add(&first, 3);
        let mut failed = run(1);
        failed.outcome = "interrupted".to_owned();
        first.add(failed).expect("written");
        assert!(Ledger::open(folder.path(), &head(), false).is_err(), "busy");
        drop(first);
        let second = open(&folder, &head(), false);
        assert_eq!((known(&second), second.starts_over()), (vec![1, 3], None));
        let passed = [1, 3].map(|seed| second.passed_before(seed));
        assert_eq!(passed, [Some(false), Some(true)]);
        add(&second, 2);
        let (runs, elapsed_s) = second.runs(&(1..3)).expect("read");
        let seeds: Vec<u64> = runs.iter().map(|run| run.seed).collect();
        assert_eq!(seeds, [1, 2], "in order, and only those");
        assert!(elapsed_s > 0.0 && runs[0].areas.is_empty());
        assert_eq!(runs[0].robots[0].min_clearance_m, f64::INFINITY);
    }

    #[test]
    fn half_a_line_is_dropped() {
        let folder = Folder::new().expect("a folder");
        let first = open(&folder, &head(), false);
        add(&first, 1);
        add(&first, 2);
        drop(first);
        change(&folder, |bytes| bytes.truncate(bytes.len() - 20));
        let second = open(&folder, &head(), false);
        assert_eq!((known(&second), second.starts_over()), (vec![1], None));
        add(&second, 4);
        drop(second);
        // Whole, but not a run: nothing behind it counts.
        change(&folder, |bytes| bytes.extend(b"{}\n\xff\n"));
        let third = open(&folder, &head(), false);
        assert_eq!(known(&third), [1, 4]);
        add(&third, 5);
        assert_eq!(third.runs(&(1..10)).expect("read").0.len(), 3);
    }

    #[test]
    fn another_campaign_starts_over_and_says_why() {
        let folder = Folder::new().expect("a folder");
        add(&open(&folder, &head(), false), 1);
        let mut other = head();
        (other.faults, other.program) = ("drawn".to_owned(), "1".to_owned());
        let second = open(&folder, &other, false);
        assert_eq!(
            (known(&second), second.starts_over()),
            (
                vec![],
                Some("different now: --faults, the build of this program")
            )
        );
        add(&second, 2);
        drop(second);
        assert_eq!(known(&open(&folder, &other, false)), [2]);
        let third = open(&folder, &other, true);
        assert_eq!(third.starts_over(), Some("as --fresh says"));
        drop(third);
        assert_eq!(known(&open(&folder, &other, false)), [] as [u64; 0]);
        // Killed while the first line was written, or no record at all.
        change(&folder, |bytes| bytes.truncate(9));
        let fourth = open(&folder, &other, false);
        assert!(known(&fourth).is_empty() && fourth.starts_over().is_some());
    }
}
