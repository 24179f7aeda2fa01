//! The judge of a fleet: the world's truth against what an independent listener heard.
//!
//! It sees poses of the world, the site's map, and what everybody said on the network; it asks neither robots nor mediator.

pub mod conduct;
mod figures;
mod overlap;
mod owners;
mod stops;
pub mod view;

use std::collections::BTreeMap;

use config::Rect;
use sim::world::{Footprint, Pose, Rectangle, Truth};

use crate::network::observations::Book;
use crate::one_robot::summary::Violation;
use crate::scenario::{During, Scenario};
use crate::summary::DuringSummary;

pub use conduct::{Look, Rules};
pub use figures::Figures;
pub use owners::two_owners;
pub(crate) use stops::region;
pub use stops::{StopError, StopKind};

/// A footprint may reach so far over a border: about what a robot does not know of its place.
const REACH_IN_M: f64 = 0.02;
/// Messages are heard by so much sooner or later than they are heard by those they are for.
const HEARING_NS: u64 = 100_000_000;
/// Kinds of violation are reported once for each stretch of time that they last.
const STRETCH_S: f64 = 1.0;
/// The world's records of a robot are never farther apart, unless it was not looked after.
const LONGEST_STEP_NS: u64 = 200_000_000;
/// Of a footprint that is to be whole in an area.
const WHOLE_SLACK_M: f64 = 0.005;

/// Watches a fleet.
#[derive(Debug)]
pub struct Judge {
    areas: Vec<Area>,
    robots: Vec<Watched>,
    rules: Vec<Rule>,
    least_clearance_m: f64,
    start_ns: u64,
    last: BTreeMap<(String, String), f64>,
    violations: Vec<Violation>,
}

#[derive(Debug)]
struct Area {
    id: String,
    capacity: usize,
    /// Less what a footprint may reach in.
    inner: Rectangle,
}

#[derive(Debug)]
struct Watched {
    id: String,
    footprint: Footprint,
    truth: Option<Truth>,
    /// By area.
    presence: Vec<Presence>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Presence {
    inside: bool,
    /// It stands there since before anybody could have granted it.
    excused: bool,
    /// An operator said that it is not there any more.
    cleared: bool,
    /// Since when it is inside without a grant.
    without_ns: Option<u64>,
}

#[derive(Debug)]
struct Rule {
    rule: During,
    robot: usize,
    other: usize,
    checked_ns: u64,
    broken_ns: u64,
}

impl Judge {
    /// A judge of a scenario from `start_ns` on.
    #[must_use]
    pub fn new(scenario: &Scenario, start_ns: u64) -> Self {
        let areas: Vec<Area> = { scenario.site.areas.iter() }
            .map(|area| Area {
                id: area.id.clone(),
                capacity: area.capacity as usize,
                inner: shrunk(&area.region, REACH_IN_M),
            })
            .collect();
        let robots = { scenario.robots.iter() }
            .map(|player| {
                let own = &player.config.footprint;
                Watched {
                    id: player.id.clone(),
                    footprint: Footprint {
                        front_m: own.front_m,
                        rear_m: own.rear_m,
                        left_m: own.left_m,
                        right_m: own.right_m,
                    },
                    truth: None,
                    presence: vec![Presence::default(); areas.len()],
                }
            })
            .collect();
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
        Self {
            areas,
            robots,
            rules,
            least_clearance_m: scenario.least_clearance_m,
            start_ns,
            last: BTreeMap::new(),
            violations: Vec::new(),
        }
    }

    /// Takes in what is true of a robot, and what was heard until now.
    pub fn observe(&mut self, robot: usize, truth: &Truth, book: &Book) {
        let Some(watched) = self.robots.get_mut(robot) else {
            return;
        };
        let before = watched.truth.replace(*truth);
        self.judge_contact(robot, truth, before.as_ref());
        self.judge_areas(robot, truth, before.is_none(), book);
        let step_ns = before.map_or(0, |before| truth.time_ns.saturating_sub(before.time_ns));
        self.judge_rules(robot, truth, step_ns.min(LONGEST_STEP_NS), book);
    }

    /// An operator said that these robots are not in the area, whatever the truth is.
    pub fn cleared(&mut self, area: &str, robots: &[&str]) {
        let index = self.areas.iter().position(|own| own.id == area);
        for watched in &mut self.robots {
            if let Some(presence) = index.and_then(|index| watched.presence.get_mut(index))
                && robots.contains(&watched.id.as_str())
            {
                presence.cleared = true;
            }
        }
    }

    /// A violation found elsewhere, such as in a device's records.
    pub fn report(&mut self, kind: &str, robot: &str, at_ns: u64, detail: String) {
        let at_s = at_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        let key = (kind.to_owned(), robot.to_owned());
        let before = self.last.insert(key, at_s);
        if before.is_none_or(|before_s| at_s > before_s + STRETCH_S) {
            self.violations.push(Violation {
                kind: kind.to_owned(),
                robot: robot.to_owned(),
                at_s,
                detail,
            });
        }
    }

    /// What was found so far.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        &self.violations
    }

