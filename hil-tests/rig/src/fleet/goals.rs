//! How far a robot is with what it is to do, by the world's truth.

use sim::world::Truth;

use super::scenario::{Goal, Stop};

/// Slower than this a robot stands.
pub const STANDING_M_S: f64 = 0.02;

/// One robot's way.
#[derive(Clone, Debug)]
pub struct Way {
    stops: Vec<Stop>,
    round: usize,
    rounds: u32,
    reached: usize,
    /// Since when it stands at the next stop.
    stands_ns: Option<u64>,
    done_ns: Option<u64>,
}

impl Way {
    /// At its beginning.
    #[must_use]
    pub fn new(goal: &Goal) -> Self {
        Self {
            stops: goal.stops().cloned().collect(),
            round: goal.through.len(),
            rounds: goal.rounds,
            reached: 0,
            stands_ns: None,
            done_ns: None,
        }
    }

    /// Takes in where the robot is.
    pub fn observe(&mut self, truth: &Truth) {
        let Some(stop) = self.stops.get(self.reached) else {
            self.done_ns.get_or_insert(truth.time_ns);
            return;
        };
        let there = stop.region.contains([truth.pose.x_m, truth.pose.y_m]);
        let stands = truth.twist.v_m_s.abs() < STANDING_M_S;
        if !there || (stop.stands_s > 0.0 && !stands) {
            self.stands_ns = None;
            return;
        }
        let since_ns = *self.stands_ns.get_or_insert(truth.time_ns);
        if truth.time_ns.saturating_sub(since_ns) as f64 * 1e-9 >= stop.stands_s {
            self.reached += 1;
            self.stands_ns = None;
            if self.reached == self.stops.len() {
                self.done_ns = Some(truth.time_ns);
            }
        }
    }

    /// Whole rounds.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        let rounds = self.reached.checked_div(self.round).unwrap_or(0);
        u32::try_from(rounds).unwrap_or(u32::MAX).min(self.rounds)
    }

    /// Rounds that there are to be.
    #[must_use]
    pub fn wanted(&self) -> u32 {
        self.rounds
    }

    /// When it was done.
    #[must_use]
    pub fn done_ns(&self) -> Option<u64> {
        self.done_ns
    }

    /// Whether there is nothing left to do.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.reached >= self.stops.len()
    }

    /// Where it has to go next.
    #[must_use]
    pub fn next(&self) -> Option<&str> {
        self.stops.get(self.reached).map(|stop| stop.name.as_str())
    }
}
