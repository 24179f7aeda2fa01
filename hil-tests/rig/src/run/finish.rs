//! From the first step of a run to its end, and the files that it leaves.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use onboard::cli::Failure;

use super::ending::Ending;
use super::execution::Execution;
use super::hours::Hours;
use super::live::Live;
use super::printing::print;
use super::recording::record;
use super::watch::Run;
use crate::judge::{fences_not_grown, two_nets, two_owners};
use crate::network::observations::Observations;
use crate::output::{write, write_json};
use crate::process::log_tail;
use crate::record::Record;
use crate::report;
use crate::summary::Spoiled;
use crate::violation::ViolationKind;

/// Lines of a log that are shown when a run fails.
const LOG_LINES: usize = 12;

/// Steps and shows the run until it ends or is interrupted. A run of hours says how each was.
///
/// # Errors
/// [`Failure::Failed`] when a robot cannot be started.
pub fn look_on<E: Execution>(
    run: &mut Run<E>,
    headless: bool,
    asked_to_end: &AtomicBool,
) -> Result<Ending, Failure> {
    let (mut live, mut hours) = (Live::new(headless), Hours::default());
    let ending = loop {
        if let Some(ending) = run.step()? {
            break ending;
        }
        if let Some(hour) = hours.look(run) {
            live.end();
            onboard::say!("{hour}");
        }
        live.show(run);
        if asked_to_end.load(Ordering::Relaxed) {
            break Ending::Interrupted;
        }
    };
    live.end();
    Ok(ending)
}

impl<E: Execution> Run<E> {
    /// Ends robots, then the mediator, and judges how they ended and what their devices recorded.
    pub fn stop(&mut self) {
        let found = self.stage.stop();
        self.observe();
        let now_ns = self.stage.now_ns();
        for (kind, robot, detail) in found {
            self.judge.report(kind, &robot, now_ns, detail);
        }
        let (judge, scenario) = (&mut self.judge, &self.scenario);
        self.stage.heard(|observations| {
            let ownings = observations.ownings();
            let owners = two_owners(&scenario.site, ownings, now_ns);
            let fences = fences_not_grown(scenario, ownings);
            let nets = two_nets(scenario, observations.controlled());
            for (kind, found) in [
                (ViolationKind::TwoOwners, owners),
                (ViolationKind::FenceNotGrown, fences),
                (ViolationKind::TwoNets, nets),
            ] {
                for (robot, at_ns, detail) in found {
                    judge.report(kind, &robot, at_ns, detail);
                }
            }
        });
        // The listener hears one key prefix, which is this run's own: there is no stranger to blame.
        if let Some(malformed) = self.stage.heard(Observations::malformed) {
            let detail = format!("{} messages could not be decoded", malformed.count);
            let (kind, at_ns) = (ViolationKind::Malformed, malformed.first_ns);
            self.judge.report(kind, "network", at_ns, detail);
        }
    }
}

/// Stops everything, and writes summary and reports into the folder `out`.
///
/// # Errors
/// [`Failure::Failed`] when goals were not reached or something was violated.
pub fn finish<E: Execution>(mut run: Run<E>, out: &Path, ending: &Ending) -> Result<(), Failure> {
    verdict(&conclude(&mut run, out, ending, None)?, out, ending)
}

/// Stops everything, and writes summary and reports; `spoiled` is the run of which this one is the repetition.
pub(super) fn conclude<E: Execution>(
    run: &mut Run<E>,
    out: &Path,
    ending: &Ending,
    spoiled: Option<Spoiled>,
) -> Result<Record, Failure> {
    run.stop();
    let mut record = record(run, ending);
    record.summary.spoiled = spoiled;
    leave(out, &record)?;
    print(&record.summary, out);
    Ok(record)
}

/// Whether goals were reached and nothing was violated.
pub(super) fn verdict(record: &Record, out: &Path, ending: &Ending) -> Result<(), Failure> {
    if record.summary.passed() {
        return Ok(());
    }
    Err(Failure::failed(format_args!(
        "{}; {} violations{}",
        record.summary.outcome,
        record.summary.violations.len(),
        last_words(record, out, ending)
    )))
}

/// Writes summary and reports into a folder.
///
/// # Errors
/// [`Failure::Failed`] when they cannot be written.
pub fn leave(out: &Path, record: &Record) -> Result<(), Failure> {
    write_json(out, "summary.json", &record.summary)?;
    if let Some(svg) = report::drive_svg(record) {
        write(out, "report.svg", &svg)?;
    }
    write(out, "report.html", &report::html(record))?;
    Ok(())
}

/// The end of the log of whoever failed; a robot that was alone counts as the one that did.
fn last_words(record: &Record, out: &Path, ending: &Ending) -> String {
    let failed = match (ending, &record.robots[..]) {
        (Ending::RobotEnded(id, _), _) => id,
        (Ending::MediatorEnded(_), _) => "mediator",
        (_, [robot]) => &robot.id,
        _ => return String::new(),
    };
    match log_tail(&out.join(format!("{failed}.log")), LOG_LINES) {
        words if words.is_empty() => words,
        words => format!("; the last words of {failed}:\n{words}"),
    }
}
