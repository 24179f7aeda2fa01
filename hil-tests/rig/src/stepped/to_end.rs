//! A run on the simulated clock, to its end: whatever breaks off in one run ends that run only.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;

use onboard::cli::Failure;

use super::fleet::Stepped;
use crate::run::{Ending, Run, look_on};
use crate::violation::ViolationKind;

impl Run<Stepped<'_>> {
    /// Steps and shows the run until it ends or is interrupted. A panic or an error within it is a violation and its end: it can be
    /// reported, and made again by its seed, as any other that failed. What panics in a robot's thread ends its process instead.
    pub fn run_to_end(&mut self, headless: bool, asked_to_end: &AtomicBool) -> Ending {
        self.unless_broken_off(|run| look_on(run, headless, asked_to_end))
    }

    fn unless_broken_off(
        &mut self,
        look_on: impl FnOnce(&mut Self) -> Result<Ending, Failure>,
    ) -> Ending {
        // Nothing is stepped afterwards: what the panic left half done is only looked at.
        let why = match catch_unwind(AssertUnwindSafe(|| look_on(self))) {
            Ok(Ok(ending)) => return ending,
            Ok(Err(Failure::Refused(report) | Failure::Failed(report))) => report.to_string(),
            Err(panic) => format!("panicked: {}", words(&*panic)),
        };
        let now_ns = self.stage.now_ns();
        (self.judge).report(ViolationKind::BrokenOff, "run", now_ns, why.clone());
        Ending::BrokenOff(why)
    }
}

/// What a panic says.
fn words(panic: &(dyn Any + Send)) -> &str {
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    owned
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("without a word")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::record;
    use crate::stepped::Plans;
    use crate::testing;

    fn broken_off(look_on: impl FnOnce(&mut Run<Stepped<'_>>) -> Result<Ending, Failure>) {
        let scenario = testing::scenario("overtaking");
        let plans = Plans::of(&scenario).expect("plans");
        let stepped = Stepped::new(&scenario, &plans, 1, true, false).expect("built");
        let mut run = Run::new(scenario, stepped, 1);
        let ending = run.unless_broken_off(|run| {
            for _ in 0..200 {
                assert_eq!(run.step().expect("it runs"), None);
            }
            look_on(run)
        });
        assert!(matches!(&ending, Ending::BrokenOff(why) if why.ends_with("on purpose")));
        run.stop();
        let summary = record(&run, &ending).summary;
        assert!(!summary.passed());
        assert!(
            summary.outcome.ends_with("on purpose"),
            "{}",
            summary.outcome
        );
        let found: Vec<_> = summary.violations.iter().map(|own| own.kind).collect();
        assert_eq!(found, [ViolationKind::BrokenOff]);
        // Threads of the next run are not taken for those of this one.
        let again = testing::scenario("overtaking");
        let plans = Plans::of(&again).expect("plans");
        let stepped = Stepped::new(&again, &plans, 1, true, false).expect("built");
        let mut next = Run::new(again, stepped, 1);
        for _ in 0..200 {
            assert_eq!(next.step().expect("it runs"), None);
        }
    }

    #[test]
    fn a_run_that_panics_or_fails_ends_by_itself_and_has_a_record() {
        broken_off(|_| panic!("on {}", "purpose"));
        broken_off(|run| {
            let _world = run.stage.world.lock();
            panic!("on purpose")
        });
        broken_off(|_| Err(Failure::failed("on purpose")));
    }
}
