//! Schedules: what runs in each state of the robot's machine.
//!
//! A *skill* joins perception, one controller and monitors. A *schedule* is a skill bound to one state: its area's limits,
//! the lane it drives on, the walls it expects. [`compile`] makes one schedule for each state and finds what the data do
//! not say: the lanes a U-turn leads from and to, and the speed to have at a lane's end, follow from the machine's
//! transitions. Changing the state changes the schedule, at run time, without allocation.

use crate::control::{EndOfLane, TurnDirection};
use crate::map::SemanticMap;
use crate::monitors::{Monitor, MonitorKind};
use crate::perception::FeatureSet;
use coordination::event::EventId;
use coordination::fsm::{Machine, StateId};
use std::collections::VecDeque;

/// A controller by its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControllerSetup {
    /// Keeps on the lane of the state's area.
    Corridor,
    /// The same, up to a distance from the wall at its end.
    EndOfLane {
        /// From `base_link` to the wall.
        distance_m: f64,
        /// Speed to have there. By default what the following states allow, 0 when all of them stand still.
        exit_speed_m_s: Option<f64>,
    },
    /// Half a circle onto another lane.
    UTurn {
        /// To which side.
        direction: TurnDirection,
        /// Of `base_link`'s path.
        radius_m: f64,
    },
    /// Stands still.
    Stop,
}

/// A monitor by its name.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorSetup {
    /// Unique among monitors.
    pub id: String,
    /// Raised when the condition becomes true.
    pub event: EventId,
    /// The condition.
    pub kind: MonitorKind,
}

/// What runs together.
#[derive(Clone, Debug, PartialEq)]
pub struct SkillSetup {
    /// Unique among skills.
    pub id: String,
    /// What moves the robot.
    pub controller: ControllerSetup,
    /// Features that correct the pose.
    pub tracks: FeatureSet,
    /// Features that are looked for, without correcting the pose.
    pub searches: FeatureSet,
    /// Monitors by name.
    pub monitors: Vec<String>,
}

/// What a state of the machine means.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSetup {
    /// A state of the machine.
    pub name: String,
    /// The area that it is about.
    pub area: Option<String>,
    /// The skill that runs.
    pub skill: String,
}

/// What does not fit together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScheduleError {
    /// A state of the machine has no meaning, or two.
    #[error("state `{state}` of the machine is described {found} times, expected once")]
    State {
        /// The state.
        state: String,
        /// How often it is described.
        found: usize,
    },
    /// A name that nothing has.
    #[error("{kind} `{id}` names the {wanted} `{name}`, which does not exist")]
    Unknown {
        /// What names it.
        kind: &'static str,
        /// Its name.
        id: String,
        /// What is named.
        wanted: &'static str,
        /// The name that nothing has.
        name: String,
    },
    /// The controller needs a lane.
    #[error("state `{state}` needs {wanted}, and neither its area nor its neighbours give one")]
    NoLane {
        /// The state.
        state: String,
        /// Which lane.
        wanted: &'static str,
    },
    /// A parameter is not a positive number.
    #[error("{what} of skill `{skill}` must be {expected}, found {found}")]
    Parameter {
        /// The skill.
        skill: String,
        /// Which parameter.
        what: &'static str,
        /// What is expected.
        expected: &'static str,
        /// Found.
        found: f64,
    },
    /// A U-turn leads away from its outgoing lane.
    #[error(
        "the U-turn in state `{state}` turns away from lane `{outgoing}`, which lies on the other side of `{incoming}`"
    )]
    TurnSide {
        /// The state.
        state: String,
        /// Where it comes from.
        incoming: String,
        /// Where it should lead.
        outgoing: String,
    },
}

/// A controller bound to a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller {
    /// Keeps on [`Schedule::lane`].
    Corridor,
    /// Up to the end of [`Schedule::lane`].
    EndOfLane(EndOfLane),
    /// From [`Schedule::end_lane`] onto [`Schedule::lane`].
    UTurn {
        /// To which side.
        direction: TurnDirection,
        /// Of `base_link`'s path.
        radius_m: f64,
    },
    /// Stands still.
    Stop,
}

/// What runs in one state.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Index of the skill.
    pub skill: usize,
    /// Index of the area.
    pub area: Option<usize>,
    /// Index of the lane that the robot drives on, or onto.
    pub lane: Option<usize>,
    /// Index of the lane whose end is looked for: the same, or the one that a U-turn leaves.
    pub end_lane: Option<usize>,
    /// Features that correct the pose.
    pub tracks: FeatureSet,
    /// Features that run at all.
    pub features: FeatureSet,
    /// What moves the robot.
    pub controller: Controller,
    /// What raises events.
    pub monitors: Vec<Monitor>,
    /// Of the area.
    pub speed_limit_m_s: f64,
    /// Of the area.
    pub deviation_limit_m: f64,
}

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
        let features = FeatureSet {
            corridor: skill.tracks.corridor || skill.searches.corridor,
            lane_end: skill.tracks.lane_end || skill.searches.lane_end,
        };
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
        match skill.controller {
            ControllerSetup::Stop => Ok((Controller::Stop, lane, lane)),
            ControllerSetup::Corridor => {
                let lane = lane.ok_or_else(|| no_lane("a lane"))?;
                Ok((Controller::Corridor, Some(lane), Some(lane)))
            }
            ControllerSetup::EndOfLane {
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
            ControllerSetup::UTurn {
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

#[cfg(test)]
mod tests;
