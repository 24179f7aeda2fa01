//! A net that lets robots into areas, as the mediator runs it: its protocols follow from where the robots are.

use std::sync::Arc;

use contract::protocols::{MEDIATOR_PARTY, ROBOT_PARTY};
use coordination::petri::{Binding, NetModel, PlaceKind};
use coordination::protocol::{FlagId, Party, Position, Protocol};

use super::state::{NetState, RoleState};
use crate::nets::{Kind, Passage, Plan, SituationPlan, distinct};

/// One of the net's transitions, by places.
struct Transition {
    name: String,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    /// No other one takes any of its inputs or fills any of its sinks, and such ones do not go round: that it fires first takes
    /// nothing from anybody.
    free: bool,
}

/// A role, with the places that its flags fill and empty.
pub(super) struct Role {
    protocol: Arc<Protocol>,
    pub(super) passages: Vec<Passage>,
    /// By flag.
    sources: Vec<Option<usize>>,
    sinks: Vec<(usize, FlagId)>,
    /// Robots that may play it.
    robots: Vec<usize>,
    /// Who plays it first, where there is a robot for each role.
    first: Option<u16>,
}

/// The net of a standing coordination.
pub(super) struct GateNet {
    pub(super) id: String,
    marked: Vec<bool>,
    transitions: Vec<Transition>,
    pub(super) roles: Vec<Role>,
    /// Internal places of each declared end.
    ends: Vec<Vec<bool>>,
    internal: Vec<bool>,
    pub(super) governed: Vec<u16>,
}

impl GateNet {
    /// That of a plan whose roles are all let into areas; none of one that takes discrete control.
    pub(super) fn of(plan: &Plan) -> Option<Self> {
        if plan.controls() {
            return None;
        }
        // As the mediator does: the first one for which there are robots.
        let cast = |situation: &SituationPlan| {
            let robots = situation.casts.iter().map(|cast| cast.robots.clone());
            distinct(&robots.collect::<Vec<_>>())
        };
        let filled = { plan.situations.iter() }.find(|situation| cast(situation).is_some());
        let situation = filled.or(plan.situations.first())?;
        let first: Vec<Option<u16>> = match cast(situation) {
            Some(robots) => robots.into_iter().map(|robot| Some(robot as u16)).collect(),
            None => vec![None; situation.casts.len()],
        };
        let model = situation.proof.model();
        let place = |name: &str| model.places().position(|place| place.name == name);
        let bound = |role: &str, flag: &str| {
            let binding = Binding::flag(role, flag);
            model
                .places()
                .position(|place| place.binding == Some(&binding))
        };
        let casts = situation.casts.iter().zip(first);
        let roles = plan.roles.iter().zip(casts).map(|(role, (cast, first))| {
            let Kind::Access(passages) = &role.kind else {
                return None;
            };
            let protocol = &role.script.protocol;
            let of = |party: Party| protocol.flags().filter(move |flag| flag.2 == party);
            Some(Role {
                protocol: Arc::clone(protocol),
                passages: passages.clone(),
                sources: { protocol.flags() }
                    .map(|(_, flag, party)| {
                        (party == ROBOT_PARTY)
                            .then(|| bound(&role.name, flag))
                            .flatten()
                    })
                    .collect(),
                sinks: of(MEDIATOR_PARTY)
                    .filter_map(|(id, flag, _)| Some((bound(&role.name, flag)?, id)))
                    .collect(),
                robots: cast.robots.clone(),
                first,
            })
        });
        let set = |names: &[&str]| {
            let mut marks = vec![false; model.places().len()];
            for index in names.iter().filter_map(|name| place(name)) {
                marks[index] = true;
            }
            marks
        };
        Some(Self {
            id: plan.id.clone(),
            marked: model.places().map(|place| place.marked).collect(),
            transitions: transitions(model),
            roles: roles.collect::<Option<Vec<Role>>>()?,
            ends: model.ends().map(|end| set(&end.places)).collect(),
            internal: model
                .places()
                .map(|place| place.binding.is_none())
                .collect(),
            governed: plan.governed.iter().map(|&area| area as u16).collect(),
        })
    }

