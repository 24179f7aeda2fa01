//! What the robot is going to do next, as far as its machine shows it: which areas its next manoeuvres take.

use description::areas::AreaIndex;

use super::StatePlan;

/// A manoeuvre that comes soon.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Upcoming {
    /// Its state.
    pub(super) state: usize,
    /// Shortest distance that the robot drives before it begins.
    pub(super) way_m: f64,
}

/// States that may follow on `state`, nearest first, as far as `reaches` accepts their distance; `gap_m` is a lower bound of
/// the distance to an area.
///
/// A state is entered where the first area begins that the state before does not have. So a robot that drives along a lane
/// does not count as near the lane beside it, which follows only after a turn.
pub(super) fn look_ahead(
    states: &[StatePlan],
    state: usize,
    gap_m: impl Fn(AreaIndex) -> f64,
    reaches: impl Fn(usize, f64) -> bool,
) -> Vec<Upcoming> {
    let mut way_m = vec![f64::INFINITY; states.len()];
    let Some(present) = way_m.get_mut(state) else {
        return Vec::new();
    };
    *present = 0.0;
    let mut open = vec![state];
    // Ways never shrink from one state to the next, and a state is opened again only when its way has become shorter.
    while let Some(from) = open.pop() {
        // How much of the present state's own way is left is not known.
        let least_m = if from == state {
            0.0
        } else {
            states[from].least_way_m
        };
        for &to in &states[from].next {
            let Some(target) = states.get(to) else {
                continue;
            };
            let new = { target.areas.iter() }.filter(|area| !states[from].areas.contains(area));
            let border_m = new.map(|&area| gap_m(area)).fold(f64::INFINITY, f64::min);
            let border_m = if border_m.is_finite() { border_m } else { 0.0 };
            let there_m = (way_m[from] + least_m).max(border_m);
            if there_m < way_m[to] && reaches(to, there_m) {
                way_m[to] = there_m;
                open.push(to);
            }
        }
    }
    let mut found: Vec<Upcoming> = { way_m.into_iter().enumerate() }
        .filter(|&(number, way_m)| number != state && way_m.is_finite())
        .map(|(state, way_m)| Upcoming { state, way_m })
        .collect();
    found.sort_by(|a, b| a.way_m.total_cmp(&b.way_m));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::floor::Floor;
    use crate::fleet::tests::{at, setup};

    fn ahead(state: &str, x_m: f64, y_m: f64, theta_rad: f64, reach_m: f64) -> Vec<String> {
        let setup = setup();
        let floor = Floor::new(&setup);
        let place = at(x_m, y_m, theta_rad, 0.01);
        let number = setup.states.iter().position(|one| one.name == state);
        look_ahead(
            &setup.states,
            number.expect("a state"),
            |area| floor.gap_m(area, &place),
            |_, way_m| way_m <= reach_m,
        )
        .into_iter()
        .map(|upcoming| setup.states[upcoming.state].name.clone())
        .collect()
    }

    #[test]
    fn a_state_comes_near_with_the_first_area_that_it_adds() {
        assert!(ahead("drive-1", 3.0, -0.5, 0.0, 1.0).is_empty());
        assert_eq!(ahead("drive-1", 4.5, -0.5, 0.0, 1.0), ["search-2", "end-2"]);
    }

    #[test]
    fn the_lane_beside_is_far_behind_a_turn() {
        // Area 4 lies 0.35 m to the left, but the turn in area 3 comes first.
        assert_eq!(ahead("end-2", 8.0, -0.5, 0.0, 1.0), ["u-turn-3"]);
        assert_eq!(ahead("end-2", 8.0, -0.5, 0.0, 2.5), ["u-turn-3", "drive-4"]);
        // While it turns, it may be done any time.
        assert_eq!(ahead("u-turn-3", 8.8, -0.5, 0.0, 1.0), ["drive-4"]);
    }

    #[test]
    fn events_from_outside_are_not_foreseen() {
        // The lay-by, area 5, lies 0.25 m to the right, and only an order leads there.
        assert!(ahead("drive-1", 4.0, -0.5, 0.0, 0.8).is_empty());
    }

    #[test]
    fn rings_of_states_in_one_area_end() {
        let ring = |next: usize| StatePlan {
            areas: vec![AreaIndex(0)],
            next: vec![next],
            ..StatePlan::default()
        };
        let states = [ring(1), ring(2), ring(0)];
        let found = look_ahead(&states, 0, |_| 0.0, |_, _| true);
        assert_eq!(found.len(), 2);
        assert!(look_ahead(&states, 7, |_| 0.0, |_, _| true).is_empty());
    }
}
