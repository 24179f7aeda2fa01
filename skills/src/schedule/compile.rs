//! Binds skills to the states of a machine.

use super::controllers::Controller;
use super::controllers::case::{Case, RobotLimits};
use super::graph::{Bound, Graph};
use super::state_schedule::Schedule;
use crate::map::SemanticMap;
use crate::monitors::Monitor;
use coordination::event::{EventId, EventTable};
use coordination::fsm::{Machine, MachineModel, StateId};
use description::keys::{KeyError, KeyErrors, Section};
use description::site::{FsmConfig, FsmState, Site, SkillConfig};

/// The state machine of a role; its events, and those of the site's monitors, get their numbers in the table.
///
/// # Errors
/// `fsm.<role>` for a machine that cannot be run, `monitors` for more events than numbers.
pub fn machine(site: &Site, role: &str, events: &mut EventTable) -> Result<Machine, KeyError> {
    let fsm = fsm(site, role)?;
    let mut model = MachineModel::new(role);
    model.initial(fsm.initial.as_str());
    for state in &fsm.states {
        model.state(state.name.as_str());
    }
    for one in &fsm.transitions {
        let outputs: Vec<&str> = one.outputs.iter().map(String::as_str).collect();
        model.transition(&one.from, &one.on, &one.to, &outputs);
    }
    let machine = model.compile(events).map_err(|error| {
        let expected = "a state machine that can be run";
        KeyError::new(format!("fsm.{role}"), error.to_string(), expected)
    })?;
    for monitor in &site.monitors {
        events
            .intern(&monitor.event)
            .map_err(|error| KeyError::new("monitors", error.to_string(), "fewer events"))?;
    }
    Ok(machine)
}

fn fsm<'a>(site: &'a Site, role: &str) -> Result<&'a FsmConfig, KeyError> {
    let fsm = site.fsm.get(role);
    fsm.ok_or_else(|| KeyError::unknown(format!("fsm.{role}"), "state machine", role))
}

/// One schedule for each state of the role's [`machine`], by [`StateId::index`].
///
/// # Errors
/// Every key to blame: names that nothing has, numbers out of range; else manoeuvres that cannot be driven.
pub fn compile(
    site: &Site,
    role: &str,
    map: &SemanticMap,
    machine: &Machine,
    events: &EventTable,
    robot: &RobotLimits,
) -> Result<Vec<Schedule>, KeyErrors> {
    let fsm = fsm(site, role)?;
    let skills = site.skills.iter().filter_map(|skill| {
        let error = skill.check().err()?;
        Some(error.below(&format!("skills.{}", skill.id)))
    });
    let monitors = site.monitors.iter().filter_map(|monitor| {
        let error = monitor.check().err()?;
        Some(error.below(&format!("monitors.{}", monitor.event)))
    });
    KeyErrors::any(skills.chain(monitors))?;
    let unknown = |name: &str| KeyError::unknown(format!("fsm.{role}.states"), "state", name);
    let bound = machine.states().map(|(_, name)| {
        let state = fsm.state(name).ok_or_else(|| unknown(name))?;
        bind(site, role, map, state)
    });
    let graph = Graph {
        map,
        machine,
        site,
        role,
        max_speed_m_s: robot.max_speed_m_s,
        bound: all(bound)?,
    };
    let states = machine.states();
    all(states.map(|(state, name)| schedule(&graph, robot, events, state, name)))
}

/// All values, or all errors.
fn all<T>(results: impl Iterator<Item = Result<T, KeyError>>) -> Result<Vec<T>, KeyErrors> {
    let mut values = Vec::new();
    let errors = results.filter_map(|result| result.map(|value| values.push(value)).err());
    KeyErrors::any(errors)?;
    Ok(values)
}

fn bind(site: &Site, role: &str, map: &SemanticMap, state: &FsmState) -> Result<Bound, KeyError> {
    let unknown = |key: &str, what, name: &str| {
        KeyError::unknown(
            format!("fsm.{role}.states.{}.{key}", state.name),
            what,
            name,
        )
    };
    let skill = { site.skills.iter() }.position(|skill| skill.id == state.skill);
    let skill = skill.ok_or_else(|| unknown("skill", "skill", &state.skill))?;
    let area = map.area_index(&state.area);
    let area = area.ok_or_else(|| unknown("area", "area", &state.area))?;
    let own = state.lane.as_ref().map(|id| {
        let lane = map.lanes().iter().position(|lane| lane.id == *id);
        lane.ok_or_else(|| unknown("lane", "lane", id))
    });
    let lane = own.transpose()?.or(map.area(area).lane);
    Ok(Bound { skill, area, lane })
}

fn schedule(
    graph: &Graph,
    robot: &RobotLimits,
    events: &EventTable,
    state: StateId,
    name: &str,
) -> Result<Schedule, KeyError> {
    let bound = graph.of(state);
    let skill = graph.skill(state);
    let case = Case::new(graph, robot, state, name);
    let (controller, lanes) = Controller::plan(&case)?;
    Ok(Schedule {
        skill: bound.skill,
        area: Some(bound.area),
        lane: lanes.lane,
        from_lane: lanes.from_lane,
        end_lane: lanes.end_lane,
        tracks: case.tracks,
        features: case.features,
        controller,
        monitors: monitors_of(graph.site, skill, events)?,
        speed_limit_m_s: lanes.speed_limit_m_s,
        deviation_limit_m: graph.map.area(bound.area).deviation_limit_m,
    })
}

fn monitors_of(
    site: &Site,
    skill: &SkillConfig,
    events: &EventTable,
) -> Result<Vec<Monitor>, KeyError> {
    let find = |(index, name): (usize, &String)| -> Result<Monitor, KeyError> {
        let found: Option<EventId> = events.id(name);
        let (event, monitor) = found.zip(site.monitor(name)).ok_or_else(|| {
            let key = format!("skills.{}.monitors[{index}]", skill.id);
            KeyError::unknown(key, "monitor", name)
        })?;
        Ok(Monitor::new(event, monitor.kind.clone()))
    };
    skill.monitors.iter().enumerate().map(find).collect()
}
