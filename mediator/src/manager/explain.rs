//! Why a robot waits, and how everything stands.

use std::fmt::Write;

use super::Manager;
use super::robot::Robot;
use crate::nets::{Instance, Kind, Stage};
use serde::{Deserialize, Serialize};

/// An area, for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AreaStatus {
    /// Its id.
    pub id: String,
    /// How many robots it holds.
    pub capacity: u32,
    /// Of the last grant.
    pub fence: u64,
    /// Robots that hold it, with the fence of their grant.
    pub holders: Vec<(String, u64)>,
    /// Robots that are in it without holding it, or were when they fell silent.
    pub standing: Vec<String>,
    /// Robots for which a coordination keeps it.
    pub kept_for: Vec<String>,
    /// Robots that wait for it, in order.
    pub waiting: Vec<String>,
    /// A silent robot occupies it.
    pub blocked: bool,
    /// Nobody is let in.
    pub closed: bool,
}

/// A robot, for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotStatus {
    /// Its id.
    pub id: String,
    /// By the site file.
    pub role: String,
    /// Counts its boots; 0: never heard of.
    pub session: u64,
    /// It is heard.
    pub heard: bool,
    /// It knows where it is.
    pub located: bool,
    /// Milliseconds since it was heard.
    pub age_ms: u64,
    /// Areas it holds.
    pub holds: Vec<String>,
    /// Areas it waits for, each with the reason.
    pub waits: Vec<(String, String)>,
    /// Why a process that speaks for it was refused.
    pub refusal: String,
}

/// No such robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no robot `{found}`; this site has {known}")]
pub struct UnknownRobot {
    /// As asked for.
    pub found: String,
    /// All there are.
    pub known: String,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// How often the mediator has started.
    pub epoch: u64,
    /// Robots that must report before anything is granted.
    pub awaited: Vec<String>,
    /// Areas, in the order of the site file.
    pub areas: Vec<AreaStatus>,
    /// Robots, in the order of the site file.
    pub robots: Vec<RobotStatus>,
    /// Coordinations: the last ones that are over, then those that run.
    pub coordinations: Vec<CoordinationStatus>,
}

/// A coordination, for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CoordinationStatus {
    /// Its number.
    pub number: u64,
    /// Its id in the site file.
    pub id: String,
    /// The net.
    pub net: String,
    /// In which situation it began; empty: its robots are told to get out of the way.
    pub situation: String,
    /// Roles of the net and the robots that play them.
    pub robots: Vec<(String, String)>,
    /// The marked places.
    pub marking: Vec<String>,
    /// The last transitions that fired, each with the milliseconds since its start.
    pub firings: Vec<(String, u64)>,
    /// How many have fired.
    pub fired: u64,
    /// By role: what its robot waits for.
    pub waits: Vec<String>,
    /// Milliseconds from its start, or since the mediator's, to now or to its end.
    pub age_ms: u64,
    /// Milliseconds since a flag was set.
    pub still_ms: u64,
    /// It is over.
    pub over: bool,
}

