//! What must be true while something else is.

use sim::world::{Footprint, Truth};

use super::violations::Violations;
use crate::network::observations::Observations;
use crate::scenario::{During, Scenario};
use crate::shapes;
use crate::summary::DuringSummary;

/// The world's records of a robot are never farther apart, unless nobody looked at it.
const LONGEST_STEP_NS: u64 = 200_000_000;
/// A footprint that must be whole in an area may reach out this far.
const WHOLE_SLACK_M: f64 = 0.005;

/// Watches the rules of a scenario.
#[derive(Debug)]
pub(super) struct Rules {
    rules: Vec<Rule>,
    robots: Vec<Robot>,
}

#[derive(Debug)]
struct Robot {
    id: String,
    footprint: Footprint,
    truth: Option<Truth>,
}

#[derive(Debug)]
struct Rule {
    rule: During,
    robot: usize,
    other: usize,
    checked_ns: u64,
    broken_ns: u64,
}

impl Rules {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let rules = { scenario.during.iter() }
            .filter_map(|rule| {
                Some(Rule {
                    robot: scenario.player(&rule.robot)?,
                    other: scenario.player(&rule.other)?,
                    rule: rule.clone(),
                    checked_ns: 0,
                    broken_ns: 0,
                })
            })
            .collect();
        let robots = { scenario.robots.iter() }
            .map(|player| Robot {
                id: player.id.clone(),
                footprint: shapes::footprint(&player.config),
                truth: None,
            })
            .collect();
        Self { rules, robots }
    }

    /// How long each was checked and broken.
    pub(super) fn summary(&self) -> Vec<DuringSummary> {
        { self.rules.iter() }
            .map(|rule| DuringSummary {
                rule: rule.rule.rule(),
                checked_s: rule.checked_ns as f64 / 1e9,
                broken_s: rule.broken_ns as f64 / 1e9,
            })
            .collect()
    }

    pub(super) fn judge(
        &mut self,
        robot: usize,
        truth: &Truth,
        observations: &Observations,
        violations: &mut Violations,
    ) {
        let before = self.robots[robot].truth.replace(*truth);
        let step_ns = before.map_or(0, |before| truth.time_ns.saturating_sub(before.time_ns));
        let step_ns = step_ns.min(LONGEST_STEP_NS);
        for rule in &mut self.rules {
            let at_m = [truth.pose.x_m, truth.pose.y_m];
            let applies = rule.robot == robot && rule.rule.area.region.contains(at_m.into()) && {
                rule.rule.coordination.as_ref()
            }
            .is_none_or(|own| observations.coordinated(&own.net, truth.time_ns));
            if !applies {
                continue;
            }
            rule.checked_ns += step_ns;
            let other = &self.robots[rule.other];
            let is_whole = other.truth.is_some_and(|truth| {
                let body = other.footprint.at(&truth.pose);
                let room = rule.rule.other_area.region.grown(WHOLE_SLACK_M);
                body.corners_m
                    .iter()
                    .all(|&corner| room.contains(corner.into()))
            });
            if !is_whole {
                rule.broken_ns += step_ns;
                let place = other.truth.map_or(String::new(), |truth| {
                    format!(
                        "; it is at x = {:.2} m, y = {:.2} m",
                        truth.pose.x_m, truth.pose.y_m
                    )
                });
                let detail = format!("expected that {}{place}", rule.rule.rule());
                violations.report("during", &other.id, truth.time_ns, detail);
            }
        }
    }
}
