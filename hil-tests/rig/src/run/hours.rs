//! What a long run says hour by hour: whether it still drives as well as in the beginning, and whether it needs more memory.

use super::execution::Execution;
use super::watch::Run;
use crate::process::usage::resident_mib;

/// How much of a run one line is about.
const HOUR_NS: u64 = 3_600_000_000_000;

/// An hour of a run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hour {
    /// Its number, from 1.
    pub(super) number: u64,
    /// Each robot, by its identity: rounds since the beginning, and largest lateral error in this hour.
    pub(super) robots: Vec<(String, u32, f64)>,
    /// Violations since the beginning.
    pub(super) violations: usize,
    /// Resident memory of this process at its end.
    pub(super) rss_mib: Option<f64>,
}

/// Notices when an hour of a run is over.
#[derive(Debug)]
pub(super) struct Hours {
    length_ns: u64,
    over: u64,
}

impl Default for Hours {
    fn default() -> Self {
        Self::of(HOUR_NS)
    }
}

impl Hours {
    fn of(length_ns: u64) -> Self {
        Self { length_ns, over: 0 }
    }

    /// The hour that is over since the last look, if one is.
    pub(super) fn look<E: Execution>(&mut self, run: &mut Run<E>) -> Option<Hour> {
        let passed_ns = run.stage.now_ns().saturating_sub(run.stage.start_ns());
        if passed_ns < (self.over + 1) * self.length_ns {
            return None;
        }
        self.over += 1;
        let judge = &mut run.judge;
        let robots = { run.scenario.robots.iter().zip(&run.tracks).enumerate() }.map(
            |(robot, (player, track))| {
                let error_m = judge.take_lateral_error_m(robot);
                (player.id.clone(), track.progress.rounds(), error_m)
            },
        );
        Some(Hour {
            number: self.over,
            robots: robots.collect(),
            violations: run.judge.violations().len(),
            rss_mib: resident_mib(std::process::id()),
        })
    }
}

impl std::fmt::Display for Hour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "hour {}:", self.number)?;
        for (id, rounds, error_m) in &self.robots {
            write!(
                f,
                " {id} {rounds} rounds, lateral error at most {error_m:.3} m;"
            )?;
        }
        write!(f, " {} violations", self.violations)?;
        match self.rss_mib {
            Some(rss_mib) => write!(f, "; {rss_mib:.1} MiB"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stepped::{Plans, Stepped};
    use crate::testing;

    #[test]
    fn each_hour_has_its_own_lateral_error_and_the_sum_of_the_rest() {
        const LENGTH_NS: u64 = 10_000_000_000;
        let scenario = testing::scenario("lap");
        let plans = Plans::of(&scenario).expect("plans");
        let stepped = Stepped::new(&scenario, &plans, 1, true, false).expect("built");
        let mut run = Run::new(scenario, stepped, 1);
        let (mut hours, mut seen) = (Hours::of(LENGTH_NS), Vec::new());
        while run.stage.seconds(run.stage.now_ns()) < 35.0 {
            assert_eq!(run.step().expect("it runs"), None);
            seen.extend(hours.look(&mut run));
        }
        let numbers: Vec<u64> = seen.iter().map(|hour| hour.number).collect();
        assert_eq!(numbers, [1, 2, 3]);
        let errors = seen.iter().map(|hour| hour.robots[0].2);
        let most_m = errors.clone().fold(0.0, f64::max);
        assert!(errors.clone().any(|error_m| error_m < most_m), "{seen:?}");
        assert!(most_m <= run.judge.max_lateral_error_m(0) && most_m > 0.0);
        assert!(seen.iter().all(|hour| hour.violations == 0));
        assert!(seen[0].rss_mib.is_some_and(|rss_mib| rss_mib > 1.0));
        assert!(
            seen[0]
                .to_string()
                .starts_with("hour 1: amr-1 0 rounds, lateral error")
        );
    }
}
