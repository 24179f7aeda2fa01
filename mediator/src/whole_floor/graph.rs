//! The graph of all placements, and questions about what can be reached in it.

use std::rc::Rc;

use super::state::State;

/// What leads from one placement to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Step {
    /// It turns out which way a robot goes on.
    Heads(u16),
    /// A robot drives on, to other areas.
    Moves(u16),
    /// A robot goes on to something else where it is.
    Turns(u16),
    /// A robot is granted an area.
    IsGranted(u16, u16),
    /// A robot asks a net.
    Asks(u16, u16),
    /// A net's transition fires: first those that let robots into areas, then those that take discrete control.
    Fires(u16, u16),
    /// A coordination begins in a situation, with certain robots.
    Begins(u16, u16, u32),
    /// A robot hears what a coordination has told it.
    Hears(u16, u16),
    /// A coordination goes on too slowly, so that its robots are told to get out of the way.
    Preempts(u16),
    /// All robots of a coordination are out of the way.
    Yielded(u16),
    /// A coordination lets its robots go as they are.
    LetsGo(u16),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) from: u32,
    pub(super) to: u32,
    pub(super) step: Step,
    /// A grant for which another robot comes first, as long as that one asks.
    pub(super) outranked: bool,
    /// A transition before which the executor of its net fires another one. It fires all the same behind a new start of the mediator,
    /// which does not know what fired last, but that is not again and again.
    pub(super) out_of_turn: bool,
}

/// Placements in the order in which they were found, the nearest first.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub(super) states: Vec<Rc<State>>,
    pub(super) edges: Vec<Edge>,
}

impl Step {
    /// The robot without which it does not happen. Where one that does nothing any more would have gone makes no difference, so that
    /// this may turn out all the same.
    pub(super) fn robot(self) -> Option<usize> {
        match self {
            Self::Moves(robot)
            | Self::Turns(robot)
            | Self::IsGranted(robot, _)
            | Self::Asks(robot, _)
            | Self::Hears(robot, _) => Some(robot.into()),
            Self::Heads(_)
            | Self::Fires(..)
            | Self::Begins(..)
            | Self::Preempts(_)
            | Self::Yielded(_)
            | Self::LetsGo(_) => None,
        }
    }
}

impl Step {
    /// It happens only when something took too long.
    pub(super) fn is_late(self) -> bool {
        matches!(self, Self::Preempts(_) | Self::LetsGo(_))
    }
}

impl Graph {
    /// Whether each placement leads, over edges of which `counts` holds, to one of the `wanted`.
    pub(super) fn can_reach(
        &self,
        wanted: impl Fn(usize) -> bool,
        counts: impl Fn(&Edge) -> bool,
    ) -> Vec<bool> {
        let counted = || self.edges.iter().filter(|edge| counts(edge));
        // Where the edges into each placement begin in a list of their origins.
        let mut begins = vec![0_u32; self.states.len() + 1];
        for edge in counted() {
            begins[edge.to as usize + 1] += 1;
        }
        for place in 1..begins.len() {
            begins[place] += begins[place - 1];
        }
        let mut origins = vec![0_u32; begins.last().map_or(0, |&count| count as usize)];
        let mut next = begins.clone();
        for edge in counted() {
            let place = &mut next[edge.to as usize];
            origins[*place as usize] = edge.from;
            *place += 1;
        }
        let mut reaches: Vec<bool> = (0..self.states.len()).map(wanted).collect();
        let mut open: Vec<usize> = (0..reaches.len()).filter(|&place| reaches[place]).collect();
        while let Some(place) = open.pop() {
            let into = begins[place] as usize..begins[place + 1] as usize;
            for &from in &origins[into] {
                if !std::mem::replace(&mut reaches[from as usize], true) {
                    open.push(from as usize);
                }
            }
        }
        reaches
    }

    /// The steps of a shortest way from the start, each with the placement that it leads to.
    pub(super) fn way_to(&self, place: usize) -> Vec<(Step, &State)> {
        // The first edge that found a placement is one of a shortest way.
        let mut found: Vec<Option<Edge>> = vec![None; self.states.len()];
        for edge in &self.edges {
            if edge.to != 0 && edge.from < edge.to {
                found[edge.to as usize].get_or_insert(*edge);
            }
        }
        let mut steps = Vec::new();
        let mut at = place;
        while let Some(edge) = found[at] {
            steps.push((edge.step, &*self.states[at]));
            at = edge.from as usize;
        }
        steps.reverse();
        steps
    }
}
