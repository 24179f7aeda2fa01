//! Many runs on the simulated clock, in threads of this process.

use std::io::{IsTerminal, Write};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use onboard::cli::Failure;

use super::pool::run_all;
use super::statistics::Statistics;
use crate::run::{Run, look_on, record};
use crate::scenario::Scenario;
use crate::stepped::faults::faulted;
use crate::stepped::{Plans, Stepped};
use crate::summary::Summary;

/// Runs a scenario with these seeds in `jobs` threads, with `faults` drawn from each seed.
///
/// # Errors
/// [`Failure::Refused`] when a run cannot be built.
pub fn campaign(
    scenario: &Scenario,
    plans: &Plans,
    seeds: Range<u64>,
    jobs: usize,
    faults: bool,
    asked_to_end: &AtomicBool,
) -> Result<Statistics, Failure> {
    let began = Instant::now();
    let runs = usize::try_from(seeds.end - seeds.start).unwrap_or(usize::MAX);
    let failed = AtomicUsize::new(0);
    let terminal = std::io::stdout().is_terminal();
    let one = |number: usize| {
        let seed = seeds.start + number as u64;
        let summary = if faults {
            summary(&faulted(scenario, seed, None), plans, seed, true)?
        } else {
            summary(scenario, plans, seed, true)?
        };
        failed.fetch_add(usize::from(!summary.passed()), Ordering::Relaxed);
        Ok(summary)
    };
    let show = |_: &Summary, done: usize| {
        if terminal {
            let (name, failed) = (&scenario.name, failed.load(Ordering::Relaxed));
            print!("\r\x1b[K{name}: {done} of {runs} runs, {failed} failed");
            // A closed terminal is no reason to stop.
            let _ = std::io::stdout().flush();
        }
    };
    let summaries = run_all(runs, jobs, asked_to_end, one, show);
    if terminal {
        print!("\r\x1b[K");
    }
    let elapsed_s = began.elapsed().as_secs_f64();
    Ok(Statistics::of(scenario, &summaries?, elapsed_s))
}

/// One run on the simulated clock, and what came out. A robot that does not heed leave is a control.
///
/// # Errors
/// [`Failure::Refused`] when it cannot be built.
pub fn summary(
    scenario: &Scenario,
    plans: &Plans,
    seed: u64,
    heeds_leave: bool,
) -> Result<Summary, Failure> {
    let stepped = Stepped::new(scenario, plans, seed, heeds_leave, false)?;
    let mut run = Run::new(scenario.clone(), stepped, seed);
    let ending = look_on(&mut run, true, &AtomicBool::new(false))?;
    run.stop();
    Ok(record(&run, &ending).summary)
}
