//! Binds skills to the states of a machine.

use super::controllers::Controller;
use super::controllers::case::{Case, RobotLimits};
use super::error::ScheduleError;
use super::graph::{Bound, Graph};
use super::setup::{MonitorSetup, SkillSetup, StateSetup};
use super::state_schedule::Schedule;
use crate::map::SemanticMap;
use crate::monitors::{Monitor, MonitorKind};
use coordination::fsm::{Machine, StateId};

/// One schedule for each state of the machine, by [`StateId::index`].
///
/// # Errors
/// [`ScheduleError`]: a name that nothing has, a number out of range, or a manoeuvre that cannot be driven.
pub fn compile(
    map: &SemanticMap,
    machine: &Machine,
    states: &[StateSetup],
    skills: &[SkillSetup],
    monitors: &[MonitorSetup],
    robot: &RobotLimits,
) -> Result<Vec<Schedule>, ScheduleError> {
    let graph = Graph {
        map,
        machine,
        skills,
        max_speed_m_s: robot.max_speed_m_s,
        bound: bind(map, machine, states, skills)?,
    };
    for skill in skills {
        if let Some(speed_m_s) = skill.speed_m_s {
            skill.check_positive("speed", speed_m_s)?;
        }
    }
    let compiler = Compiler {
        graph,
        robot,
        monitors,
    };
    machine
        .states()
        .map(|(state, name)| compiler.schedule(state, name))
        .collect()
}

struct Compiler<'a> {
    graph: Graph<'a>,
    robot: &'a RobotLimits,
    monitors: &'a [MonitorSetup],
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
        let lane = match &state.lane {
            None => area.and_then(|area| map.areas()[area].lane),
            Some(id) => Some(
                map.lanes()
                    .iter()
                    .position(|lane| lane.id == *id)
                    .ok_or_else(|| unknown(state, "lane", id))?,
            ),
        };
        Ok(Bound { skill, area, lane })
    };
    machine.states().map(|(_, name)| bind_one(name)).collect()
}

impl Compiler<'_> {
    fn schedule(&self, state: StateId, name: &str) -> Result<Schedule, ScheduleError> {
        let bound = self.graph.of(state);
        let skill = self.graph.skill(state);
        let area = bound.area.map(|area| &self.graph.map.areas()[area]);
        let case = Case::new(&self.graph, self.robot, state, name);
        let (controller, lanes) = Controller::plan(&case)?;
        Ok(Schedule {
            skill: bound.skill,
            area: bound.area,
            lane: lanes.lane,
            from_lane: lanes.from_lane,
            end_lane: lanes.end_lane,
            tracks: skill.tracks,
            features: skill.tracks.union(skill.searches),
            controller,
            monitors: self.monitors_of(skill)?,
            speed_limit_m_s: lanes.speed_limit_m_s,
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
            if let MonitorKind::After { seconds } = monitor.kind
                && !(seconds.is_finite() && seconds > 0.0)
            {
                return Err(ScheduleError::Monitor {
                    monitor: monitor.id.clone(),
                    found_s: seconds,
                });
            }
            Ok(Monitor::new(monitor.event, monitor.kind))
        };
        skill.monitors.iter().map(find).collect()
    }
}
