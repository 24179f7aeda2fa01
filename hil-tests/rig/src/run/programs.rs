//! A run through the real programs, and what can be done to it.

use std::sync::atomic::AtomicBool;

use onboard::cli::Failure;
use sim::rt::monotonic_ns;

use super::finish::{conclude, look_on, verdict};
use super::options::Options;
use super::repeat::repeated;
use super::stage::Stage;
use super::watch::Run;
use crate::scenario::{Limits, Scenario};

/// Runs a scenario to its end, and writes its summary and reports; once more if a stall of the machine spoiled it.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when goals were not reached or something was violated.
pub fn run(
    scenario: &Scenario,
    options: &Options,
    asked_to_end: &AtomicBool,
) -> Result<(), Failure> {
    let out = &options.out;
    repeated(out, asked_to_end, |spoiled| {
        let mut run = Run::start(scenario.clone(), options)?;
        let ending = look_on(&mut run, options.headless, asked_to_end)?;
        let record = conclude(&mut run, out, &ending, spoiled)?;
        let success = verdict(&record, out, &ending);
        Ok((record.summary, success))
    })
}

/// The limits of real programs. How accurate a robot is hangs on the machine, which may stall: it is measured and printed as on the
/// simulated clock, where it is judged. What is left is safety.
fn without_accuracy(limits: Limits) -> Limits {
    let unlimited = |limit: Option<f64>| limit.map(|_| f64::INFINITY);
    Limits {
        pose_error_m: unlimited(limits.pose_error_m),
        heading_error_deg: unlimited(limits.heading_error_deg),
        dock_error_m: unlimited(limits.dock_error_m),
        pose_stop_error_m: unlimited(limits.pose_stop_error_m),
        border_stop_error_m: unlimited(limits.border_stop_error_m),
        lateral_error_m: unlimited(limits.lateral_error_m),
        over_speed: unlimited(limits.over_speed),
        ..limits
    }
}

impl Run<Stage> {
    /// Starts the programs; robots start as their times come.
    ///
    /// # Errors
    /// [`Failure::Refused`] naming what is wrong or not available.
    pub fn start(mut scenario: Scenario, options: &Options) -> Result<Self, Failure> {
        scenario.limits = without_accuracy(scenario.limits);
        let stage = Stage::set(&scenario, options)?;
        let names: Vec<&str> = { scenario.robots.iter() }
            .map(|own| own.id.as_str())
            .collect();
        onboard::say!(
            "{}: {} in {}, seed {}{}{}; logs in {}",
            scenario.name,
            names.join(", "),
            scenario.site.name,
            options.seed,
            if options.mediator {
                ""
            } else {
                ", WITHOUT mediator"
            },
            if options.nets { "" } else { ", WITHOUT nets" },
            options.out.display()
        );
        Ok(Self::new(scenario, stage, options.seed))
    }

    /// Kills a robot's process; the run goes on.
    pub fn kill_robot(&mut self, robot: usize) {
        if let Some(member) = self.stage.members.get_mut(robot) {
            member.kill();
            let what = format!("{} is killed", member.id());
            self.note(what);
        }
    }

    /// Kills the mediator; the run goes on.
    pub fn kill_mediator(&mut self) {
        if let Some(mediator) = &mut self.stage.mediator {
            mediator.kill();
            self.note("the mediator is killed".to_owned());
        }
    }

    /// Starts the killed mediator again.
    ///
    /// # Errors
    /// [`Failure::Failed`] with the operating system's reason.
    pub fn start_mediator_again(&mut self) -> Result<(), Failure> {
        if let Some(mediator) = &mut self.stage.mediator {
            mediator.start_again().map_err(|error| {
                Failure::failed(format_args!("the mediator cannot be started: {error}"))
            })?;
            self.note("the mediator is started again".to_owned());
        }
        Ok(())
    }

    /// What an operator does with `mediator clear AREA --taken-away`, having taken these robots away. Returns what the mediator says.
    ///
    /// # Errors
    /// Why it refused or did not answer.
    pub fn clear(&mut self, area: &str, robots: &[&str]) -> Result<String, String> {
        let mediator = self.stage.mediator.as_ref();
        let said = mediator.ok_or("there is no mediator")?.clear(area)?;
        self.judge.cleared(area, robots);
        let mut observations = self.stage.listener.observations();
        observations.cleared(area, robots, monotonic_ns());
        drop(observations);
        self.note(format!("area {area} is cleared"));
        Ok(said)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn real_programs_are_held_to_safety_and_their_accuracy_is_measured() {
        for name in ["course", "clutter", "lap"] {
            let stepped = testing::scenario(name).limits;
            let real = without_accuracy(stepped);
            let accuracy = |limits: &Limits| {
                let Limits {
                    pose_error_m,
                    heading_error_deg,
                    dock_error_m,
                    pose_stop_error_m,
                    border_stop_error_m,
                    lateral_error_m,
                    over_speed,
                    ..
                } = *limits;
                [
                    pose_error_m,
                    heading_error_deg,
                    dock_error_m,
                    pose_stop_error_m,
                    border_stop_error_m,
                    lateral_error_m,
                    over_speed,
                ]
            };
            for (wanted, limit) in accuracy(&stepped).into_iter().zip(accuracy(&real)) {
                assert_eq!(limit, wanted.map(|_| f64::INFINITY), "{name}");
            }
            assert_eq!(real.concern_belief(), stepped.concern_belief());
            assert_eq!(real.clearance_m, stepped.clearance_m);
            assert_eq!(real.may_be_run_into, stepped.may_be_run_into);
        }
        assert!(testing::scenario("course").limits.concern_belief());
        let lap = testing::scenario("lap").limits;
        assert!(lap.lateral_error_m.is_some() && lap.over_speed.is_some());
    }
}