    /// Before it begins; where there is no robot for some role it never does.
    pub(super) fn begin(&self) -> NetState {
        let roles = self.roles.iter().map(|role| role.first);
        let roles: Option<Vec<u16>> = roles.collect();
        let begun = { roles.into_iter().flatten() }.map(RoleState::begin);
        NetState::new(&self.marked, begun.collect())
    }

    /// The role that a robot has, or could take over from one that wants nothing: `wants` says whether a robot has or asks for areas.
    pub(super) fn role_for(
        &self,
        state: &NetState,
        robot: usize,
        wants: impl Fn(usize, &[usize]) -> bool,
    ) -> Option<usize> {
        let own = { state.roles.iter() }.position(|role| usize::from(role.robot) == robot);
        own.or_else(|| {
            { self.roles.iter().zip(&state.roles) }.position(|(role, at)| {
                let areas = role
                    .passages
                    .iter()
                    .flat_map(|own| own.areas.iter().copied());
                let areas: Vec<usize> = areas.collect();
                role.robots.contains(&robot) && at.is_open() && !wants(at.robot.into(), &areas)
            })
        })
    }

    /// The robot of a role asks for a passage, by number.
    pub(super) fn ask(&self, state: &mut NetState, role: usize, robot: usize, passage: usize) {
        let own = &self.roles[role];
        let request = own.passages[passage].request;
        if let Some(next) = own.protocol.after(Position::START, request) {
            state.roles[role] = RoleState {
                set: next,
                ..RoleState::begin(robot as u16)
            };
        }
    }

    /// The robot may be granted the area.
    pub(super) fn lets_in(&self, state: &NetState, robot: usize, area: u16) -> bool {
        let mut roles = self.roles.iter().zip(&state.roles);
        roles.any(|(role, at)| {
            usize::from(at.robot) == robot && { role.passages.iter() }.any(|passage| {
                let inside = at.set == passage.granted_at || at.set == passage.entered_at;
                inside && passage.areas.contains(&usize::from(area))
            })
        })
    }

    /// Transitions that are enabled: all of them, or one alone that takes nothing from any other.
    pub(super) fn enabled(&self, state: &NetState) -> Vec<usize> {
        let enabled = (0..self.transitions.len()).filter(|&number| {
            let own = &self.transitions[number];
            let takes = |place: &&usize| !own.inputs.contains(place);
            own.inputs.iter().all(|&place| state.has_mark(place)) && {
                own.outputs.iter().filter(takes)
            }
            .all(|&place| !state.has_mark(place))
        });
        let enabled: Vec<usize> = enabled.collect();
        let free = { enabled.iter() }.find(|&&number| self.transitions[number].free);
        free.map_or(enabled.clone(), |&free| vec![free])
    }

    pub(super) fn fire(&self, state: &mut NetState, transition: usize) {
        let own = &self.transitions[transition];
        for &place in &own.inputs {
            state.set_mark(place, false);
        }
        for &place in &own.outputs {
            state.set_mark(place, true);
        }
    }

    /// See [`enabled`](Self::enabled).
    pub(super) fn is_free(&self, transition: usize) -> bool {
        self.transitions[transition].free
    }

    pub(super) fn transition_name(&self, transition: usize) -> &str {
        &self.transitions[transition].name
    }

    /// Sets and reads flags as far as they follow: from where robots are (`has`: the area is its own, `is_in`: it is there, `needs`:
    /// it wants to go there), from full sinks, and from empty sources.
    pub(super) fn follow(
        &self,
        state: &mut NetState,
        has: impl Fn(usize, u16) -> bool,
        is_in: impl Fn(usize, u16) -> bool,
        needs: impl Fn(usize, u16) -> bool,
    ) {
        loop {
            let mut changed = false;
            for (number, role) in self.roles.iter().enumerate() {
                let robot = usize::from(state.roles[number].robot);
                let is = |test: &dyn Fn(usize, u16) -> bool, passage: &Passage| {
                    passage.areas.iter().any(|&area| test(robot, area as u16))
                };
                for passage in &role.passages {
                    let at = state.roles[number].set;
                    let gave_up = !is(&has, passage) && !is(&needs, passage);
                    let entered = is(&is_in, passage) || gave_up;
                    let flag = if at == passage.granted_at && entered {
                        passage.entered
                    } else if at == passage.entered_at && !is(&has, passage) {
                        passage.released
                    } else {
                        continue;
                    };
                    if let Some(next) = role.protocol.after(at, flag) {
                        state.roles[number].set = next;
                        changed = true;
                    }
                }
                changed |= role.read(state, number) | role.tell(state, number);
            }
            if !changed {
                return;
            }
        }
    }

