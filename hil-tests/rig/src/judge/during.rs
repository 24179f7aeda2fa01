//! What must be true while something else is.

use sim::world::Truth;

use super::conduct::Conduct;
use super::look::{Look, place};
use super::violations::Violations;
use crate::scenario::{During, Scenario, ScriptedFault, ScriptedKind};
use crate::summary::DuringSummary;
use crate::violation::ViolationKind;

/// Longest time that one look accounts for: after a longer gap nobody knows what was true within it.
const LONGEST_STEP_NS: u64 = 200_000_000;
/// A footprint that must be whole in an area may reach out this far.
const WHOLE_SLACK_M: f64 = 0.005;

/// A rule of a scenario, watched.
#[derive(Debug)]
pub(super) struct Rule {
    rule: During,
    robot: usize,
    other: usize,
    /// From when on the other one is carried away, if it is.
    gone_ns: Option<u64>,
    /// The other one has gone over to another mediator, which let it go: nothing is asked of it before a coordination has it in its area
    /// again.
    let_go: bool,
    checked_ns: u64,
    broken_ns: u64,
}

impl Rule {
    /// Those of a scenario that begins at this time.
    pub(super) fn all(scenario: &Scenario, start_ns: u64) -> Vec<Self> {
        let gone_ns = |id: &str| {
            let carried = |fault: &&ScriptedFault| {
                fault.what == ScriptedKind::Absent && fault.robot.as_deref() == Some(id)
            };
            let first = { scenario.faults.iter().filter(carried) }.map(|fault| fault.at_s);
            first
                .min_by(f64::total_cmp)
                .map(|at_s| start_ns + (at_s * 1e9) as u64)
        };
        { scenario.during.iter() }
            .filter_map(|rule| {
                Some(Self {
                    robot: scenario.player(&rule.robot)?,
                    other: scenario.player(&rule.other)?,
                    gone_ns: gone_ns(&rule.other),
                    rule: rule.clone(),
                    let_go: false,
                    checked_ns: 0,
                    broken_ns: 0,
                })
            })
            .collect()
    }

    /// How long it was checked and broken.
    pub(super) fn summary(&self) -> DuringSummary {
        DuringSummary {
            rule: self.rule.rule(),
            checked_s: self.checked_ns as f64 / 1e9,
            broken_s: self.broken_ns as f64 / 1e9,
        }
    }

    /// Takes in one look at a robot; `before` is the truth at the look before, if there was one.
    pub(super) fn judge(
        &mut self,
        robots: &[Conduct],
        look: &Look<'_>,
        before: Option<Truth>,
        violations: &mut Violations,
    ) {
        let (rule, truth) = (&self.rule, look.truth);
        let at_m = [truth.pose.x_m, truth.pose.y_m];
        let coordinated = || {
            { rule.coordination.as_ref() }
                .is_none_or(|own| look.observations.coordinated(&own.net, truth.time_ns))
        };
        if self.robot != look.robot {
            return;
        }
        let other = &robots[self.other];
        let is_whole = || {
            other.truth.is_some_and(|truth| {
                let body = other.robot.footprint.at(&truth.pose);
                let room = rule.other_area.region.grown(WHOLE_SLACK_M);
                let mut corners = body.corners_m.iter();
                corners.all(|&corner| room.contains(corner.into()))
            })
        };
        if rule.coordination.is_some() {
            let apart = look
                .observations
                .follow_different_mediators([&rule.robot, &rule.other]);
            let control = look.observations.control_of(&rule.other, truth.time_ns);
            self.let_go = apart || self.let_go && !(control.is_some() && is_whole());
        }
        if self.let_go {
            return;
        }
        if self.gone_ns.is_some_and(|gone_ns| truth.time_ns >= gone_ns) {
            return;
        }
        if !rule.area.region.contains(at_m.into()) || !coordinated() {
            return;
        }
        let step_ns = before.map_or(0, |before| truth.time_ns.saturating_sub(before.time_ns));
        let step_ns = step_ns.min(LONGEST_STEP_NS);
        self.checked_ns += step_ns;
        if !is_whole() {
            self.broken_ns += step_ns;
            let place = { other.truth }.map_or(String::new(), |truth| {
                format!("; it is {}", place(&truth.pose))
            });
            let detail = format!("expected that {}{place}", rule.rule());
            violations.report(
                ViolationKind::During,
                &other.robot.name,
                truth.time_ns,
                detail,
            );
        }
    }
}
