//! The judge of a run.

use sim::world::{Pose, STANDING_M_S, Truth};

use super::areas::Areas;
use super::braking::Braking;
use super::conduct::Conduct;
use super::during::Rule;
use super::latched::{Latched, Waiting};
use super::look::{Look, Robot};
use super::recovery::Recovering;
use super::violations::Violations;
use crate::figures::Figures;
use crate::scenario::Scenario;
use crate::summary::{DuringSummary, Violation};
use crate::violation::ViolationKind;

/// Watches all robots of a scenario.
#[derive(Debug)]
pub struct Judge {
    /// By number: the robots of the scenario, then clones of them.
    robots: Vec<Conduct>,
    areas: Areas,
    rules: Vec<Rule>,
    /// By number, of the robots.
    braking: Vec<Braking>,
    latched: Vec<Latched>,
    recovering: Vec<Recovering>,
    start_ns: u64,
    violations: Violations,
}

impl Judge {
    /// A judge of a scenario from `start_ns` on. Entering an area without a grant is a violation where grants are `heard`.
    #[must_use]
    pub fn new(scenario: &Scenario, start_ns: u64, heard: bool) -> Self {
        let clone_of =
            |(_, robot): (usize, usize)| Robot::clone_of(scenario, &scenario.robots[robot]);
        let robots: Vec<Conduct> = { scenario.robots.iter() }
            .map(|player| Robot::new(scenario, player))
            .chain(scenario.clones().map(clone_of))
            .map(|robot| Conduct::new(scenario, robot, start_ns))
            .collect();
        Self {
            areas: Areas::new(scenario, robots.len(), heard, start_ns),
            robots,
            rules: Rule::all(scenario, start_ns),
            braking: { scenario.robots.iter() }
                .map(|player| Braking::new(&scenario.faults, player))
                .collect(),
            latched: vec![Latched::default(); scenario.robots.len()],
            recovering: vec![Recovering::new(scenario.recovery()); scenario.robots.len()],
            start_ns,
            violations: Violations::new(start_ns),
        }
    }

    /// Takes in one look at a robot.
    pub fn observe(&mut self, look: &Look<'_>) {
        let Some(robot) = self.robots.get_mut(look.robot) else {
            return;
        };
        let found = &mut self.violations;
        let before = robot.observe(look, found);
        let at_s = look.truth.time_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        let speed_m_s = look.truth.twist.v_m_s.abs();
        let braking = self.braking.get_mut(look.robot);
        if let Some(why) = braking.and_then(|own| own.look(at_s, speed_m_s)) {
            let name = &robot.robot.name;
            found.report(ViolationKind::UnsafeSpeed, name, look.truth.time_ns, why);
        }
        self.areas.judge(&self.robots, look, before, found);
        for rule in &mut self.rules {
            rule.judge(&self.robots, look, before, found);
        }
    }

    /// Takes in what a robot waits for; none: no process of it runs.
    pub fn observe_latch(&mut self, robot: usize, truth: &Truth, waiting: Option<Waiting>) {
        let latched = self.latched.get_mut(robot);
        if let Some(why) = latched.and_then(|own| own.look(truth, waiting)) {
            self.report_of(robot, ViolationKind::UnsafeSpeed, truth.time_ns, why);
        }
    }

    /// Takes in how far a robot is after the last fault; `missing` says what is left of its goals.
    pub fn observe_progress(
        &mut self,
        robot: usize,
        truth: &Truth,
        missing: impl FnOnce(&Figures) -> Option<String>,
    ) {
        let (Some(own), Some(recovering)) =
            (self.robots.get(robot), self.recovering.get_mut(robot))
        else {
            return;
        };
        let at_s = truth.time_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        let stands = truth.twist.v_m_s.abs() < STANDING_M_S;
        if let Some(stuck) = recovering.look(at_s, stands, || missing(own.figures())) {
            let kind = ViolationKind::StuckAfterFaults;
            self.report_of(robot, kind, truth.time_ns, stuck);
        }
    }

    /// A robot was told where to stop.
    pub fn instructed(&mut self, robot: usize, pose: Pose) {
        if let Some(robot) = self.robots.get_mut(robot) {
            robot.instructed(pose);
        }
    }

    /// An operator said that these robots are not in the area, whatever the truth is.
    pub fn cleared(&mut self, area: &str, robots: &[&str]) {
        for (index, own) in self.robots.iter().enumerate() {
            if robots.contains(&own.robot.id.as_str()) {
                self.areas.cleared(area, index);
            }
        }
    }

    /// A violation found elsewhere, such as in a device's records.
    pub fn report(&mut self, kind: ViolationKind, robot: &str, at_ns: u64, detail: String) {
        self.violations.report(kind, robot, at_ns, detail);
    }

    /// The same of the robot with this number.
    pub fn report_of(&mut self, robot: usize, kind: ViolationKind, at_ns: u64, detail: String) {
        let id = { self.robots.get(robot) }.map_or("", |own| own.robot.id.as_str());
        self.violations.report(kind, id, at_ns, detail);
    }

    /// What was found so far.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        self.violations.all()
    }

    /// Areas into which the robot's footprint reaches, by truth.
    #[must_use]
    pub fn inside(&self, robot: usize) -> Vec<&str> {
        self.areas.inside(robot)
    }

    /// What came out of a robot's run so far.
    ///
    /// # Panics
    /// When the scenario has no such robot.
    #[must_use]
    pub fn figures(&self, robot: usize) -> &Figures {
        self.robots[robot].figures()
    }

    /// Largest distance of a robot from its lane's centre so far, in areas that are driven forward on a lane.
    #[must_use]
    pub fn max_lateral_error_m(&self, robot: usize) -> f64 {
        { self.robots.get(robot) }.map_or(0.0, Conduct::max_lateral_error_m)
    }

    /// The same since the last call.
    pub fn take_lateral_error_m(&mut self, robot: usize) -> f64 {
        { self.robots.get_mut(robot) }.map_or(0.0, Conduct::take_lateral_error_m)
    }

    /// What had to be true while something else was.
    #[must_use]
    pub fn rules(&self) -> Vec<DuringSummary> {
        self.rules.iter().map(Rule::summary).collect()
    }
}
