use contract::wire::{AccessGrant, Level, MediatorReport};
use sim::world::{Pose, Truth, Twist, World, WorldConfig};

use super::*;
use crate::network::observations::{Observations, Owning};
use crate::scenario::Scenario;
use crate::testing;
use crate::violation::ViolationKind;

pub(super) const MS: u64 = 1_000_000;

pub(super) fn overtaking() -> Scenario {
    testing::scenario("overtaking")
}

pub(super) fn heard(scenario: &Scenario) -> Observations {
    Observations::new(&scenario.site, &scenario.nets)
}

pub(super) fn truth(at_ms: u64, x_m: f64, y_m: f64) -> Truth {
    Truth {
        time_ns: at_ms * MS,
        pose: Pose::new(x_m, y_m, 0.0),
        twist: Twist::default(),
        clearance_m: 0.5,
        min_clearance_m: 0.5,
        // So far that it has not been carried, wherever it is.
        distance_m: at_ms as f64,
        ..Truth::default()
    }
}

pub(super) fn grant(
    observations: &mut Observations,
    robot: &str,
    area: &str,
    progress: u32,
    at_ms: u64,
) {
    let report = MediatorReport {
        robot_id: robot.into(),
        session: 1,
        access: vec![AccessGrant {
            area: area.into(),
            level: Some(Level {
                run: 1,
                progress,
                ..Level::default()
            }),
            fence: 1,
            ..AccessGrant::default()
        }],
        ..MediatorReport::default()
    };
    observations.answer(&report, at_ms * MS);
}

pub(super) fn observe(judge: &mut Judge, robot: usize, truth: &Truth, observations: &Observations) {
    let world = World::new(WorldConfig::default()).expect("an empty world");
    judge.observe(&Look {
        robot,
        truth,
        world: &world,
        belief: None,
        leave: &[],
        observations,
    });
}

pub(super) fn kinds(judge: &Judge) -> Vec<&str> {
    { judge.violations().iter() }
        .map(|violation| violation.kind.name())
        .collect()
}