    /// Areas into which the robot's footprint reaches, by truth.
    #[must_use]
    pub fn inside(&self, robot: usize) -> Vec<&str> {
        let presence = self.robots.get(robot).map(|watched| &watched.presence);
        { presence.into_iter().flatten() }
            .zip(&self.areas)
            .filter(|(presence, _)| presence.inside)
            .map(|(_, area)| area.id.as_str())
            .collect()
    }

    /// What had to be true while something else was.
    #[must_use]
    pub fn rules(&self) -> Vec<DuringSummary> {
        let rules = self.rules.iter();
        rules
            .map(|rule| DuringSummary {
                rule: rule.rule.rule(),
                checked_s: rule.checked_ns as f64 / 1e9,
                broken_s: rule.broken_ns as f64 / 1e9,
            })
            .collect()
    }

    fn judge_contact(&mut self, robot: usize, truth: &Truth, before: Option<&Truth>) {
        let id = self.robots[robot].id.clone();
        let (x_m, y_m) = (truth.pose.x_m, truth.pose.y_m);
        if truth.collisions > before.map_or(0, |before| before.collisions) {
            let detail = format!("at x = {x_m:.2} m, y = {y_m:.2} m");
            self.report("collision", &id, truth.time_ns, detail);
        } else if truth.clearance_m < self.least_clearance_m {
            let detail = format!(
                "{:.3} m at x = {x_m:.2} m, y = {y_m:.2} m, expected at least {} m",
                truth.clearance_m, self.least_clearance_m
            );
            self.report("clearance", &id, truth.time_ns, detail);
        }
    }

    fn judge_areas(&mut self, robot: usize, truth: &Truth, first: bool, book: &Book) {
        let watched = &mut self.robots[robot];
        let body = watched.footprint.at(&truth.pose);
        let id = watched.id.clone();
        let mut found = Vec::new();
        for (area, presence) in self.areas.iter().zip(&mut watched.presence) {
            presence.inside = body.distance_to_rectangle_m(&area.inner) <= 0.0;
            presence.excused &= presence.inside;
            presence.cleared &= presence.inside;
            presence.excused |= first && presence.inside;
            if !presence.inside {
                presence.without_ns = None;
                continue;
            }
            if book.had(&id, &area.id, truth.time_ns, HEARING_NS) {
                presence.excused = false;
                presence.without_ns = None;
                continue;
            }
            if presence.excused || presence.cleared {
                continue;
            }
            let since_ns = *presence.without_ns.get_or_insert(truth.time_ns);
            if truth.time_ns - since_ns > HEARING_NS
                && !book.had(&id, &area.id, since_ns, HEARING_NS)
            {
                let detail = format!(
                    "in area {} by more than {REACH_IN_M} m, at x = {:.2} m, y = {:.2} m, and it has no grant",
                    area.id, truth.pose.x_m, truth.pose.y_m
                );
                found.push(("entry-without-grant", since_ns, detail));
            }
        }
        for (number, area) in self.areas.iter().enumerate() {
            if !self.robots[robot].presence[number].inside {
                continue;
            }
            let inside: Vec<&str> = { self.robots.iter() }
                .filter(|other| other.presence[number].inside)
                .map(|other| other.id.as_str())
                .collect();
            if inside.len() > area.capacity {
                let detail = format!(
                    "{} are in area {}, which holds {}",
                    inside.join(", "),
                    area.id,
                    area.capacity
                );
                found.push(("over-capacity", truth.time_ns, detail));
            }
        }
        for (kind, at_ns, detail) in found {
            self.report(kind, &id, at_ns, detail);
        }
    }

    fn judge_rules(&mut self, robot: usize, truth: &Truth, step_ns: u64, book: &Book) {
        let mut found = Vec::new();
        for rule in &mut self.rules {
            let at_m = [truth.pose.x_m, truth.pose.y_m];
            let applies = rule.robot == robot && rule.rule.area.region.contains(at_m) && {
                rule.rule.coordination.as_ref()
            }
            .is_none_or(|own| book.coordinated(&own.net, truth.time_ns));
            if !applies {
                continue;
            }
            rule.checked_ns += step_ns;
            let other = &self.robots[rule.other];
            let is_whole = other.truth.is_some_and(|truth| {
                let body = other.footprint.at(&truth.pose);
                let room = grown(&rule.rule.other_area.region, WHOLE_SLACK_M);
                body.corners_m.iter().all(|&corner| room.contains(corner))
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
                found.push((other.id.clone(), detail));
            }
        }
        for (other, detail) in found {
            self.report("during", &other, truth.time_ns, detail);
        }
    }
}

fn shrunk(region: &Rect, by_m: f64) -> Rectangle {
    let size = |axis: usize| (region.max_m[axis] - region.min_m[axis] - 2.0 * by_m).max(0.0);
    let middle = |axis: usize| 0.5 * (region.max_m[axis] + region.min_m[axis]);
    Rectangle::centred(&Pose::new(middle(0), middle(1), 0.0), size(0), size(1))
}

fn grown(region: &Rect, by_m: f64) -> Rect {
    Rect {
        min_m: region.min_m.map(|value| value - by_m),
        max_m: region.max_m.map(|value| value + by_m),
    }
}

#[cfg(test)]
mod tests;
