//! A stepped fleet as a way to run a scenario.

use description::instruction::Instruction;
use onboard::cli::Failure;
use onboard::process::ctl::{Event, Request};
use onboard::symbols::faults::{Fault, FaultTable, Resumes};
use sim::world::{Truth, TruthRecord, World};

use super::clock::START_NS;
use super::fleet::{Leave, Stepped};
use super::member::Member;
use super::robot::SteppedRobot;
use crate::belief::Belief;
use crate::judge::Waiting;
use crate::network::mediator_status::Told;
use crate::network::observations::Observations;
use crate::run::measured::{device_violations, robot_summary};
use crate::run::{Ending, Execution, Found, LOOK_NS, MediatorRuns};
use crate::summary::{MediatorSummary, RobotSummary};
use crate::violation::ViolationKind;

impl Execution for Stepped<'_> {
    fn start_ns(&self) -> u64 {
        START_NS
    }

    fn now_ns(&self) -> u64 {
        Stepped::now_ns(self)
    }

    fn pass_time(&mut self) -> Result<(), Failure> {
        self.advance()
    }

    fn ended(&mut self) -> Option<Ending> {
        let (fault, since_ns) = self.stranded?;
        Some(Ending::Stranded(fault.name(), since_ns))
    }

    fn truths(&mut self) -> Vec<TruthRecord> {
        if !std::mem::take(&mut self.fresh) {
            return Vec::new();
        }
        let sequence = (self.now_ns() - START_NS) / LOOK_NS;
        let world = self.world.lock();
        let clones = { self.clones.iter() }.filter(|own| own.begun);
        { 0..self.robots.len() }
            .chain(clones.map(|own| own.body))
            .filter_map(|robot| {
                Some(TruthRecord {
                    sequence,
                    robot,
                    truth: world.truth(robot)?,
                })
            })
            .collect()
    }

    fn belief(&mut self, robot: usize) -> Option<Belief> {
        let robot = self.robots.get_mut(robot)?.robot.as_mut()?;
        Some(robot.insight().look())
    }

    fn latch(&self, robot: usize) -> Option<Waiting> {
        let member = self.robots.get(robot)?;
        let process = member.robot.as_ref()?;
        let mut says =
            { member.faults.active() }.filter(|fault| fault.resumes() == Resumes::Operator);
        Some(Waiting {
            fault: says.next().map(Fault::name).or(member.motors_off.fault()),
            asked: process.times_asked(),
            owes: process.owes_an_answer(),
        })
    }

    fn show<R>(&self, to: impl FnOnce(&World, &Observations) -> R) -> R {
        to(&self.world.lock(), &self.observations)
    }

    fn heard<R>(&self, to: impl FnOnce(&Observations) -> R) -> R {
        to(&self.observations)
    }

    fn told<R>(&self, to: impl FnOnce(Option<&Told>) -> R) -> R {
        to((!self.mediator_spans_ns.is_empty()).then_some(&self.told))
    }

    fn hears_grants(&self) -> bool {
        self.plans.managed
    }

    fn instruct(&mut self, robot: usize, instruction: &Instruction<String>) -> Result<(), String> {
        let member = self
            .robots
            .get_mut(robot)
            .and_then(|own| own.robot.as_mut());
        match member {
            Some(robot) if robot.knows(&instruction.event) => {
                robot.ask(Request::Send(Event(instruction.clone())));
                Ok(())
            }
            Some(_) => Err(format!(
                "the robot's machine does not know `{}`",
                instruction.event
            )),
            None => Err("the robot does not run".to_owned()),
        }
    }

    fn give_leave(&mut self, robot: usize, areas: &[bool]) -> bool {
        if self.leave == Leave::OfMediator {
            return false;
        }
        if let Some(member) = self.robots.get_mut(robot) {
            member.allowed = areas.to_vec();
            if let Some(robot) = &mut member.robot {
                robot.allow(areas);
            }
        }
        true
    }

    fn stop(&mut self) -> Vec<Found> {
        for member in &mut self.robots {
            let symbols = member.robot.as_ref().map(SteppedRobot::symbols);
            member.symbols = symbols.unwrap_or_default();
        }
        let plans = &self.plans.robots;
        let devices = { self.robots.iter().zip(plans) }.flat_map(|(member, (_, plan))| {
            let found = device_violations(&plan.robot, &member.devices.drive());
            { found.into_iter() }.map(|(kind, detail)| (kind, member.id.clone(), detail))
        });
        let refused = |member: &Member| {
            let all = { member.robot.iter() }.flat_map(SteppedRobot::refused);
            let id = member.id.clone();
            all.map(move |why| (ViolationKind::Instruction, id.clone(), why))
                .collect::<Vec<_>>()
        };
        let panicked = { self.panicked.iter().cloned() }
            .map(|(id, detail)| (ViolationKind::RobotEnd, id, detail));
        { self.robots.iter().flat_map(refused) }
            .chain(devices)
            .chain(panicked)
            .collect()
    }

    fn robot_summary(&self, robot: usize, truth: Option<&Truth>) -> RobotSummary {
        let (own, (_, plan)) = (&self.robots[robot], &self.plans.robots[robot]);
        let now = own
            .robot
            .as_ref()
            .map_or(FaultTable::default(), |_| own.faults);
        RobotSummary {
            faults: { Fault::ALL.into_iter().zip(&own.raised_before) }
                .map(|(fault, before)| (fault, now.state(fault).count + before))
                .map(|(fault, count)| (fault.name().to_owned(), count))
                .filter(|(_, count)| *count > 0)
                .collect(),
            resets: own.caretaker.resets,
            driven_out: own.driving_out.times,
            restarted: own.restarting.times,
            ..robot_summary(&plan.robot, &own.devices.drive(), truth, &own.symbols)
        }
    }

    fn mediator(&self) -> Option<MediatorRuns> {
        let spans_ns = self.mediator_spans_ns.clone();
        let starts = u32::try_from(spans_ns.len()).unwrap_or(u32::MAX);
        (starts > 0).then(|| MediatorRuns {
            summary: MediatorSummary {
                starts,
                dropped: Some(self.dropped + self.mediator.as_ref().map_or(0, |own| own.dropped())),
                ..MediatorSummary::default()
            },
            spans_ns,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Run;
    use crate::stepped::Plans;
    use crate::stepped::checkpoints::Checkpoints;
    use crate::testing;
    use crate::violation::ViolationKind;

    #[test]
    fn a_message_that_cannot_be_decoded_is_a_violation() {
        let scenario = testing::scenario("overtaking");
        let plans = Plans::of(&scenario).expect("plans");
        let stepped = Stepped::new(&scenario, &plans, 1, true, false).expect("built");
        let mut run = Run::new(scenario, stepped, 1);
        for _ in 0..50 {
            assert_eq!(run.step().expect("it runs"), None);
        }
        run.stop();
        assert_eq!(run.judge.violations(), []);
        let at_ns = START_NS + 500_000_000;
        run.stage.observations.note_malformed(at_ns);
        run.stage.observations.note_malformed(at_ns + 1);
        run.stop();
        let found = run.judge.violations();
        assert_eq!((found.len(), found[0].at_s), (1, 0.5));
        assert_eq!(found[0].kind, ViolationKind::Malformed);
        assert_eq!(found[0].detail, "2 messages could not be decoded");
    }

    #[test]
    fn a_panic_that_no_fault_tells_of_is_a_violation() {
        let mut scenario = testing::scenario("overtaking");
        let fault = "at_s = 4.0\nfor_s = 1.0\nwhat = \"panic\"\nrobot = \"amr-1\"";
        scenario.faults = vec![toml::from_str(fault).expect("a fault")];
        let plans = Plans::of(&scenario).expect("plans");
        let stepped = Stepped::new(&scenario, &plans, 1, true, false).expect("built");
        let mut run = Run::new(scenario, stepped, 1);
        // Robots start one after the other; the first one has come back by then.
        for _ in 0..8_000_000_000 / LOOK_NS {
            assert_eq!(run.step().expect("it runs"), None);
        }
        let own = run.stage.robots[1].robot.as_mut().expect("it runs");
        own.panic("navigation");
        let ending = (0..50).find_map(|_| run.step().expect("it runs"));
        assert!(
            matches!(ending, Some(Ending::Stranded("panic", _))),
            "{ending:?}"
        );
        run.stop();
        let found = run.judge.violations();
        let kinds: Vec<_> = { found.iter() }
            .map(|own| (own.kind, own.robot.as_str()))
            .collect();
        assert_eq!(kinds, [(ViolationKind::RobotEnd, "amr-2")], "{found:?}");
    }

    #[test]
    fn a_robot_whose_next_process_forgets_that_its_motors_were_off_must_wait_all_the_same() {
        let mut scenario = testing::scenario("overtaking");
        let fault = |text: &str| toml::from_str(&text.replace(", ", "\n")).expect("a fault");
        scenario.faults = vec![
            fault("at_s = 3.0, for_s = 2.5, what = \"cut-motors\", robot = \"amr-1\""),
            fault("at_s = 6.0, for_s = 1.0, what = \"kill-robot\", robot = \"amr-1\""),
        ];
        let plans = Plans::of(&scenario).expect("plans");
        let mut stepped = Stepped::new(&scenario, &plans, 1, true, false).expect("built");
        let mut waits = |until_s: f64| {
            while ((stepped.now_ns() - START_NS) as f64) < until_s * 1e9 {
                stepped.advance().expect("it runs");
            }
            let waiting = stepped.latch(0);
            if waiting.is_none() {
                stepped.robots[0].checkpoints = Checkpoints::default();
            }
            waiting.map(|own| own.fault)
        };
        assert_eq!(waits(2.9), Some(None));
        assert_eq!(waits(5.0), Some(Some("motors-off")), "as it says");
        assert_eq!(waits(6.5), None, "no process");
        assert_eq!(
            waits(8.5),
            Some(Some("place-unknown")),
            "it begins at its start"
        );
        let own = &stepped.robots[0];
        assert_eq!(
            own.motors_off.fault(),
            Some("motors-off"),
            "whatever it says"
        );
        assert_eq!(own.faults.state(Fault::MotorsOff).active, 0);
    }
}
