//! One run on the simulated clock.

use std::sync::atomic::AtomicBool;

use onboard::cli::Failure;

use crate::record::Record;
use crate::run::{Run, record};
use crate::scenario::Scenario;
use crate::stepped::{Plans, Stepped};

/// All that is known of it. A robot that does not heed leave is a control.
///
/// # Errors
/// [`Failure::Refused`] when it cannot be built.
pub(super) fn recorded(
    scenario: &Scenario,
    plans: &Plans,
    seed: u64,
    heeds_leave: bool,
) -> Result<Record, Failure> {
    let stepped = Stepped::new(scenario, plans, seed, heeds_leave, false)?;
    let mut run = Run::new(scenario.clone(), stepped, seed);
    let ending = run.run_to_end(true, &AtomicBool::new(false));
    run.stop();
    Ok(record(&run, &ending))
}
