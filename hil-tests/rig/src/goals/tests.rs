use description::geometry::Rect;
use sim::world::{Pose, Truth, Twist};

use super::Progress;
use crate::figures::Figures;
use crate::scenario::{Goal, Places, Stop};
use crate::testing::scenario;

/// In the corridor.
fn progress(goal: Goal) -> Progress {
    let mut scenario = scenario("lap");
    scenario.robots[0].goal = goal;
    Progress::new(&scenario.site, &scenario.robots[0])
}

fn observe(progress: &mut Progress, at_s: f64, [x_m, y_m]: [f64; 2], v_m_s: f64) {
    let truth = Truth {
        time_ns: (at_s * 1e9) as u64,
        pose: Pose::new(x_m, y_m, 0.0),
        twist: Twist {
            v_m_s,
            ..Twist::default()
        },
        ..Truth::default()
    };
    progress.observe(&truth, &Figures::default());
}

fn stop(x_m: f64, stands_s: f64) -> Stop {
    Stop {
        name: format!("{x_m}"),
        region: Rect::new([x_m, 0.0].into(), [x_m + 1.0, 1.0].into()),
        stands_s,
    }
}

#[test]
fn a_lap_is_two_turns_driven_through() {
    let mut laps = progress(Goal::Laps(1));
    let circuit = [
        [2.0, -0.5],
        [7.0, -0.5],
        [9.0, 0.0],
        [7.0, 0.5],
        [3.0, 0.5],
        [1.0, 0.0],
    ];
    for at_m in circuit {
        observe(&mut laps, 1.0, at_m, 0.4);
    }
    assert_eq!(laps.rounds(), 0, "the second turn has not been left");
    observe(&mut laps, 2.0, [2.0, -0.5], 0.4);
    assert_eq!((laps.rounds(), laps.done_ns()), (1, Some(2_000_000_000)));
}

#[test]
fn places_count_in_their_order_only() {
    let mut way = progress(Goal::Places(Places {
        rounds: 2,
        through: vec![stop(0.0, 0.0), stop(5.0, 0.0)],
        then: vec![stop(9.0, 0.0)],
    }));
    for x_m in [5.5, 9.5, 0.5, 3.0, 9.5, 5.5, 5.6] {
        observe(&mut way, 1.0, [x_m, 0.5], 0.4);
    }
    assert_eq!(
        way.missing("amr-1", &Figures::default()).as_deref(),
        Some("amr-1 has driven 1 of 2 rounds and has to go to 0")
    );
    for x_m in [0.5, 5.5] {
        observe(&mut way, 2.0, [x_m, 0.5], 0.4);
    }
    assert_eq!((way.rounds(), way.done_ns()), (2, None));
    observe(&mut way, 3.0, [9.5, 0.5], 0.4);
    assert_eq!((way.rounds(), way.done_ns()), (2, Some(3_000_000_000)));
    assert_eq!(way.missing("amr-1", &Figures::default()), None);
}

#[test]
fn where_it_has_to_stand_passing_through_is_not_enough() {
    let mut way = progress(Goal::Places(Places {
        rounds: 1,
        through: vec![stop(0.0, 2.0)],
        then: Vec::new(),
    }));
    observe(&mut way, 0.0, [0.5, 0.5], 0.4);
    observe(&mut way, 9.0, [0.6, 0.5], 0.4);
    for (at_s, v_m_s) in [(10.0, 0.0), (11.5, 0.0), (11.6, 0.1), (12.5, 0.0)] {
        observe(&mut way, at_s, [0.7, 0.5], v_m_s);
    }
    assert_eq!(way.done_ns(), None);
    observe(&mut way, 14.6, [0.7, 0.5], 0.0);
    assert_eq!(way.done_ns(), Some(14_600_000_000));
}
