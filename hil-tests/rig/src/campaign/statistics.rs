//! Statistics of many stepped runs: who passed, who failed and why, and the distribution of each figure.

use serde::Serialize;

use super::shrink::{MOST, Shrunk};
use crate::figures::Figures;
use crate::percentile::Ranked;
use crate::scenario::Scenario;
use crate::summary::{RobotSummary, Summary};

/// What came out of all runs.
#[derive(Debug, Serialize)]
pub struct Statistics {
    /// Name of the scenario.
    pub scenario: String,
    /// Robot file.
    pub robot: String,
    /// Site file.
    pub site: String,
    /// Runs made.
    pub runs: usize,
    /// Done, and nothing wrong.
    pub passed: usize,
    /// Runs in which the robot did what it should, whatever happened on the way.
    pub done: usize,
    /// Runs in which nothing happened that must not, finished or not.
    pub clean: usize,
    /// Runs with at least one violation of each kind.
    pub violations: Vec<(String, usize)>,
    /// Runs in which each fault was raised.
    pub faults: Vec<(String, usize)>,
    /// Quantities over all runs.
    pub quantities: Vec<Quantity>,
    /// Simulated time of all runs.
    pub simulated_s: f64,
    /// Time that took: of each session until its last finished run.
    pub elapsed_s: f64,
    /// Runs that failed, with their reasons.
    pub failures: Vec<FailedRun>,
}

/// A run that failed.
#[derive(Debug, Serialize)]
pub struct FailedRun {
    /// Its seed.
    pub seed: u64,
    /// Why.
    pub reason: String,
    /// How to see it again.
    #[serde(flatten)]
    pub again: Shrunk,
}

/// The distribution of one figure.
#[derive(Debug, Serialize)]
pub struct Quantity {
    /// What it is, with its unit.
    pub name: &'static str,
    /// How many values.
    pub count: usize,
    /// Least.
    pub min: f64,
    /// Median, by nearest rank.
    pub p50: f64,
    /// 99th percentile, by nearest rank.
    pub p99: f64,
    /// Largest.
    pub max: f64,
}

impl Statistics {
    /// Of these runs of a scenario, which took `elapsed_s` together; of those that failed also what they shrank to, in the same
    /// order.
    #[must_use]
    pub fn of(scenario: &Scenario, runs: &[Summary], elapsed_s: f64, shrunk: Vec<Shrunk>) -> Self {
        let count = |is: &dyn Fn(&Summary) -> bool| runs.iter().filter(|one| is(one)).count();
        let violations = tally(runs, |run| {
            run.violations
                .iter()
                .map(|own| own.kind.to_string())
                .collect()
        });
        let faults = tally(runs, |run| {
            let faults = run.robots.iter().flat_map(|robot| &robot.faults);
            faults.map(|(fault, _)| fault.clone()).collect()
        });
        let failures = { runs.iter() }
            .filter(|run| !run.passed())
            .zip(shrunk)
            .map(|(run, shrunk)| FailedRun {
                seed: run.seed,
                reason: run.reason(),
                again: shrunk,
            })
            .collect();
        let files: Vec<String> = { scenario.robots.iter() }
            .map(|player| player.file.display().to_string())
            .collect();
        Self {
            scenario: scenario.name.clone(),
            robot: files.join(", "),
            site: scenario.site_file.display().to_string(),
            runs: runs.len(),
            passed: count(&Summary::passed),
            done: count(&Summary::is_done),
            clean: count(&|run| run.violations.is_empty()),
            violations,
            faults,
            quantities: quantities(runs),
            simulated_s: runs.iter().map(|run| run.duration_s).sum(),
            elapsed_s,
            failures,
        }
    }

    /// Prints them, failing seeds first.
    pub fn print(&self) {
        for failure in self.failures.iter().take(MOST) {
            onboard::say!("FAILED seed {}: {}", failure.seed, failure.reason);
            failure.again.print();
        }
        if self.failures.len() > MOST {
            onboard::say!("... and {} more", self.failures.len() - MOST);
        }
        onboard::say!(
            "{}: {} of {} runs passed; {} did it, {} had nothing wrong",
            self.scenario,
            self.passed,
            self.runs,
            self.done,
            self.clean
        );
        let listed = |list: &[(String, usize)]| {
            let parts: Vec<String> = list
                .iter()
                .map(|(name, runs)| format!("{name} in {runs}"))
                .collect();
            if parts.is_empty() {
                "none".to_owned()
            } else {
                parts.join(", ")
            }
        };
        onboard::say!("violations (runs): {}", listed(&self.violations));
        onboard::say!("faults (runs): {}", listed(&self.faults));
        for quantity in &self.quantities {
            onboard::say!(
                "{:<44} min {:>9.4}  p50 {:>9.4}  p99 {:>9.4}  max {:>9.4}  (n = {})",
                quantity.name,
                quantity.min,
                quantity.p50,
                quantity.p99,
                quantity.max,
                quantity.count
            );
        }
        onboard::say!(
            "{:.0} s simulated in {:.1} s: {:.0} times real time",
            self.simulated_s,
            self.elapsed_s,
            self.simulated_s / self.elapsed_s.max(1e-9)
        );
    }
}

