//! By when a fleet must have come through the faults of its scenario.

use super::fault::{ScriptedFault, ScriptedKind};
use super::model::Scenario;

/// After a fault whoever needs an operator has been helped by then: he resets a robot after 3 s, and perhaps once more after
/// another 3 s; it then has 4 s to bring its bus up and to see good scans for 2 s.
pub const HELPED_AFTER_S: f64 = 10.0;

/// Nobody ends a run because no robot moves while a fault lasts that lasts no longer than this: the longest that are drawn.
const WAITED_FOR_S: f64 = 120.0;

/// The bounds that a scenario sets to its fleet after the last of its faults. Times are seconds since the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovery {
    /// The last fault is over, and the operator has had his time.
    pub calm_s: f64,
    /// From then on no robot stands for longer than this before it has reached its goals: `standstill_s` for each robot of the
    /// fleet, since it may have to wait for each of the others.
    pub longest_stand_s: f64,
    /// By then each robot has reached its goals: the whole patience of the scenario, as if the fleet had begun anew.
    pub done_by_s: f64,
}

impl Scenario {
    /// What the fleet is held to after the last fault; none without faults, where a fleet does not come through all of them by
    /// itself, and where runs of the scenario may end without their goals.
    #[must_use]
    pub fn recovery(&self) -> Option<Recovery> {
        let over_s = self.last_fault_over_s(f64::INFINITY)?;
        self.comes_through().then(|| Recovery {
            calm_s: over_s + HELPED_AFTER_S,
            longest_stand_s: self.standstill_s * self.robots.len() as f64,
            done_by_s: self.longest_s(),
        })
    }

    /// Longest time until all goals are reached; patience begins anew when the last fault is over, and the operator has had his
    /// time.
    #[must_use]
    pub fn longest_s(&self) -> f64 {
        let rounds = self.robots.iter().map(|player| player.goal.rounds()).max();
        let rounds_s = self.patience_round_s * f64::from(rounds.unwrap_or(0));
        let over_s = self.last_fault_over_s(f64::INFINITY);
        let calm_s = over_s.map_or(0.0, |over_s| over_s + HELPED_AFTER_S);
        calm_s + self.patience_s + rounds_s
    }

    /// When the last fault was over that was over by this time; none: no fault was.
    #[must_use]
    pub fn last_fault_over_s(&self, at_s: f64) -> Option<f64> {
        let over = { self.faults.iter() }.map(ScriptedFault::until_s);
        over.filter(|until_s| *until_s <= at_s).reduce(f64::max)
    }

    /// Until when robots may stand at this time: a fault is over, or one lasts that is worth waiting for.
    #[must_use]
    pub fn may_stand_until_s(&self, at_s: f64) -> Option<f64> {
        let mut waited = self.faults.iter().filter(|own| own.for_s <= WAITED_FOR_S);
        let lasts = waited.any(|fault| (fault.at_s..fault.until_s()).contains(&at_s));
        if lasts {
            Some(at_s)
        } else {
            self.last_fault_over_s(at_s)
        }
    }

    /// Whether the fleet must have gone on by itself at this time: faults are over and none lasts, and it comes through all of
    /// them.
    #[must_use]
    pub fn must_have_gone_on(&self, at_s: f64) -> bool {
        let lasts = |fault: &ScriptedFault| (fault.at_s..fault.until_s()).contains(&at_s);
        self.last_fault_over_s(at_s).is_some()
            && !self.faults.iter().any(lasts)
            && self.comes_through()
    }

    /// All faults are of kinds that a fleet comes through, and no run of the scenario may end without its goals.
    fn comes_through(&self) -> bool {
        let overcome = |fault: &ScriptedFault| !ScriptedKind::LASTING.contains(&fault.what);
        self.faults.iter().all(overcome) && self.least_done_share >= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn bounds_follow_from_the_last_fault_and_what_the_scenario_grants() {
        let mut scenario = testing::scenario("overtaking");
        assert_eq!((scenario.recovery(), scenario.longest_s()), (None, 300.0));
        let fault = |what: &str| toml::from_str::<ScriptedFault>(what).expect("a fault");
        scenario.faults = vec![
            fault("at_s = 20.0\nfor_s = 5.0\nwhat = \"pause\"\nrobot = \"amr-1\""),
            fault("at_s = 10.0\nfor_s = 2.0\nwhat = \"kill-mediator\""),
        ];
        scenario.patience_round_s = 7.0;
        let bounds = Recovery {
            calm_s: 35.0,
            longest_stand_s: 300.0,
            done_by_s: 342.0,
        };
        assert_eq!(scenario.recovery(), Some(bounds));
        assert_eq!(scenario.last_fault_over_s(24.0), Some(12.0));
        let asked = [11.0, 15.0, 22.0, 25.0].map(|at_s| scenario.must_have_gone_on(at_s));
        assert_eq!(asked, [false, true, false, true]);
        let stand = [11.0, 15.0, 22.0].map(|at_s| scenario.may_stand_until_s(at_s));
        assert_eq!(stand, [Some(11.0), Some(12.0), Some(22.0)]);
        scenario.faults[0].for_s = 121.0;
        assert_eq!(scenario.may_stand_until_s(22.0), Some(12.0));
        scenario.faults[0].for_s = 5.0;
        scenario.faults[1].what = ScriptedKind::LoseJournal;
        assert_eq!((scenario.recovery(), scenario.longest_s()), (None, 342.0));
        assert!(!scenario.must_have_gone_on(50.0));
    }
}
