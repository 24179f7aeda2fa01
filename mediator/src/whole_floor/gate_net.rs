//! A net that lets robots into areas, as the mediator runs it: its protocols follow from where the robots are.

use coordination::protocol::Position;

use super::state::{GateState, RoleState};
use super::tokens::{Ports, Tokens};
use crate::nets::{Kind, Passage, Plan, SituationPlan, distinct};

/// A role, with the places that its flags fill and empty.
pub(super) struct Role {
    ports: Ports,
    pub(super) passages: Vec<Passage>,
    /// Robots that may play it.
    robots: Vec<usize>,
    /// Who plays it first, where there is a robot for each role.
    first: Option<u16>,
}

/// The net of a standing coordination.
pub(super) struct GateNet {
    pub(super) id: String,
    pub(super) tokens: Tokens,
    pub(super) roles: Vec<Role>,
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
        let casts = situation.casts.iter().zip(first);
        let roles = plan.roles.iter().zip(casts).map(|(role, (cast, first))| {
            let Kind::Access(passages) = &role.kind else {
                return None;
            };
            Some(Role {
                ports: Ports::of(model, &role.name, &role.script.protocol),
                passages: passages.clone(),
                robots: cast.robots.clone(),
                first,
            })
        });
        Some(Self {
            id: plan.id.clone(),
            tokens: Tokens::of(model),
            roles: roles.collect::<Option<Vec<Role>>>()?,
            governed: plan.governed.iter().map(|&area| area as u16).collect(),
        })
    }

    /// Before it begins; where there is no robot for some role it never does.
    pub(super) fn begin(&self) -> GateState {
        let roles = self.roles.iter().map(|role| role.first);
        let roles: Option<Vec<u16>> = roles.collect();
        let begun = { roles.into_iter().flatten() }.map(RoleState::begin);
        GateState {
            begun: false,
            marks: self.tokens.begin(),
            roles: begun.collect(),
        }
    }

    /// The role that a robot has, or could take over from one that wants nothing: `wants` says whether a robot has or asks for areas.
    pub(super) fn role_for(
        &self,
        state: &GateState,
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
    pub(super) fn ask(&self, state: &mut GateState, role: usize, robot: usize, passage: usize) {
        let own = &self.roles[role];
        let request = own.passages[passage].request;
        if let Some(next) = own.ports.protocol.after(Position::START, request) {
            state.roles[role] = RoleState::begin(robot as u16);
            state.roles[role].at.set = next;
        }
    }

    /// The robot may be granted the area.
    pub(super) fn lets_in(&self, state: &GateState, robot: usize, area: u16) -> bool {
        let mut roles = self.roles.iter().zip(&state.roles);
        roles.any(|(role, own)| {
            usize::from(own.robot) == robot && { role.passages.iter() }.any(|passage| {
                passage.is_within(own.at.set) && passage.areas.contains(&usize::from(area))
            })
        })
    }

    /// Sets and reads flags as far as they follow: from where robots are (`has`: the area is its own, `is_in`: it is there, `needs`:
    /// it wants to go there), from full sinks, and to sources.
    pub(super) fn follow(
        &self,
        state: &mut GateState,
        has: impl Fn(usize, u16) -> bool,
        is_in: impl Fn(usize, u16) -> bool,
        needs: impl Fn(usize, u16) -> bool,
    ) {
        state.marks.refill();
        loop {
            let mut changed = false;
            for (number, role) in self.roles.iter().enumerate() {
                let own = &mut state.roles[number];
                let robot = usize::from(own.robot);
                let is = |test: &dyn Fn(usize, u16) -> bool, passage: &Passage| {
                    passage.areas.iter().any(|&area| test(robot, area as u16))
                };
                for passage in &role.passages {
                    let at = own.at.set;
                    let gave_up = !is(&has, passage) && !is(&needs, passage);
                    let entered = is(&is_in, passage) || gave_up;
                    let flag = if at == passage.granted_at && entered {
                        passage.entered
                    } else if at == passage.entered_at && !is(&has, passage) {
                        passage.released
                    } else {
                        continue;
                    };
                    if let Some(next) = role.ports.protocol.after(at, flag) {
                        own.at.set = next;
                        changed = true;
                    }
                }
                if role.ports.read(&mut state.marks, &mut own.at) {
                    role.end(own);
                    changed = true;
                }
                if role.ports.tell(&mut state.marks, &mut own.at).is_some() {
                    role.end(own);
                    changed = true;
                }
            }
            if !changed {
                return;
            }
        }
    }
}

impl Role {
    /// A whole run makes room for the next.
    fn end(&self, own: &mut RoleState) {
        if own.at.set == own.at.read && self.ports.protocol.is_end(own.at.read) {
            *own = RoleState::begin(own.robot);
        }
    }
}