    /// Its internal places are those of a declared end.
    pub(super) fn is_at_an_end(&self, state: &NetState) -> bool {
        self.ends.iter().any(|end| {
            let mut internal = self.internal.iter().enumerate();
            internal.all(|(place, internal)| !internal || state.has_mark(place) == end[place])
        })
    }
}

impl Role {
    /// Reads the robot's flags into empty sources.
    fn read(&self, state: &mut NetState, number: usize) -> bool {
        let at = state.roles[number];
        let Some((flag, next)) = self.protocol.towards(at.read, at.set) else {
            return false;
        };
        if let Some(source) = self.sources[flag.index()] {
            if state.has_mark(source) {
                return false;
            }
            state.set_mark(source, true);
        }
        state.roles[number].read = next;
        self.end(&mut state.roles[number]);
        true
    }

    /// Sets the mediator's flags of full sinks.
    fn tell(&self, state: &mut NetState, number: usize) -> bool {
        let mut changed = false;
        for &(sink, flag) in &self.sinks {
            let at = state.roles[number];
            if state.has_mark(sink)
                && at.set == at.read
                && let Some(next) = self.protocol.after(at.set, flag)
            {
                state.set_mark(sink, false);
                (state.roles[number].set, state.roles[number].read) = (next, next);
                self.end(&mut state.roles[number]);
                changed = true;
            }
        }
        changed
    }

    /// A whole run makes room for the next.
    fn end(&self, at: &mut RoleState) {
        if at.set == at.read && self.protocol.is_end(at.read) {
            *at = RoleState::begin(at.robot);
        }
    }
}

fn transitions(model: &NetModel) -> Vec<Transition> {
    let place = |name: &&str| model.places().position(|place| place.name == *name);
    let kinds: Vec<PlaceKind> = model.places().map(|place| place.kind).collect();
    let is_sink = |place: usize| kinds[place] == PlaceKind::Sink;
    let all: Vec<Transition> = { model.transitions() }
        .map(|own| Transition {
            name: own.name.to_owned(),
            inputs: own.inputs.iter().filter_map(place).collect(),
            outputs: own.outputs.iter().filter_map(place).collect(),
            free: false,
        })
        .collect();
    let alone = |number: usize| {
        let own = &all[number];
        let mut others = all.iter().enumerate().filter(|(other, _)| *other != number);
        !others.any(|(_, other)| {
            let takes = other.inputs.iter().any(|place| own.inputs.contains(place));
            let mut fills = { other.outputs.iter() }.filter(|place| own.outputs.contains(place));
            takes || fills.any(|&place| is_sink(place))
        })
    };
    let mut free: Vec<bool> = (0..all.len()).map(alone).collect();
    // Those that are on no way round remain when what leads to none of them is left out, again and again.
    let mut round = free.clone();
    loop {
        let leads_on = |number: usize| {
            let mut others = all.iter().zip(&round).filter(|(_, round)| **round);
            others.any(|(other, _)| {
                { other.inputs.iter() }.any(|own| all[number].outputs.contains(own))
            })
        };
        let Some(end) = (0..all.len()).find(|&number| round[number] && !leads_on(number)) else {
            break;
        };
        round[end] = false;
    }
    for (free, round) in free.iter_mut().zip(round) {
        *free &= !round;
    }
    { all.into_iter().zip(free) }
        .map(|(own, free)| Transition { free, ..own })
        .collect()
}
