//! Places that a robot has to come to, in their order.

use sim::world::{STANDING_M_S, Truth};

use crate::scenario::{Places, Stop};

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
    pub fn new(goal: &Places) -> Self {
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

    /// Rounds that the robot is to drive.
    #[must_use]
    pub fn wanted(&self) -> u32 {
        self.rounds
    }

    /// When it was done.
    #[must_use]
    pub fn done_ns(&self) -> Option<u64> {
        self.done_ns
    }

    /// Whether all places were reached.
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

#[cfg(test)]
mod tests {
    use super::*;
    use description::geometry::Rect;
    use sim::world::{Pose, Twist};

    fn stop(x_m: f64, stands_s: f64) -> Stop {
        Stop {
            name: format!("{x_m}"),
            region: Rect::new([x_m, 0.0].into(), [x_m + 1.0, 1.0].into()),
            stands_s,
        }
    }

    fn truth(at_s: f64, x_m: f64, v_m_s: f64) -> Truth {
        Truth {
            time_ns: (at_s * 1e9) as u64,
            pose: Pose::new(x_m, 0.5, 0.0),
            twist: Twist {
                v_m_s,
                ..Twist::default()
            },
            ..Truth::default()
        }
    }

    #[test]
    fn places_count_in_their_order_only() {
        let mut way = Way::new(&Places {
            rounds: 2,
            through: vec![stop(0.0, 0.0), stop(5.0, 0.0)],
            then: vec![stop(9.0, 0.0)],
        });
        for x_m in [5.5, 9.5, 0.5, 3.0, 9.5, 5.5, 5.6] {
            way.observe(&truth(1.0, x_m, 0.4));
        }
        assert_eq!((way.rounds(), way.next()), (1, Some("0")));
        for x_m in [0.5, 5.5] {
            way.observe(&truth(2.0, x_m, 0.4));
        }
        assert_eq!((way.rounds(), way.is_done()), (2, false));
        way.observe(&truth(3.0, 9.5, 0.4));
        assert!(way.is_done());
        assert_eq!((way.rounds(), way.done_ns()), (2, Some(3_000_000_000)));
    }

    #[test]
    fn where_it_has_to_stand_passing_through_is_not_enough() {
        let mut way = Way::new(&Places {
            rounds: 1,
            through: vec![stop(0.0, 2.0)],
            then: Vec::new(),
        });
        way.observe(&truth(0.0, 0.5, 0.4));
        way.observe(&truth(9.0, 0.6, 0.4));
        way.observe(&truth(10.0, 0.7, 0.0));
        way.observe(&truth(11.5, 0.7, 0.0));
        way.observe(&truth(11.6, 0.7, 0.1));
        way.observe(&truth(12.5, 0.7, 0.0));
        assert!(!way.is_done());
        way.observe(&truth(14.6, 0.7, 0.0));
        assert!(way.is_done());
    }
}
