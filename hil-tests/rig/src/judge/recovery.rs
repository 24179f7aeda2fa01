//! Whether robots go on after the last fault.

use crate::scenario::Recovery;

/// The run ends at the same time, which is counted in nanoseconds.
const ROUNDING_S: f64 = 1e-6;

/// Watches one robot after the last fault.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recovering {
    bounds: Option<Recovery>,
    stands_since_s: Option<f64>,
}

impl Recovering {
    /// With the bounds of a scenario; without any nothing is asked.
    pub(super) fn new(bounds: Option<Recovery>) -> Self {
        Self {
            bounds,
            stands_since_s: None,
        }
    }

    /// Takes in whether the robot stands; `missing` says what is left of its goals. Returns what is wrong.
    pub(super) fn look(
        &mut self,
        at_s: f64,
        stands: bool,
        missing: impl FnOnce() -> Option<String>,
    ) -> Option<String> {
        let bounds = self.bounds.filter(|bounds| at_s >= bounds.calm_s)?;
        if !stands {
            self.stands_since_s = None;
        }
        let since_s = { stands }.then(|| *self.stands_since_s.get_or_insert(at_s));
        let stood_s = since_s.map_or(0.0, |since_s| at_s - since_s);
        let late = at_s + ROUNDING_S >= bounds.done_by_s;
        if !late && stood_s <= bounds.longest_stand_s {
            return None;
        }
        let (missing, calm_s) = (missing()?, bounds.calm_s);
        Some(if late {
            let most_s = bounds.done_by_s - calm_s;
            format!(
                "{missing}, expected within {most_s:.1} s from {calm_s:.1} s on, when the last fault was over and robots were helped"
            )
        } else {
            let most_s = bounds.longest_stand_s;
            format!(
                "{missing}, and has stood for more than {most_s:.1} s since the last fault was over"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Recovery = Recovery {
        calm_s: 20.0,
        longest_stand_s: 100.0,
        done_by_s: 320.0,
    };

    fn found(own: &mut Recovering, at_s: f64, stands: bool) -> bool {
        own.look(at_s, stands, || Some("amr-1 has to go to 3".to_owned()))
            .is_some()
    }

    #[test]
    fn a_robot_that_stands_for_too_long_is_found_whatever_the_others_do() {
        let mut own = Recovering::new(Some(BOUNDS));
        // What was before does not count.
        assert!(!found(&mut own, 0.0, true) && !found(&mut own, 19.0, true));
        assert!(!found(&mut own, 20.0, true) && !found(&mut own, 119.0, true));
        assert!(found(&mut own, 120.1, true));
        assert!(!found(&mut own, 121.0, false), "it goes on");
        assert!(!found(&mut own, 122.0, true) && !found(&mut own, 222.0, true));
        let done = own.look(230.0, true, || None);
        assert_eq!(done, None, "who has reached its goals may stand");
        assert!(found(&mut own, 230.0, true));
    }

    #[test]
    fn a_robot_that_moves_and_does_not_arrive_is_found_in_the_end() {
        let mut own = Recovering::new(Some(BOUNDS));
        assert!(!found(&mut own, 319.9, false) && found(&mut own, 320.0, false));
        assert_eq!(own.look(400.0, false, || None), None);
        let mut unbound = Recovering::new(None);
        assert!(!found(&mut unbound, 0.0, true) && !found(&mut unbound, 9000.0, true));
    }
}
