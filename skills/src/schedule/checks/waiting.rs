//! Whether areas are long enough to wait in.

use super::findings::Findings;
use super::reach::RobotReach;
use super::role::{Resolved, States};
use description::keys::rounded;

/// Where each area is somebody's, a robot that may not go on yet must stand in its area alone: else it keeps the area behind,
/// and may wait for a robot that waits for that.
pub(super) fn check(states: &States<'_>, reach: &RobotReach, findings: &mut Findings) {
    if !states.site.areas_managed {
        return;
    }
    for state in { states.all() }.filter(|state| is_passed(states, state)) {
        let needed_m = reach.footprint.front_m
            + reach.footprint.rear_m
            + reach.ahead_of_border_m
            + reach.behind_border_m;
        let Some(length_m) = { length_m(state) }.filter(|length_m| *length_m < needed_m) else {
            continue;
        };
        findings.wrong(
            states.key(state.state),
            format!(
                "area `{}`, where the robot waits in {} m of its lane",
                state.area.id,
                rounded(length_m)
            ),
            format!(
                "at least {} m: the body and what it keeps from both borders while it knows its place as at its start; or the area behind in the state's `also`",
                rounded(needed_m)
            ),
        );
    }
}

/// The robot drives through this area alone, from another one into another one.
fn is_passed(states: &States<'_>, state: &Resolved<'_>) -> bool {
    let own = |name: &str| {
        let other = states.named(name);
        other.is_none_or(|other| other.state.areas().all(|area| area == state.area.id))
    };
    let name = state.state.name.as_str();
    let transitions = || states.fsm.transitions.iter();
    state.skill.controller.follows_lane()
        && own(name)
        && transitions().any(|way| way.to == name && !own(&way.from))
        && transitions().any(|way| way.from == name && !own(&way.to))
}

/// Of the lane in the area, where it leads in and out.
fn length_m(state: Resolved<'_>) -> Option<f64> {
    let lane = state.lane?;
    let (enter, leave) = state.area.region.clip(&lane.line)?;
    (enter > 0.0 && leave < 1.0).then(|| (leave - enter) * lane.line.length_m())
}