impl Manager {
    /// How everything stands.
    #[must_use]
    pub fn status(&self, now_ns: u64) -> Status {
        let name = |robot: usize| self.robots[robot].id.clone();
        let areas = self.areas.iter().enumerate().map(|(index, area)| {
            let holds = |robot: &usize| self.robots[*robot].holds(index);
            let fence = |robot: usize| self.robots[robot].run(index).map_or(0, |run| run.fence);
            AreaStatus {
                id: area.id.clone(),
                capacity: area.capacity,
                fence: area.fence,
                holders: self
                    .occupants(index)
                    .filter(holds)
                    .map(|robot| (name(robot), fence(robot)))
                    .collect(),
                standing: self
                    .occupants(index)
                    .filter(|robot| !holds(robot))
                    .map(name)
                    .collect(),
                kept_for: { self.coordinator.kept(index).into_iter() }
                    .map(name)
                    .collect(),
                waiting: area.queue.iter().map(|&robot| name(robot)).collect(),
                blocked: self
                    .occupants(index)
                    .any(|robot| !self.robots[robot].is_heard()),
                closed: self.is_closed(index),
            }
        });
        let robots = self.robots.iter().enumerate().map(|(index, robot)| {
            let ids = |areas: Vec<usize>| -> Vec<String> {
                areas
                    .into_iter()
                    .map(|area| self.areas[area].id.clone())
                    .collect()
            };
            RobotStatus {
                id: robot.id.clone(),
                role: robot.role.clone(),
                session: robot.session,
                heard: robot.is_heard(),
                located: robot.located,
                age_ms: now_ns.saturating_sub(robot.heard_ns) / 1_000_000,
                holds: ids((0..self.areas.len())
                    .filter(|&area| robot.holds(area))
                    .collect()),
                waits: self
                    .waits_for(index)
                    .into_iter()
                    .map(|area| {
                        let why = self.explain(index, area, now_ns);
                        (self.areas[area].id.clone(), why)
                    })
                    .collect(),
                refusal: robot
                    .refused
                    .as_ref()
                    .map_or_else(String::new, |(_, why)| why.clone()),
            }
        });
        Status {
            epoch: self.epoch,
            awaited: self.awaited.iter().map(|&robot| name(robot)).collect(),
            areas: areas.collect(),
            robots: robots.collect(),
            coordinations: { self.coordinator.over.iter().cloned() }
                .chain(
                    { self.coordinator.instances() }
                        .map(|instance| self.coordination_status(instance, now_ns)),
                )
                .collect(),
        }
    }

    pub(super) fn coordination_status(
        &self,
        instance: &Instance,
        now_ns: u64,
    ) -> CoordinationStatus {
        let name = |robot: usize| self.robots[robot].id.clone();
        let ms = |from_ns: u64, to_ns: u64| to_ns.saturating_sub(from_ns) / 1_000_000;
        let roles = instance.plan.roles.iter().zip(&instance.parts);
        CoordinationStatus {
            number: instance.number,
            id: instance.plan.id.clone(),
            net: instance.plan.net.clone(),
            situation: match instance.stage {
                Stage::Running { situation, .. } => {
                    instance.plan.situations[situation].name.clone()
                }
                Stage::Yielding => String::new(),
            },
            robots: roles
                .map(|(role, part)| (role.name.clone(), name(part.robot)))
                .collect(),
            marking: instance.marking(),
            firings: { instance.firings.iter() }
                .map(|firing| {
                    let at_ms = ms(instance.since_ns, firing.at_ns);
                    (firing.transition.clone(), at_ms)
                })
                .collect(),
            fired: instance.fired,
            waits: (0..instance.parts.len())
                .map(|role| instance.why(role, name))
                .collect(),
            age_ms: ms(instance.since_ns, now_ns),
            still_ms: ms(instance.progress_ns, now_ns),
            over: false,
        }
    }

    /// Why a robot waits, a sentence for each area that it has asked for.
    ///
    /// # Errors
    /// [`UnknownRobot`] when the site has no such robot.
    pub fn why(&self, robot_id: &str, now_ns: u64) -> Result<String, UnknownRobot> {
        let Some(&robot) = self.robot_index.get(robot_id) else {
            let known: Vec<&str> = self.robots.iter().map(|robot| robot.id.as_str()).collect();
            return Err(UnknownRobot {
                found: robot_id.to_owned(),
                known: known.join(", "),
            });
        };
        let state = &self.robots[robot];
        let mut lines: Vec<String> = self
            .waits_for(robot)
            .into_iter()
            .map(|area| {
                let why = self.explain(robot, area, now_ns);
                format!("{robot_id} waits for area {} {why}", self.areas[area].id)
            })
            .collect();
        if let Some((instance, role)) = self.coordinator.control_of(robot) {
            let name = |robot: usize| self.robots[robot].id.clone();
            lines.push(format!(
                "{robot_id} takes part in coordination {} as {}: {}",
                instance.plan.id,
                instance.plan.roles[role].name,
                instance.why(role, name)
            ));
        }
        if lines.is_empty() {
            lines.push(match (state.session, state.is_heard()) {
                (0, _) => format!("{robot_id} was never heard of"),
                (_, false) => format!("{robot_id} is silent, and waits for nothing"),
                (_, true) => format!("{robot_id} waits for nothing"),
            });
        }
        Ok(lines.join("\n"))
    }