/// In how many runs each name appears, most first.
fn tally(runs: &[Summary], names: impl Fn(&Summary) -> Vec<String>) -> Vec<(String, usize)> {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for run in runs {
        let mut mine = names(run);
        mine.sort();
        mine.dedup();
        for name in mine {
            match counts.iter_mut().find(|(other, _)| *other == name) {
                Some((_, count)) => *count += 1,
                None => counts.push((name, 1)),
            }
        }
    }
    counts.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    counts
}

fn quantities(runs: &[Summary]) -> Vec<Quantity> {
    let robots = || runs.iter().flat_map(|run| &run.robots);
    let figures = || robots().filter_map(|robot| robot.figures.as_ref());
    let figure = |of: &dyn Fn(&Figures) -> f64| -> Vec<f64> { figures().map(of).collect() };
    let all = |of: &dyn Fn(&Figures) -> &[f64]| -> Vec<f64> {
        figures().flat_map(of).map(|value| value.abs()).collect()
    };
    let of_robots = |of: &dyn Fn(&RobotSummary) -> f64| -> Vec<f64> { robots().map(of).collect() };
    let done = { runs.iter() }.filter(|run| run.is_done());
    let done: Vec<f64> = done.map(|run| run.duration_s).collect();
    [
        ("duration of runs that were done, s", done),
        ("distance, m", figure(&|one| one.distance_m)),
        ("least clearance, m", figure(&|one| one.min_clearance_m)),
        (
            "largest pose error where walls are in view, m",
            figure(&|one| one.max_pose_error_m),
        ),
        (
            "largest heading error in view, degrees",
            figure(&|one| one.max_heading_error_rad.to_degrees()),
        ),
        (
            "largest position error anywhere, m",
            figure(&|one| one.max_position_error_m),
        ),
        ("docking error, m", all(&|one| &one.dock_errors_m)),
        (
            "error of stops at a pose, m",
            all(&|one| &one.pose_stop_errors_m),
        ),
        (
            "error of stops before an area, m",
            all(&|one| &one.border_stop_errors_m),
        ),
        (
            "least distance to a border without leave, m",
            figure(&|one| one.min_border_m),
        ),
        (
            "largest excess over an area's speed limit, m/s",
            figure(&|one| one.max_over_speed_m_s),
        ),
        (
            "leave withheld until it had waited, times",
            of_robots(&|robot| robot.withheld as f64),
        ),
        (
            "reset by an operator, times",
            of_robots(&|robot| f64::from(robot.resets)),
        ),
        (
            "driven out by hand, times",
            of_robots(&|robot| f64::from(robot.driven_out)),
        ),
        (
            "restarted by an operator, times",
            of_robots(&|robot| f64::from(robot.restarted)),
        ),
        ("held by the motion tubes, s", figure(&|one| one.held_s)),
        ("longest stand, s", figure(&|one| one.longest_stand_s)),
        (
            "run into while standing, times",
            figure(&|one| one.run_into as f64),
        ),
    ]
    .into_iter()
    .filter_map(|(name, values)| Quantity::of(name, values))
    .collect()
}

impl Quantity {
    fn of(name: &'static str, values: Vec<f64>) -> Option<Self> {
        let ranked = Ranked::of(values.into_iter().filter(|value| value.is_finite()));
        Some(Self {
            name,
            count: ranked.count(),
            min: ranked.at(0.0)?,
            p50: ranked.at(0.5)?,
            p99: ranked.at(0.99)?,
            max: ranked.at(1.0)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_what_is_a_number() {
        let values: Vec<f64> = (0..=100).map(f64::from).chain([f64::INFINITY]).collect();
        let quantity = Quantity::of("x", values).expect("there are values");
        assert_eq!(
            (quantity.count, quantity.p50, quantity.p99, quantity.max),
            (101, 50.0, 99.0, 100.0)
        );
        assert!(Quantity::of("x", vec![f64::NAN]).is_none());
    }
}
