//! A coordination that takes the discrete control of robots, as the mediator runs it: its net, what is said with its robots, and how
//! they get out of the way.

use coordination::protocol::Position;

use super::state::{ControlState, Controlled, Order, Phase};
use super::talk::Talk;
use super::tokens::{Ports, Progress, Tokens};
use super::words::{Words, is_looked_at};
use crate::nets::{Cast, Plan};

/// A situation in which the net begins.
pub(super) struct Situation {
    pub(super) name: String,
    pub(super) tokens: Tokens,
    ports: Vec<Ports>,
    pub(super) casts: Vec<Cast>,
}

/// How robots get out of the way.
struct Preempt {
    situation: Option<usize>,
    /// By role.
    talks: Vec<Talk>,
    /// By role: states in which its robot is out of the way.
    states: Vec<Vec<String>>,
}

pub(super) struct ControlNet {
    pub(super) id: String,
    pub(super) situations: Vec<Situation>,
    talks: Vec<Talk>,
    preempt: Option<Preempt>,
}

impl ControlNet {
    /// That of a plan all of whose roles take discrete control.
    pub(super) fn of(plan: &Plan, words: &Words<'_>) -> Option<Self> {
        if !plan.controls() || !is_looked_at(plan) {
            return None;
        }
        let situations = plan.situations.iter().map(|own| {
            let model = own.proof.model();
            let roles = plan.roles.iter();
            Situation {
                name: own.name.clone(),
                tokens: Tokens::of(model),
                ports: roles
                    .map(|role| Ports::of(model, &role.name, &role.script.protocol))
                    .collect(),
                casts: own.casts.clone(),
            }
        });
        let preempt = plan.preempt.as_ref().map(|own| Preempt {
            situation: own.situation,
            talks: { own.yields.iter() }
                .map(|own| Talk::of(&own.script, words))
                .collect(),
            states: own.yields.iter().map(|own| own.states.clone()).collect(),
        });
        Some(Self {
            id: plan.id.clone(),
            situations: situations.collect(),
            talks: { plan.roles.iter() }
                .map(|role| Talk::of(&role.script, words))
                .collect(),
            preempt,
        })
    }

    /// As it begins.
    pub(super) fn idle() -> ControlState {
        ControlState {
            phase: Phase::Idle,
            roles: Vec::new(),
        }
    }

    /// The net begins with a robot for each role.
    pub(super) fn start(
        &self,
        situation: usize,
        robots: impl Iterator<Item = u16>,
    ) -> ControlState {
        ControlState {
            phase: Phase::Running {
                situation: situation as u16,
                marks: self.situations[situation].tokens.begin(),
            },
            roles: robots.map(Controlled::begin).collect(),
        }
    }

    /// The robot's discrete control is with this coordination.
    pub(super) fn role_of(own: &ControlState, robot: usize) -> Option<usize> {
        { own.roles.iter() }.position(|role| usize::from(role.robot) == robot && !role.over)
    }

    fn talk(&self, own: &ControlState, role: usize) -> Option<&Talk> {
        match own.phase {
            Phase::Idle => None,
            Phase::Running { .. } => self.talks.get(role),
            Phase::Yielding => self.preempt.as_ref()?.talks.get(role),
        }
    }

    /// The robot knows that its discrete control is taken.
    pub(super) fn is_acquired(own: &ControlState, role: usize) -> bool {
        own.roles[role].heard != Position::START
    }

    /// Reads what robots have set, and sets the flags of full sinks, as far as that follows by itself.
    pub(super) fn follow(&self, own: &mut ControlState) {
        if let Phase::Running { marks, .. } = &mut own.phase {
            marks.refill();
        }
        loop {
            let mut changed = false;
            for role in 0..own.roles.len() {
                changed |= self.follow_role(own, role);
            }
            if !changed {
                break;
            }
        }
        if own.roles.iter().all(|role| role.over) {
            *own = Self::idle();
        }
    }