    /// In a sentence, why a robot that has asked for an area was not granted it.
    pub(super) fn explain(&self, robot: usize, area: usize, now_ns: u64) -> String {
        let name = |robot: usize| self.robots[robot].id.as_str();
        let state = &self.robots[robot];
        let asked_ns = state.run(area).map_or(now_ns, |run| run.asked_ns);
        let since_s = now_ns.saturating_sub(asked_ns) as f64 * 1e-9;
        let mut text = format!("for {since_s:.1} s: ");
        if !self.awaited.is_empty() {
            let awaited: Vec<&str> = self.awaited.iter().map(|&robot| name(robot)).collect();
            text += &format!(
                "nothing is granted until {} has reported or its areas are cleared",
                awaited.join(", ")
            );
            return text;
        }
        if !state.is_heard() {
            return text + "the robot itself is silent";
        }
        if !state.located {
            return text + "the robot itself does not know where it is";
        }
        let kept = self.coordinator.kept(area);
        if !kept.contains(&robot) && !state.stands_in.contains(&area) {
            if let Some(why) = self.explain_net(robot, area) {
                return text + &why;
            }
            if let Some(&other) = kept
                .iter()
                .find(|&&other| !self.robots[other].occupies(area))
            {
                return text + &format!("a coordination keeps it for {}", name(other));
            }
        }
        let before = text.len();
        // A string takes everything, so nothing is lost here.
        let mut add = |reason: std::fmt::Arguments<'_>| {
            if text.len() > before {
                text.push_str(", ");
            }
            let _ = text.write_fmt(reason);
        };
        for other in self.occupants(area).filter(|&other| other != robot) {
            let it = &self.robots[other];
            let (id, silent) = (&it.id, if it.is_heard() { "" } else { ", silent" });
            match it.run(area) {
                _ if it.intrudes(area) => add(format_args!("{id} (in it without a grant{silent})")),
                Some(run) if run.is_entered() => {
                    add(format_args!("{id} (in it, fence {}{silent})", run.fence));
                }
                Some(run) if run.is_held() => {
                    add(format_args!("{id} (granted, fence {}{silent})", run.fence));
                }
                _ => add(format_args!("{id} (standing there{silent})")),
            }
        }
        let ahead = { self.areas[area].queue.iter() }.take_while(|&&other| other != robot);
        for &other in ahead {
            let Robot { id, role, .. } = &self.robots[other];
            add(format_args!("{id} ({role}, asked before it or goes first)"));
        }
        if text.len() == before {
            text.push_str("it is about to be granted");
        }
        text
    }

    /// Why no net lets a robot into an area, if nothing else could.
    fn explain_net(&self, robot: usize, area: usize) -> Option<String> {
        let name = |robot: usize| self.robots[robot].id.clone();
        if let Some((instance, role)) = self.coordinator.control_of(robot) {
            return Some(format!(
                "coordination {} has its discrete control, and gives it only areas of its orders; {}",
                instance.plan.id,
                instance.why(role, name)
            ));
        }
        let plan = &self.coordinator.plans[self.coordinator.governed[area]?];
        let instance = { self.coordinator.instances() }.find(|own| own.plan.id == plan.id);
        let Some(instance) = instance else {
            let inside = plan.governed.iter().flat_map(|&area| {
                let occupants = self.occupants(area);
                occupants.map(move |other| format!("{} in {}", name(other), self.areas[area].id))
            });
            let inside: Vec<String> = inside.collect();
            return Some(format!(
                "net {} decides, which starts when its areas are empty: {}",
                plan.net,
                inside.join(", ")
            ));
        };
        let role = instance.parts.iter().position(|part| part.robot == robot);
        let role = role.filter(|&role| matches!(plan.roles[role].kind, Kind::Access(_)));
        Some(match role {
            Some(role) => instance.why(role, name),
            None => format!("net {} decides, in which it has no role", plan.net),
        })
    }
}
