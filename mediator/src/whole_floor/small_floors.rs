//! Floors of a few areas, each for one thing that the verdict must know.

use super::floor::Floor;
use super::route::{Route, Way};
use super::{Death, Verdict, judge_floor};

/// A robot that is in one area after another, by number: from each it goes on to one of these.
fn route(robot: &str, start: u16, next: &[(u16, &[u16])]) -> Route {
    let count = next.iter().flat_map(|(from, to)| to.iter().chain([from]));
    let count = usize::from(count.max().copied().unwrap_or_default()) + 1;
    let areas = (0..count as u16).map(|area| vec![area]).collect();
    let mut own = Route {
        start,
        ..Route::of_nodes(robot, areas)
    };
    for (from, to) in next {
        own.ways[usize::from(*from)] = { to.iter() }
            .map(|&to| Way {
                to,
                outputs: Vec::new(),
            })
            .collect();
    }
    own.look_where_it_leads();
    own
}

fn names(verdict: &Verdict) -> Vec<&str> {
    match verdict {
        Verdict::May { waits, .. } => waits.iter().map(|own| own.robot.as_str()).collect(),
        Verdict::Starves { waits, .. } => vec![&waits.robot],
        Verdict::Never | Verdict::Unknown { .. } => Vec::new(),
    }
}

#[test]
fn a_robot_goes_the_way_that_it_must_and_not_the_one_that_is_free() {
    let other = || route("other", 2, &[(2, &[0]), (0, &[2])]);
    let free = route("one", 0, &[(0, &[1]), (1, &[0])]);
    let verdict = judge_floor(&Floor::of_routes(&[1, 1, 1], vec![free, other()])).verdict;
    assert!(matches!(verdict, Verdict::Never), "{verdict:?}");
    let either = route("one", 0, &[(0, &[1, 2]), (1, &[0]), (2, &[0])]);
    let verdict = judge_floor(&Floor::of_routes(&[1, 1, 1], vec![either, other()])).verdict;
    assert!(matches!(verdict, Verdict::May { .. }), "{verdict:?}");
    assert_eq!(names(&verdict), ["one", "other"]);
}

/// Two take turns in an area that a third one wants.
#[test]
fn who_has_a_smaller_priority_starves_unless_its_requests_age() {
    let shared = |priority: u32, ages: bool| {
        let robots = ["one", "two", "three"].into_iter().zip(1..);
        let routes = robots.map(|(robot, own)| Route {
            priority: if robot == "three" { 0 } else { priority },
            ages,
            ..route(robot, own, &[(own, &[0]), (0, &[own])])
        });
        judge_floor(&Floor::of_routes(&[1, 1, 1, 1], routes.collect()))
    };
    for (priority, ages) in [(0, false), (1, true)] {
        let verdict = shared(priority, ages).verdict;
        assert!(
            matches!(verdict, Verdict::Never),
            "{priority} {ages}: {verdict:?}"
        );
    }
    let findings = shared(1, false);
    let verdict = &findings.verdict;
    assert!(matches!(verdict, Verdict::Starves { .. }), "{verdict:?}");
    assert_eq!(names(verdict), ["three"]);
    assert_eq!(
        who_waits_for(&findings.deaths),
        [
            ("one", vec!["two", "three"]),
            ("two", vec!["one", "three"]),
            ("three", vec!["one", "two"])
        ]
    );
}

/// By the robot that dies.
fn who_waits_for(deaths: &[Death]) -> Vec<(&str, Vec<&str>)> {
    { deaths.iter() }
        .map(|death| {
            let robots = death.robots.iter().map(String::as_str).collect();
            (death.robot.as_str(), robots)
        })
        .collect()
}

/// To and fro between two areas of its own.
fn alone(robot: &str, here: u16) -> Route {
    let there = here + 1;
    route(robot, here, &[(here, &[there]), (there, &[here])])
}

/// These, and twenty robots that have nothing to do with them: too many placements to look at all.
fn crowd(mut routes: Vec<Route>, areas: u16) -> Floor {
    for other in 0..20 {
        routes.push(alone(&format!("other-{other}"), areas + 2 * other));
    }
    let capacities = vec![1; usize::from(areas) + 40];
    Floor::of_routes(&capacities, routes)
}

/// It does not matter how many placements there are besides.
#[test]
#[ignore = "CI makes these runs"]
fn two_that_wait_for_each_other_are_found_on_a_floor_that_is_too_large() {
    let routes = vec![alone("one", 0), route("two", 1, &[(1, &[0]), (0, &[1])])];
    let findings = judge_floor(&crowd(routes, 2));
    let verdict = findings.verdict;
    assert_eq!(names(&verdict), ["one", "two"], "{verdict:?}");
    assert_eq!(findings.deaths, [], "they wait anyway");
    let Verdict::May { steps, .. } = verdict else {
        panic!("they are named");
    };
    assert!(steps.is_empty(), "{steps:?}");
}

/// Two that go to and fro, each by itself, and pass the same area.
fn two_that_share(area: u16, starts: [u16; 2]) -> [Route; 2] {
    [("one", starts[0]), ("two", starts[1])]
        .map(|(robot, own)| route(robot, own, &[(own, &[area]), (area, &[own])]))
}

#[test]
#[ignore = "CI makes these runs"]
fn who_waits_for_a_robot_that_fails_is_told_of_a_floor_that_is_too_large() {
    let findings = judge_floor(&crowd(two_that_share(1, [0, 2]).into(), 3));
    assert!(
        matches!(findings.verdict, Verdict::Unknown { steps } if steps > 0),
        "{:?}",
        findings.verdict
    );
    let deaths = findings.deaths;
    let expected = [("one", vec!["two"]), ("two", vec!["one"])];
    assert_eq!(who_waits_for(&deaths), expected);
    assert_eq!(deaths[0].steps, ["one is granted `1`"]);
    assert_eq!(deaths[0].stands_in, ["0", "1"]);
}

/// Who waits for ever anyway waits for no robot that fails.
#[test]
fn who_waits_for_a_robot_that_fails_is_told_beside_those_that_wait_for_each_other() {
    let mut routes = vec![
        alone("stands", 3),
        route("blocks", 4, &[(4, &[3]), (3, &[4])]),
    ];
    routes.extend(two_that_share(1, [0, 2]));
    let findings = judge_floor(&Floor::of_routes(&[1; 5], routes));
    assert_eq!(names(&findings.verdict), ["stands", "blocks"]);
    let expected = [("one", vec!["two"]), ("two", vec!["one"])];
    assert_eq!(who_waits_for(&findings.deaths), expected);
}

#[test]
fn who_waits_for_a_robot_that_fails_is_told_with_the_way_there() {
    let findings = judge_floor(&Floor::of_routes(&[1; 3], two_that_share(1, [0, 2]).into()));
    assert_eq!(findings.verdict, Verdict::Never);
    let [first, second] = &findings.deaths[..] else {
        panic!("{:?}", findings.deaths);
    };
    // Once it has the area between them, wherever it stands.
    assert_eq!(
        (first.robot.as_str(), &first.robots[..]),
        ("one", &["two".to_owned()][..])
    );
    assert_eq!(first.steps, ["one is granted `1`"]);
    assert_eq!(first.stands_in, ["0", "1"]);
    assert_eq!(
        (second.robot.as_str(), &second.robots[..]),
        ("two", &["one".to_owned()][..])
    );
    assert!(first.coordinations.is_empty());
}
