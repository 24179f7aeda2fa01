//! Runs with one seed after the other, several at once.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use onboard::cli::Failure;

/// Makes runs 0 to `runs - 1` in `jobs` threads, until asked to end; returns their results in the order of the runs. A run
/// that cannot be made ends all: the next one would fail alike. `done` gets each result, and how many there are so far.
///
/// # Errors
/// That of the run that could not be made.
pub(super) fn run_all<T: Send>(
    runs: usize,
    jobs: usize,
    asked_to_end: &AtomicBool,
    one: impl Fn(usize) -> Result<T, Failure> + Sync,
    done: impl Fn(&T, usize) + Sync,
) -> Result<Vec<T>, Failure> {
    let (next, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let outcomes = Mutex::new(Vec::with_capacity(runs));
    let trouble = Mutex::new(None);
    std::thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, runs.max(1)) {
            scope.spawn(|| {
                while !asked_to_end.load(Ordering::Relaxed) {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= runs {
                        break;
                    }
                    // A panic here is no run's own, but one of what draws or reports it.
                    let made = catch_unwind(AssertUnwindSafe(|| one(number)));
                    let panicked = format_args!("run {number} of {runs}, from 0, panicked");
                    match made.unwrap_or_else(|_| Err(Failure::failed(panicked))) {
                        Ok(outcome) => {
                            done(&outcome, finished.fetch_add(1, Ordering::Relaxed) + 1);
                            lock(&outcomes).push((number, outcome));
                        }
                        Err(failure) => {
                            next.store(runs, Ordering::Relaxed);
                            *lock(&trouble) = Some(failure);
                        }
                    }
                }
            });
        }
    });
    if let Some(failure) = lock(&trouble).take() {
        return Err(failure);
    }
    let mut outcomes = std::mem::take(&mut *lock(&outcomes));
    outcomes.sort_by_key(|(number, _)| *number);
    Ok(outcomes.into_iter().map(|(_, outcome)| outcome).collect())
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}