    fn follow_role(&self, own: &mut ControlState, role: usize) -> bool {
        let ControlState { phase, roles } = own;
        let part = &mut roles[role];
        match (phase, &self.preempt) {
            (Phase::Running { situation, marks }, _) => {
                let (talk, ports) = (
                    &self.talks[role],
                    &self.situations[usize::from(*situation)].ports[role],
                );
                let has_read = ports.read(marks, &mut part.at);
                if has_read {
                    part.has_read(talk);
                }
                let told = ports.tell(marks, &mut part.at);
                part.keep(talk, told);
                has_read || told.is_some()
            }
            (Phase::Yielding, Some(preempt)) => {
                let talk = &preempt.talks[role];
                if let Some((_, next)) = talk.protocol.towards(part.at.read, part.at.set) {
                    part.at.read = next;
                    part.has_read(talk);
                    return true;
                }
                let next = talk.next_of_mediator(part);
                let told = next.filter(|(flag, _)| Some(*flag) != talk.release);
                part.tell(talk, told)
            }
            _ => false,
        }
    }

    // ---------------------------------------------------------------- robots

    /// A robot hears what it was told: areas to ask for, orders for its machine; it answers what waits for nothing else.
    pub(super) fn hear(&self, own: &mut ControlState, role: usize, orders: &mut Vec<Order>) {
        let Some(talk) = self.talk(own, role) else {
            return;
        };
        let part = &mut own.roles[role];
        while let Some((flag, next)) = talk.protocol.towards(part.heard, part.at.set) {
            part.heard = next;
            if let Some(event) = talk.flags[flag.index()].event {
                let releases = Some(flag) == talk.release;
                orders.push(Order { event, releases });
            }
        }
        talk.answer(part, None);
    }

    /// There is something that it has not heard.
    pub(super) fn has_news(own: &ControlState, role: usize) -> bool {
        let part = &own.roles[role];
        part.heard != part.at.set
    }

    /// A robot's machine puts something out.
    pub(super) fn put_out(&self, own: &mut ControlState, role: usize, output: u16) {
        if let Some(talk) = self.talk(own, role) {
            talk.answer(&mut own.roles[role], Some(output));
        }
    }

    /// The robot has been given its discrete control back, by what it has set itself.
    pub(super) fn has_released(&self, own: &ControlState, role: usize) -> bool {
        { self.talk(own, role) }.is_some_and(|talk| talk.protocol.is_end(own.roles[role].heard))
    }

    /// Areas of its orders.
    pub(super) fn ordered(own: &ControlState, role: usize) -> impl Iterator<Item = u16> {
        let all = !Self::has_news(own, role);
        { own.roles[role].kept.iter() }
            .filter(move |_| all)
            .map(|kept| kept.area)
    }

    /// A robot has left an area, or has given it back without having been in it.
    pub(super) fn gave_back(&self, own: &mut ControlState, robot: usize, area: u16, entered: bool) {
        for role in 0..own.roles.len() {
            if usize::from(own.roles[role].robot) != robot {
                continue;
            }
            let on_the_way = { self.talk(own, role) }
                .is_some_and(|talk| talk.is_on_the_way(&own.roles[role], area));
            let kept = &mut own.roles[role].kept;
            if entered && !on_the_way {
                kept.retain(|kept| kept.area != area || !kept.granted);
            }
            for kept in kept.iter_mut().filter(|kept| kept.area == area) {
                kept.left |= entered && kept.granted;
                kept.granted = false;
            }
        }
    }

    // ---------------------------------------------------------------- getting out of the way

    /// Nothing went on for too long: its robots are told to get out of the way.
    pub(super) fn preempt(&self, own: &ControlState) -> Option<ControlState> {
        let runs = matches!(own.phase, Phase::Running { .. });
        let preempt = self.preempt.as_ref().filter(|_| runs)?;
        let roles = own.roles.iter().zip(&preempt.talks).map(|(role, talk)| {
            let begin = Controlled::begin(role.robot);
            let mut positions = talk.protocol.positions();
            match positions.find(|&position| talk.protocol.is_end(position)) {
                Some(last) if role.over => Controlled {
                    at: Progress {
                        set: last,
                        read: last,
                    },
                    heard: last,
                    over: true,
                    ..begin
                },
                _ => begin,
            }
        });
        Some(ControlState {
            phase: Phase::Yielding,
            roles: roles.collect(),
        })
    }

