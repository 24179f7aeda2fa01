//! Binds skills to the states of a machine.

use super::{
    Controller, ControllerSetup, MonitorSetup, Schedule, ScheduleError, SkillSetup, StateSetup,
};
use crate::control::{EndOfLane, TurnDirection};
use crate::map::SemanticMap;
use crate::monitors::Monitor;
use coordination::fsm::{Machine, StateId};
use std::collections::VecDeque;

/// One schedule for each state of the machine, by [`StateId::index`].
pub fn compile(
    map: &SemanticMap,
    machine: &Machine,
    states: &[StateSetup],
    skills: &[SkillSetup],
    monitors: &[MonitorSetup],
    max_speed_m_s: f64,
) -> Result<Vec<Schedule>, ScheduleError> {
    let compiler = Compiler {
        map,
        machine,
        skills,
        monitors,
        max_speed_m_s,
        bound: bind(map, machine, states, skills)?,
    };
    machine
        .states()
        .map(|(state, name)| compiler.schedule(state, name))
        .collect()
}

/// Skill and area of a state.
#[derive(Clone, Copy)]
struct Bound {
    skill: usize,
    area: Option<usize>,
    lane: Option<usize>,
}

struct Compiler<'a> {
    map: &'a SemanticMap,
    machine: &'a Machine,
    skills: &'a [SkillSetup],
    monitors: &'a [MonitorSetup],
    max_speed_m_s: f64,
    bound: Vec<Bound>,
}

fn bind(
    map: &SemanticMap,
    machine: &Machine,
    states: &[StateSetup],
    skills: &[SkillSetup],
) -> Result<Vec<Bound>, ScheduleError> {
    let unknown = |state: &StateSetup, wanted, name: &str| ScheduleError::Unknown {
        kind: "state",
        id: state.name.clone(),
        wanted,
        name: name.to_owned(),
    };
    for state in states {
        if machine.state_id(&state.name).is_none() {
            return Err(unknown(state, "state of the machine", &state.name));
        }
    }
    let bind_one = |name: &str| {
        let mut described = states.iter().filter(|state| state.name == name);
        let (Some(state), None) = (described.next(), described.next()) else {
            return Err(ScheduleError::State {
                state: name.to_owned(),
                found: states.iter().filter(|state| state.name == name).count(),
            });
        };
        let skill = skills
            .iter()
            .position(|skill| skill.id == state.skill)
            .ok_or_else(|| unknown(state, "skill", &state.skill))?;
        let area = match &state.area {
            None => None,
            Some(id) => Some(
                map.area_index(id)
                    .ok_or_else(|| unknown(state, "area", id))?,
            ),
        };
        let lane = area.and_then(|area| map.areas()[area].lane);
        Ok(Bound { skill, area, lane })
    };
    machine.states().map(|(_, name)| bind_one(name)).collect()
}

