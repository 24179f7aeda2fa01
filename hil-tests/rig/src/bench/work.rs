//! What the cycles of a robot take to compute while it drives laps on the simulated clock: nothing is preempted, and neither system calls nor
//! devices are in it. There is no rival. On an emulated machine with one instruction in each nanosecond of its own time, as
//! `scripts/xu4 count` has it, nanoseconds are instructions.

use std::time::{Duration, Instant};

use onboard::cli::Failure;
use sim::rt::monotonic_ns;

use super::report::{Group, PartReport, Unit, What};
use super::samples::{Sample, Samples};
use super::windows::Meter;
use crate::run::Run;
use crate::scenario::{Changes, load_shipped};
use crate::stalls::Stalls;
use crate::stepped::work::{Work, WorkMeter};
use crate::stepped::{Plans, Stepped};

/// Samples are compared with the stalls of about this time.
const WINDOW: Duration = Duration::from_secs(1);
/// Looks at the clock are timed this often.
const LOOKS: u64 = 1_000;

/// Measures for so long.
///
/// # Errors
/// [`Failure`] when the robot cannot be built, or does not run.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    let scenario = load_shipped("lap", &Changes::default())?;
    let plans = Plans::of(&scenario)?;
    let (began, began_ns, before) = (Instant::now(), monotonic_ns(), meter.watch.stalls());
    let mut measured = Work::ALL.map(|_| Samples::default());
    let mut own = WorkMeter::begin();
    for seed in 1.. {
        let stepped = Stepped::new(&scenario, &plans, seed, true, false)?;
        let mut run = Run::new(scenario.clone(), stepped, seed);
        let mut ended = false;
        while !ended && began.elapsed() < time && !meter.is_over() {
            let (window, window_ns) = (Instant::now(), monotonic_ns());
            while !ended && window.elapsed() < WINDOW.min(time) {
                ended = run.step()?.is_some();
            }
            let stalls = meter.watch.spans_since(window_ns);
            for done in own.take() {
                let (began_ns, ended_ns) = done.span_ns;
                let sample = Sample::during(done.took_ns as f64, began_ns, ended_ns);
                measured[done.work as usize].add(&[sample], &stalls);
            }
        }
        if began.elapsed() >= time || meter.is_over() {
            break;
        }
    }
    let stalls = Stalls {
        steal_ms: meter.watch.stalls().steal_ms - before.steal_ms,
        ..meter.watch.since(began_ns)
    };
    for (work, samples) in Work::ALL.into_iter().zip(measured) {
        if samples.is_empty() {
            return Err(Failure::failed(format_args!("{}: never done", title(work))));
        }
        let what = What::new(title(work), Unit::Ns);
        let rows = [("onboard".to_owned(), samples)];
        part.groups
            .push(Group::new(&what, &rows, stalls, meter.long));
    }
    part.notes.push(format!(
        "two looks at the clock are in each, {:.0} ns",
        look_ns()
    ));
    Ok(())
}

fn title(work: Work) -> &'static str {
    match work {
        Work::Bus => "a bus cycle: drive",
        Work::Motion => "a motion cycle: odometry and setpoints",
        Work::Parse => "the bytes of a scan",
        Work::Scan => "a scan: aligned, walls, pose, wanted motion",
        Work::Tubes => "a scan against the motion tubes",
    }
}

/// What a look at the clock takes.
fn look_ns() -> f64 {
    let began_ns = monotonic_ns();
    let mut last_ns = began_ns;
    for _ in 0..LOOKS {
        last_ns = std::hint::black_box(monotonic_ns());
    }
    (last_ns - began_ns) as f64 / LOOKS as f64
}
