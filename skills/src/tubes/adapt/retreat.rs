//! Backing out of a dead end.
//!
//! A robot that stands with its nose to an obstacle, or remembers a person who has walked out of its view, has no room to
//! turn and sees nothing new. After `AFTER_NS` it backs out a little, straight, over floor that it knows to be free, and
//! looks again: what was beside it is ahead of it then. It tries that `TRIES` times in one place.

use description::geometry::Point2;
use description::robot::DetourPolicy;

/// A retreat begins after being blocked this long,
const AFTER_NS: u64 = 3_000_000_000;
/// and ends after this time, wherever the robot is.
const LONGEST_NS: u64 = 15_000_000_000;
/// Retreats in one place, at most; a place is a circle of this radius.
const TRIES: u8 = 3;
const ELSEWHERE_M: f64 = 1.0;
/// No retreat begins while something moves within this distance.
pub(super) const AWAY_M: f64 = 0.4;

/// A retreat under way: where it began, in `odom`, and when.
#[derive(Clone, Copy, Debug)]
struct Active {
    from: Point2,
    since_ns: u64,
}

/// The state of backing out.
#[derive(Clone, Debug, Default)]
pub(super) struct Retreat {
    active: Option<Active>,
    /// Where the first of these tries was.
    place: Point2,
    tries: u8,
    /// Retreats begun.
    pub begun: u64,
}

/// What a retreat has to know of the moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub now_ns: u64,
    /// `base_link` in `odom`.
    pub at: Point2,
    /// Since when no way has led on; `None` while one does.
    pub blocked_since_ns: Option<u64>,
    /// From the robot to what moves.
    pub moving_m: f64,
}

impl Retreat {
    pub fn is_active(&self) -> bool {
        self.active.is_some()
    }

    /// What is left of its way at a place in `odom`.
    pub fn left_m(&self, policy: &DetourPolicy, at: Point2) -> f64 {
        self.active.map_or(0.0, |active| {
            (policy.retreat_m - active.from.distance_m(at)).max(0.0)
        })
    }

    /// Ends it.
    pub fn end(&mut self) {
        self.active = None;
    }

    /// Forgets everything but the count.
    pub fn reset(&mut self) {
        *self = Self {
            begun: self.begun,
            ..Self::default()
        };
    }

    /// Whether the robot is to back out now.
    pub fn goes(&mut self, policy: &DetourPolicy, moment: Moment) -> bool {
        let Moment { now_ns, at, .. } = moment;
        if let Some(Active { from, since_ns }) = self.active {
            let goes_on = from.distance_m(at) < policy.retreat_m
                && now_ns.saturating_sub(since_ns) < LONGEST_NS;
            if !goes_on {
                self.active = None;
            }
            return goes_on;
        }
        let waited = { moment.blocked_since_ns }
            .is_some_and(|since_ns| now_ns.saturating_sub(since_ns) >= AFTER_NS);
        if policy.retreat_m <= 0.0 || !waited || moment.moving_m < AWAY_M {
            return false;
        }
        if self.tries > 0 && self.place.distance_m(at) > ELSEWHERE_M {
            self.tries = 0;
        }
        if self.tries == 0 {
            self.place = at;
        }
        if self.tries >= TRIES {
            return false;
        }
        self.tries += 1;
        self.begun += 1;
        self.active = Some(Active {
            from: at,
            since_ns: now_ns,
        });
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(now_s: f64, x_m: f64) -> Moment {
        Moment {
            now_ns: (now_s * 1e9) as u64,
            at: Point2::new(x_m, 0.0),
            blocked_since_ns: Some(1_000_000_000),
            moving_m: f64::INFINITY,
        }
    }

    #[test]
    fn it_begins_after_a_while_and_ends_after_its_way() {
        let (mut retreat, policy) = (Retreat::default(), DetourPolicy::default());
        assert!(!retreat.goes(&policy, moment(3.9, 5.0)));
        let near = Moment {
            moving_m: 0.3,
            ..moment(4.1, 5.0)
        };
        assert!(!retreat.goes(&policy, near));
        assert!(retreat.goes(&policy, moment(4.1, 5.0)) && retreat.is_active());
        assert!(retreat.goes(&policy, moment(6.0, 4.8)));
        assert!(!retreat.goes(&policy, moment(9.0, 4.59)) && !retreat.is_active());
        let none = DetourPolicy {
            retreat_m: 0.0,
            ..policy
        };
        assert!(!retreat.goes(&none, moment(20.0, 4.59)));
    }

    #[test]
    fn it_is_tried_a_few_times_in_one_place() {
        let (mut retreat, policy) = (Retreat::default(), DetourPolicy::default());
        let mut begun_at = |x_m: f64| {
            let begins = retreat.goes(&policy, moment(10.0, x_m));
            retreat.end();
            begins
        };
        assert!(begun_at(5.0) && begun_at(4.6) && begun_at(5.1));
        assert!(!begun_at(5.0) && !begun_at(4.2));
        assert!(begun_at(6.1), "elsewhere");
        assert_eq!(retreat.begun, 4);
    }
}
