//! Who is in which area by truth, against the grants that an independent listener heard.

use description::geometry::Rect;
use sim::world::{Footprint, Pose, Rectangle, Truth};

use super::violations::Violations;
use crate::network::observations::Observations;
use crate::scenario::Scenario;
use crate::shapes;

/// A footprint may reach this far over a border: about what a robot does not know of its place.
const REACH_IN_M: f64 = 0.02;
/// Messages are heard at most this much sooner or later than by those they are for.
const HEARING_NS: u64 = 100_000_000;

/// Watches the areas of a site.
#[derive(Debug)]
pub(super) struct Areas {
    areas: Vec<Area>,
    robots: Vec<Robot>,
    /// Whether grants are heard at all.
    heard: bool,
}

#[derive(Debug)]
struct Area {
    id: String,
    capacity: usize,
    /// Less what a footprint may reach in.
    inner: Rectangle,
}

#[derive(Debug)]
struct Robot {
    id: String,
    footprint: Footprint,
    seen: bool,
    /// By area.
    presence: Vec<Presence>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Presence {
    inside: bool,
    /// It has stood there since before anybody could have granted it.
    excused: bool,
    /// An operator said that it is not there any more.
    cleared: bool,
    /// Since when it has been inside without a grant.
    without_ns: Option<u64>,
}

impl Areas {
    /// Those of a scenario; grants are judged where they are `heard`.
    pub(super) fn new(scenario: &Scenario, heard: bool) -> Self {
        let areas: Vec<Area> = { scenario.site.areas.iter() }
            .map(|area| Area {
                id: area.id.clone(),
                capacity: area.capacity as usize,
                inner: shrunk(&area.region, REACH_IN_M),
            })
            .collect();
        let robots = { scenario.robots.iter() }
            .map(|player| Robot {
                id: player.id.clone(),
                footprint: shapes::footprint(&player.config),
                seen: false,
                presence: vec![Presence::default(); areas.len()],
            })
            .collect();
        Self {
            areas,
            robots,
            heard,
        }
    }

    /// An operator said that these robots are not in the area, whatever the truth is.
    pub(super) fn cleared(&mut self, area: &str, robots: &[&str]) {
        let index = self.areas.iter().position(|own| own.id == area);
        for robot in &mut self.robots {
            if let Some(presence) = index.and_then(|index| robot.presence.get_mut(index))
                && robots.contains(&robot.id.as_str())
            {
                presence.cleared = true;
            }
        }
    }

    /// Areas into which the robot's footprint reaches, by truth.
    pub(super) fn inside(&self, robot: usize) -> Vec<&str> {
        let presence = self.robots.get(robot).map(|robot| &robot.presence);
        { presence.into_iter().flatten() }
            .zip(&self.areas)
            .filter(|(presence, _)| presence.inside)
            .map(|(_, area)| area.id.as_str())
            .collect()
    }

    pub(super) fn judge(
        &mut self,
        robot: usize,
        truth: &Truth,
        observations: &Observations,
        violations: &mut Violations,
    ) {
        let watched = &mut self.robots[robot];
        let first = !std::mem::replace(&mut watched.seen, true);
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
            if !self.heard {
                continue;
            }
            if observations.had(&id, &area.id, truth.time_ns, HEARING_NS) {
                presence.excused = false;
                presence.without_ns = None;
                continue;
            }
            if presence.excused || presence.cleared {
                continue;
            }
            let since_ns = *presence.without_ns.get_or_insert(truth.time_ns);
            if truth.time_ns - since_ns > HEARING_NS
                && !observations.had(&id, &area.id, since_ns, HEARING_NS)
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
            violations.report(kind, &id, at_ns, detail);
        }
    }
}

fn shrunk(region: &Rect, by_m: f64) -> Rectangle {
    let size =
        |axis: usize| (region.max.xy_m()[axis] - region.min.xy_m()[axis] - 2.0 * by_m).max(0.0);
    let middle = |axis: usize| 0.5 * (region.max.xy_m()[axis] + region.min.xy_m()[axis]);
    Rectangle::centred(&Pose::new(middle(0), middle(1), 0.0), size(0), size(1))
}