impl Compiler<'_> {
    fn schedule(&self, state: StateId, name: &str) -> Result<Schedule, ScheduleError> {
        let bound = self.bound[state.index()];
        let skill = &self.skills[bound.skill];
        let area = bound.area.map(|area| &self.map.areas()[area]);
        let (controller, lane, end_lane) = self.controller(state, name, skill)?;
        let features = skill.tracks.union(skill.searches);
        Ok(Schedule {
            skill: bound.skill,
            area: bound.area,
            lane,
            end_lane,
            tracks: skill.tracks,
            features,
            controller,
            monitors: self.monitors_of(skill)?,
            speed_limit_m_s: area.map_or(self.max_speed_m_s, |area| {
                area.speed_limit_m_s.min(self.max_speed_m_s)
            }),
            deviation_limit_m: area.map_or(f64::INFINITY, |area| area.deviation_limit_m),
        })
    }

    fn monitors_of(&self, skill: &SkillSetup) -> Result<Vec<Monitor>, ScheduleError> {
        let find = |name: &String| {
            let monitor = self.monitors.iter().find(|monitor| monitor.id == *name);
            let monitor = monitor.ok_or_else(|| ScheduleError::Unknown {
                kind: "skill",
                id: skill.id.clone(),
                wanted: "monitor",
                name: name.clone(),
            })?;
            Ok(Monitor::new(monitor.event, monitor.kind))
        };
        skill.monitors.iter().map(find).collect()
    }

    /// The controller with the lane it drives on and the lane whose end it looks for.
    fn controller(
        &self,
        state: StateId,
        name: &str,
        skill: &SkillSetup,
    ) -> Result<(Controller, Option<usize>, Option<usize>), ScheduleError> {
        let lane = self.bound[state.index()].lane;
        let no_lane = |wanted| ScheduleError::NoLane {
            state: name.to_owned(),
            wanted,
        };
        match &skill.controller {
            ControllerSetup::Stop => Ok((Controller::Stop, lane, lane)),
            ControllerSetup::Corridor { .. } => {
                let lane = lane.ok_or_else(|| no_lane("a lane"))?;
                Ok((Controller::Corridor, Some(lane), Some(lane)))
            }
            &ControllerSetup::EndOfLane {
                distance_m,
                exit_speed_m_s,
            } => {
                positive(skill, "distance", distance_m)?;
                let lane = lane.ok_or_else(|| no_lane("a lane"))?;
                if self.map.lanes()[lane].end.is_none() {
                    return Err(no_lane("a lane that a wall closes"));
                }
                let exit_speed_m_s = exit_speed_m_s.unwrap_or_else(|| self.exit_speed(state));
                if !(exit_speed_m_s.is_finite() && exit_speed_m_s >= 0.0) {
                    return Err(ScheduleError::Parameter {
                        skill: skill.id.clone(),
                        what: "exit speed",
                        expected: "zero or more",
                        found: exit_speed_m_s,
                    });
                }
                let controller = Controller::EndOfLane(EndOfLane {
                    distance_m,
                    exit_speed_m_s,
                });
                Ok((controller, Some(lane), Some(lane)))
            }
            &ControllerSetup::UTurn {
                direction,
                radius_m,
            } => {
                positive(skill, "radius", radius_m)?;
                let incoming = self.nearest_lane(state, Towards::Before, None);
                let outgoing = lane
                    .filter(|lane| Some(*lane) != incoming)
                    .or_else(|| self.nearest_lane(state, Towards::After, incoming))
                    .ok_or_else(|| no_lane("a lane to turn onto"))?;
                self.check_side(name, direction, incoming, outgoing)?;
                let controller = Controller::UTurn {
                    direction,
                    radius_m,
                };
                Ok((controller, Some(outgoing), incoming))
            }
            ControllerSetup::Shift { .. }
            | ControllerSetup::Turn { .. }
            | ControllerSetup::StopAt { .. }
            | ControllerSetup::Dock { .. }
            | ControllerSetup::Creep { .. } => Err(ScheduleError::Manoeuvre {
                state: name.to_owned(),
                reason: "its controller is declared, but not available yet".to_owned(),
            }),
        }
    }

    fn check_side(
        &self,
        name: &str,
        direction: TurnDirection,
        incoming: Option<usize>,
        outgoing: usize,
    ) -> Result<(), ScheduleError> {
        let Some(incoming) = incoming.map(|lane| &self.map.lanes()[lane]) else {
            return Ok(());
        };
        let outgoing = &self.map.lanes()[outgoing];
        if incoming.line.lateral_m(outgoing.line.a) * direction.sign() > 0.0 {
            return Ok(());
        }
        Err(ScheduleError::TurnSide {
            state: name.to_owned(),
            incoming: incoming.id.clone(),
            outgoing: outgoing.id.clone(),
        })
    }

    /// The lowest speed limit of the states that follow and move; 0 when none moves.
    fn exit_speed(&self, state: StateId) -> f64 {
        let limits = self
            .machine
            .transitions()
            .filter(|transition| transition.from == state && transition.to != state)
            .map(|transition| self.bound[transition.to.index()])
            .filter(|bound| self.skills[bound.skill].controller != ControllerSetup::Stop)
            .map(|bound| match bound.area {
                Some(area) => self.map.areas()[area].speed_limit_m_s,
                None => self.max_speed_m_s,
            });
        limits
            .min_by(f64::total_cmp)
            .map_or(0.0, |limit_m_s| limit_m_s.min(self.max_speed_m_s))
    }

    /// The lane of the nearest state with one (other than `except`), along the transitions; those before moving states
    /// first.
    fn nearest_lane(
        &self,
        state: StateId,
        towards: Towards,
        except: Option<usize>,
    ) -> Option<usize> {
        let mut waiting = VecDeque::from([state]);
        let mut seen = vec![false; self.bound.len()];
        seen[state.index()] = true;
        while let Some(at) = waiting.pop_front() {
            for transition in self.machine.transitions() {
                let (here, next) = match towards {
                    Towards::Before => (transition.to, transition.from),
                    Towards::After => (transition.from, transition.to),
                };
                if here != at || seen[next.index()] {
                    continue;
                }
                seen[next.index()] = true;
                let bound = self.bound[next.index()];
                if let Some(lane) = bound.lane.filter(|lane| Some(*lane) != except) {
                    return Some(lane);
                }
                waiting.push_back(next);
            }
        }
        None
    }
}

#[derive(Clone, Copy)]
enum Towards {
    Before,
    After,
}

fn positive(skill: &SkillSetup, what: &'static str, found: f64) -> Result<(), ScheduleError> {
    if found.is_finite() && found > 0.0 {
        return Ok(());
    }
    Err(ScheduleError::Parameter {
        skill: skill.id.clone(),
        what,
        expected: "positive",
        found,
    })
}
