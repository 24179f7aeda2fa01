//! `rig bench`: all parts, one after the other.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use onboard::cli::Failure;

use super::options::{Options, Part};
use super::report::{PartReport, Report};
use super::windows::{Meter, reason};
use super::{bus, events, mediator, robot, symbols, table, tubes, wakeup, work};
use crate::machine::{Machine, round};
use crate::output::{end_flag, make_folder, write_json};
use crate::stalls::StallWatch;

/// Folder for the report, unless told otherwise.
const OUT: &str = "target/rig/bench";

/// Measures what is wanted; prints a table and leaves `bench.json`.
///
/// # Errors
/// [`Failure::Refused`] when nothing was measured, [`Failure::Failed`] when a part was not, or when it was told to end before its end.
pub fn bench(options: &Options) -> Result<(), Failure> {
    let asked_to_end = end_flag()?;
    let out = { options.out.clone() }.unwrap_or_else(|| PathBuf::from(OUT));
    make_folder(&out)?;
    let report = measured(options, &asked_to_end)?;
    let file = write_json(&out, "bench.json", &report)?;
    let (stalls, steal_ms) = (report.stalls, report.stalls.steal_ms);
    onboard::say!("in all {stalls}; the host took {steal_ms:.0} ms of all cores");
    onboard::say!("wrote {}", file.display());
    let failed = report.parts.iter().filter(|part| part.failure.is_some());
    let failed: Vec<&str> = failed.map(|part| part.part.as_str()).collect();
    match (report.interrupted, failed.is_empty()) {
        (true, _) => Err(Failure::failed("interrupted: the figures are not complete")),
        (false, false) => Err(Failure::failed(format_args!(
            "not measured to the end: {}",
            failed.join(", ")
        ))),
        (false, true) => Ok(()),
    }
}

fn measured(options: &Options, asked_to_end: &AtomicBool) -> Result<Report, Failure> {
    let watch = StallWatch::of_cores().map_err(Failure::refused)?;
    let meter = Meter {
        watch: &watch,
        long: options.long,
        asked_to_end,
    };
    let mut report = Report {
        machine: Machine::here(),
        long: options.long,
        optimised: !cfg!(debug_assertions),
        parts: Vec::new(),
        stalls: watch.stalls(),
        interrupted: false,
    };
    let Machine {
        processor,
        cores,
        kernel,
    } = &report.machine;
    onboard::say!("{processor}, {cores} cores, Linux {kernel}");
    if !report.optimised {
        onboard::say!("built for tests: --release is what runs on a robot");
    }
    for part in options.parts() {
        let time = options.time(part);
        onboard::say!("\n{} ({:.1} s)", part.name(), time.as_secs_f64());
        let own = measure(part, &meter, time);
        table::lines(&own)
            .iter()
            .for_each(|line| onboard::say!("{line}"));
        report.parts.push(own);
        if meter.is_over() {
            report.interrupted = true;
            break;
        }
    }
    report.stalls = watch.stalls();
    Ok(report)
}

fn measure(part: Part, meter: &Meter, time: Duration) -> PartReport {
    let began = Instant::now();
    let mut own = PartReport {
        part: part.name().to_owned(),
        ..PartReport::default()
    };
    let result = match part {
        Part::Wakeup => wakeup::measure(meter, time, &mut own),
        Part::Symbols => symbols::measure(meter, time, &mut own),
        Part::Events => events::measure(meter, time, &mut own),
        Part::Bus => bus::measure(meter, time, &mut own),
        Part::Tubes => tubes::measure(meter, time, &mut own),
        Part::Work => work::measure(meter, time, &mut own),
        Part::Robot => robot::measure(meter, time, &mut own),
        Part::Mediator => mediator::measure(meter, time, &mut own),
    };
    own.failure = result.err().as_ref().map(reason);
    own.took_s = round(began.elapsed().as_secs_f64());
    own
}
