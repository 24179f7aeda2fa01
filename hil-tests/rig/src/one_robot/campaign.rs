//! Many stepped runs, on all cores.

use std::io::{IsTerminal, Write};
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use onboard::cli::Files;
use onboard::composition::plan::Plan;

use crate::campaign::statistics::Statistics;
use crate::cli::Failure;
use crate::folder::Folder;
use crate::one_robot::trial::Scenario;
use crate::stepped::{Outcome, Setup, run};

/// Runs seeds `first..first + runs` in `jobs` threads.
///
/// # Errors
/// [`Failure::Refused`] when a run cannot be built.
pub fn campaign(
    plan: &Plan,
    files: &Files,
    scenario: &dyn Scenario,
    first_seed: u64,
    runs: usize,
    jobs: Option<NonZeroUsize>,
    asked_to_end: &AtomicBool,
) -> Result<(Statistics, Vec<Outcome>), Failure> {
    let jobs = jobs
        .or_else(|| std::thread::available_parallelism().ok())
        .map_or(1, NonZeroUsize::get)
        .min(runs.max(1));
    let began = Instant::now();
    let next = AtomicUsize::new(0);
    let finished = AtomicUsize::new(0);
    let failed = AtomicU64::new(0);
    let outcomes = Mutex::new(Vec::with_capacity(runs));
    let trouble: Mutex<Option<Failure>> = Mutex::new(None);
    let terminal = std::io::stdout().is_terminal();
    std::thread::scope(|scope| {
        for job in 0..jobs {
            let (next, finished, failed, outcomes, trouble) =
                (&next, &finished, &failed, &outcomes, &trouble);
            scope.spawn(move || {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= runs || asked_to_end.load(Ordering::Relaxed) {
                        return;
                    }
                    let seed = first_seed + number as u64;
                    let outcome = one(plan, files, scenario, seed);
                    match outcome {
                        Ok(outcome) => {
                            failed.fetch_add(u64::from(!outcome.passed()), Ordering::Relaxed);
                            lock(outcomes).push(outcome);
                        }
                        Err(failure) => {
                            *lock(trouble) = Some(failure);
                            next.store(runs, Ordering::Relaxed);
                            return;
                        }
                    }
                    let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
                    if terminal && job == 0 {
                        print!(
                            "\r\x1b[K{}: {done} of {runs} runs, {} failed",
                            scenario.name(),
                            failed.load(Ordering::Relaxed)
                        );
                        // A closed terminal is no reason to stop.
                        let _ = std::io::stdout().flush();
                    }
                }
            });
        }
    });
    if terminal {
        print!("\r\x1b[K");
    }
    if let Some(failure) = lock(&trouble).take() {
        return Err(failure);
    }
    let mut outcomes = std::mem::take(&mut *lock(&outcomes));
    outcomes.sort_by_key(|outcome| outcome.seed);
    let statistics = Statistics::of(
        scenario.name(),
        files,
        &outcomes,
        began.elapsed().as_secs_f64(),
    );
    Ok((statistics, outcomes))
}

fn one(plan: &Plan, files: &Files, scenario: &dyn Scenario, seed: u64) -> Result<Outcome, Failure> {
    let folder = Folder::new()?;
    let setup = Setup {
        plan,
        files,
        scenario,
        folder: folder.path(),
        heeds_leave: true,
    };
    run(&setup, seed, false)
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}