#[test]
fn who_enters_without_a_grant_is_found_and_who_stood_there_is_excused() {
    let scenario = overtaking();
    let (mut judge, mut observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
    // It starts in area 1, and its front, 0.32 m ahead, reaches into area 2.
    let border_m = scenario.site.area("1").expect("there").region.max.xy_m()[0];
    let front_at = |at_ms, over_m| truth(at_ms, border_m + over_m - 0.32, -0.5);
    for at_ms in (0..500).step_by(20) {
        observe(&mut judge, 0, &front_at(at_ms, -0.2), &observations);
        observe(&mut judge, 0, &front_at(at_ms + 10, 0.015), &observations);
    }
    assert_eq!((judge.inside(0), kinds(&judge)), (vec!["1"], vec![]));
    observe(&mut judge, 0, &front_at(500, 0.07), &observations);
    observe(&mut judge, 0, &front_at(590, 0.07), &observations);
    assert_eq!(
        kinds(&judge),
        Vec::<&str>::new(),
        "its grant may be heard late"
    );
    observe(&mut judge, 0, &front_at(620, 0.07), &observations);
    assert_eq!(kinds(&judge), ["entry-without-grant"]);
    assert_eq!(judge.violations()[0].at_s, 0.5);
    observe(&mut judge, 0, &front_at(900, 0.07), &observations);
    assert_eq!(judge.violations().len(), 1, "once while it lasts");
    // Having had area 1 and left it, it is not excused there any more.
    grant(&mut observations, "amr-1", "2", 3, 1000);
    grant(&mut observations, "amr-1", "1", 3, 1000);
    observe(&mut judge, 0, &front_at(1100, -0.2), &observations);
    grant(&mut observations, "amr-1", "1", 4, 1200);
    observe(&mut judge, 0, &front_at(3000, -0.2), &observations);
    observe(&mut judge, 0, &front_at(3200, -0.2), &observations);
    assert_eq!(kinds(&judge).len(), 2);
    assert!(judge.violations()[1].detail.contains("area 1"));
}

#[test]
fn who_was_cleared_by_an_operator_is_excused_until_it_leaves() {
    let scenario = overtaking();
    let (mut judge, mut observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
    grant(&mut observations, "amr-1", "1", 3, 0);
    observe(&mut judge, 0, &truth(0, 3.0, -0.4), &observations);
    judge.cleared("1", &["amr-1"]);
    observations.cleared("1", &["amr-1"], 10 * MS);
    for at_ms in (20..1000).step_by(20) {
        observe(&mut judge, 0, &truth(at_ms, 3.0, -0.4), &observations);
    }
    assert_eq!(kinds(&judge), Vec::<&str>::new());
    observe(&mut judge, 0, &truth(1000, 9.0, 0.0), &observations);
    for at_ms in (1020..1300).step_by(20) {
        observe(&mut judge, 0, &truth(at_ms, 3.0, -0.4), &observations);
    }
    assert_eq!(kinds(&judge)[0], "entry-without-grant");
}

/// A second robot of its identity was taken for its next process, which gives back what it is not in.
#[test]
fn who_stands_where_a_clone_gave_its_grant_back_is_excused_until_it_leaves() {
    for (at_s, found) in [(1.0, vec![]), (60.0, vec!["entry-without-grant"])] {
        let mut scenario = overtaking();
        let clone =
            format!("at_s = {at_s:?}\nfor_s = 30.0\nwhat = \"clone-robot\"\nrobot = \"amr-1\"");
        scenario.faults = vec![toml::from_str(&clone).expect("a fault")];
        let (mut judge, mut observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
        observe(&mut judge, 0, &truth(0, 9.0, 0.0), &observations);
        grant(&mut observations, "amr-1", "1", 3, 100);
        let inside = |at_ms| truth(at_ms, 3.0, -0.4);
        for at_ms in (200..2000).step_by(20) {
            observe(&mut judge, 0, &inside(at_ms), &observations);
        }
        assert_eq!(kinds(&judge), Vec::<&str>::new());
        grant(&mut observations, "amr-1", "1", 4, 2000);
        for at_ms in (2000..3000).step_by(20) {
            observe(&mut judge, 0, &inside(at_ms), &observations);
        }
        assert_eq!(kinds(&judge), found);
        observe(&mut judge, 0, &truth(9000, 9.0, 0.0), &observations);
        for at_ms in (9100..9400).step_by(20) {
            observe(&mut judge, 0, &inside(at_ms), &observations);
        }
        assert_eq!(kinds(&judge).last(), Some(&"entry-without-grant"));
        assert_eq!(kinds(&judge).len(), found.len() + 1);
    }
}

#[test]
fn more_robots_than_an_area_holds_are_found() {
    let scenario = overtaking();
    let (mut judge, observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
    observe(&mut judge, 0, &truth(0, 2.5, -0.5), &observations);
    observe(&mut judge, 1, &truth(0, 7.0, -0.5), &observations);
    assert_eq!(kinds(&judge), Vec::<&str>::new());
    observe(&mut judge, 1, &truth(20, 4.0, -0.5), &observations);
    assert_eq!(kinds(&judge), ["over-capacity"]);
}

#[test]
fn contact_and_little_clearance_are_found() {
    let scenario = overtaking();
    let (mut judge, observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
    let near = Truth {
        clearance_m: 0.05,
        ..truth(0, 2.5, -0.5)
    };
    observe(&mut judge, 0, &near, &observations);
    let hit = Truth {
        collisions: 1,
        clearance_m: 0.0,
        ..truth(20, 2.5, -0.5)
    };
    observe(&mut judge, 0, &hit, &observations);
    observe(&mut judge, 0, &hit, &observations);
    assert_eq!(kinds(&judge), ["clearance", "collision", "clearance"][..2]);
}

/// With the tubes' margin for it, until it is away again.
#[test]
fn who_is_driven_by_hand_may_come_nearer() {
    let mut scenario = overtaking();
    let by_hand =
        "at_s = 1.0\nfor_s = 2.0\nwhat = \"teleop\"\nrobot = \"amr-1\"\nmotion = [-0.1, 0.0]";
    scenario.faults = vec![toml::from_str(by_hand).expect("a fault")];
    let tubes = &scenario.robots[0].config.tubes;
    let by_hand_m = scenario.limits.clearance_m - tubes.augment_m + tubes.by_hand_augment_m;
    let looks = |looks: &[(u64, f64)]| {
        let (mut judge, observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
        for (at_ms, clearance_m) in looks {
            let near = Truth {
                clearance_m: *clearance_m,
                ..truth(*at_ms, 2.5, -0.5)
            };
            observe(&mut judge, 0, &near, &observations);
        }
        judge.violations().len()
    };
    let (near_m, away_m) = (by_hand_m + 0.005, 0.2);
    assert_eq!(looks(&[(900, near_m)]), 1, "before");
    assert_eq!(
        looks(&[(1500, near_m), (3500, near_m)]),
        0,
        "and until it is away"
    );
    assert_eq!(looks(&[(1500, near_m), (3500, away_m), (4000, near_m)]), 1);
    assert_eq!(
        looks(&[(1500, by_hand_m - 0.005)]),
        1,
        "too near by hand as well"
    );
}

#[test]
fn two_owners_are_found_when_it_is_not_only_the_order_of_hearing() {
    let scenario = overtaking();
    let own = |robot: &str, granted_ms: u64, released_ms: Option<u64>| Owning {
        area: "1".into(),
        robot: robot.into(),
        fence: granted_ms,
        journal: 0,
        requested_ns: None,
        granted_ns: granted_ms * MS,
        entered_ns: None,
        released_ns: released_ms.map(|ms| ms * MS),
        returned: false,
    };
    let found = |ownings: &[Owning]| two_owners(&scenario.site, ownings, 60_000 * MS).len();
    let good = [
        own("a", 1000, Some(5000)),
        own("b", 4990, Some(9000)),
        own("a", 9000, None),
    ];
    assert_eq!(found(&good), 0);
    assert_eq!(
        found(&[own("a", 1000, Some(5000)), own("b", 2000, None)]),
        1
    );
    assert_eq!(found(&[own("a", 1000, None), own("b", 2000, None)]), 1);
    let late = [own("b", 2000, Some(3000)), own("a", 1000, Some(2500))];
    assert_eq!(found(&late), 1, "whatever their order");
}

#[test]
fn lane_and_speed_are_judged_where_the_scenario_has_limits() {
    let scenario = testing::scenario("lap");
    let (mut judge, observations) = (Judge::new(&scenario, 0, false), heard(&scenario));
    let near = Truth {
        clearance_m: 0.05,
        ..truth(1000, 2.0, -0.5)
    };
    observe(&mut judge, 0, &near, &observations);
    observe(&mut judge, 0, &near, &observations);
    let hit = Truth {
        collisions: 1,
        ..truth(1000, 2.0, -0.5)
    };
    observe(&mut judge, 0, &hit, &observations);
    observe(
        &mut judge,
        0,
        &Truth {
            collisions: 1,
            ..truth(1000, 2.0, -0.35)
        },
        &observations,
    );
    let fast = Truth {
        collisions: 1,
        twist: Twist {
            v_m_s: 0.6,
            ..Twist::default()
        },
        ..truth(1000, 2.0, -0.5)
    };
    observe(&mut judge, 0, &fast, &observations);
    assert_eq!(
        kinds(&judge),
        ["clearance", "collision", "lateral-error", "speed"]
    );
    assert!((judge.max_lateral_error_m(0) - 0.15).abs() < 1e-9);
}

#[test]
fn the_page_of_invariants_has_every_kind_and_no_other() {
    let page = include_str!("INVARIANTS.md");
    let rows = { page.lines() }.filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let mut named: Vec<&str> = rows.collect();
    let mut kinds: Vec<&str> = ViolationKind::ALL.iter().map(|kind| kind.name()).collect();
    named.sort_unstable();
    kinds.sort_unstable();
    assert_eq!(named, kinds);
}