    /// All are out of the way, by `is_in`: whether the robot of a role is in one of these states. It begins again where the situation
    /// `fits`, or lets them go.
    pub(super) fn yielded(
        &self,
        own: &ControlState,
        is_in: impl Fn(usize, &[String]) -> bool,
        fits: impl Fn(usize, &Cast) -> bool,
    ) -> Option<ControlState> {
        let preempt = self.preempt.as_ref()?;
        if own.phase != Phase::Yielding {
            return None;
        }
        let releasing = |role: usize| {
            let (talk, part) = (&preempt.talks[role], &own.roles[role]);
            let mut set = talk.protocol.set_flags(part.at.read);
            set.any(|(flag, _)| Some(flag) == talk.release) && !part.over
        };
        let may_go = |role: usize| {
            let (talk, part) = (&preempt.talks[role], &own.roles[role]);
            let next = talk.next_of_mediator(part);
            next.filter(|(flag, _)| Some(*flag) == talk.release)
        };
        let roles = 0..own.roles.len();
        let releases = roles.clone().any(releasing);
        let out = |role: usize| {
            own.roles[role].over || may_go(role).is_some() && is_in(role, &preempt.states[role])
        };
        if !releases && !roles.clone().all(out) {
            return None;
        }
        let whole = own.roles.iter().all(|role| !role.over);
        let again = preempt.situation.filter(|&situation| {
            let casts = &self.situations[situation].casts;
            !releases && whole && roles.clone().all(|role| fits(role, &casts[role]))
        });
        if let Some(situation) = again {
            return Some(self.start(situation, own.roles.iter().map(|role| role.robot)));
        }
        let mut after = own.clone();
        let mut told = false;
        for role in roles {
            told |= after.roles[role].tell(&preempt.talks[role], may_go(role));
        }
        told.then_some(after)
    }

    /// It may end as it is: after too long in getting out of the way, or when a robot has not answered that it was asked.
    pub(super) fn may_let_go(&self, own: &ControlState) -> bool {
        let answered = |role: usize| {
            let part = &own.roles[role];
            part.over || { self.talk(own, role) }.is_some_and(|talk| talk.has_answered(part))
        };
        match own.phase {
            Phase::Idle => false,
            Phase::Running { .. } => !(0..own.roles.len()).all(answered),
            Phase::Yielding => true,
        }
    }

    /// What the robot of a role does when the coordination is over without having released it.
    pub(super) fn let_go(&self, own: &ControlState, role: usize) -> Option<Order> {
        let talk = self.talk(own, role)?;
        let heard = own.roles[role].heard;
        let mut set = talk.protocol.set_flags(heard);
        let released = set.any(|(flag, _)| Some(flag) == talk.release);
        let event = talk.flags[talk.release?.index()].event?;
        (heard != Position::START && !released).then_some(Order {
            event,
            releases: true,
        })
    }
}

/// The ways to have a robot of its own for each role, at most so many: there are as many as the product of all roles' robots.
pub(super) fn assignments(candidates: &[Vec<usize>], most: usize) -> Vec<Vec<usize>> {
    let (mut all, mut chosen) = (Vec::new(), Vec::with_capacity(candidates.len()));
    choose(candidates, most, &mut chosen, &mut all);
    all
}

fn choose(rest: &[Vec<usize>], most: usize, chosen: &mut Vec<usize>, all: &mut Vec<Vec<usize>>) {
    let Some((first, rest)) = rest.split_first() else {
        all.push(chosen.clone());
        return;
    };
    for &robot in first {
        if all.len() == most {
            return;
        }
        if !chosen.contains(&robot) {
            chosen.push(robot);
            choose(rest, most, chosen, all);
            chosen.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_role_has_a_robot_of_its_own_in_at_most_so_many_ways() {
        let both = vec![1, 2];
        let none: Vec<Vec<usize>> = Vec::new();
        assert_eq!(assignments(&[], 9), [Vec::<usize>::new()]);
        assert_eq!(assignments(&[vec![]], 9), none);
        assert_eq!(assignments(&[both.clone(), vec![2]], 9), [[1, 2]]);
        assert_eq!(
            assignments(&[both.clone(), both.clone()], 9),
            [[1, 2], [2, 1]]
        );
        assert_eq!(assignments(&[both.clone(), both.clone()], 1), [[1, 2]]);
        assert_eq!(assignments(&[both.clone(), both.clone(), both], 9), none);
        // Sixteen roles that any of forty robots can play: more ways than there are atoms in a robot.
        let many = vec![(0..40).collect::<Vec<_>>(); 16];
        assert_eq!(assignments(&many, 1000).len(), 1000);
    }
}
