//! Places that a robot has to come to, in their order.

use sim::world::{STANDING_M_S, Truth};

use crate::scenario::{Places, Stop};

/// One robot's way.
#[derive(Clone, Debug)]
pub(super) struct Way {
    stops: Vec<Stop>,
    round: usize,
    rounds: u32,
    reached: usize,
    /// Since when it stands at the next stop.
    stands_ns: Option<u64>,
}

impl Way {
    /// At its beginning.
    pub(super) fn new(goal: &Places) -> Self {
        Self {
            stops: goal.stops().cloned().collect(),
            round: goal.through.len(),
            rounds: goal.rounds,
            reached: 0,
            stands_ns: None,
        }
    }

    /// Takes in where the robot is.
    pub(super) fn observe(&mut self, truth: &Truth) {
        let Some(stop) = self.stops.get(self.reached) else {
            return;
        };
        let there = stop
            .region
            .contains([truth.pose.x_m, truth.pose.y_m].into());
        let stands = truth.twist.v_m_s.abs() < STANDING_M_S;
        if !there || (stop.stands_s > 0.0 && !stands) {
            self.stands_ns = None;
            return;
        }
        let since_ns = *self.stands_ns.get_or_insert(truth.time_ns);
        if truth.time_ns.saturating_sub(since_ns) as f64 * 1e-9 >= stop.stands_s {
            self.reached += 1;
            self.stands_ns = None;
        }
    }

    /// Whole rounds.
    pub(super) fn rounds(&self) -> u32 {
        let rounds = self.reached.checked_div(self.round).unwrap_or(0);
        u32::try_from(rounds).unwrap_or(u32::MAX).min(self.rounds)
    }

    /// Where it has to go next; none: all places were reached.
    pub(super) fn next(&self) -> Option<&str> {
        self.stops.get(self.reached).map(|stop| stop.name.as_str())
    }
}
