//! Files that are well formed and make no robot that could drive there.

use config::ProblemKind::Inconsistent;
use config::{ConfigError, RobotConfig, load_robot, parse_robot, parse_site};
use proptest::prelude::*;

use super::common::mutation::{apply, change, sound};
use super::common::{Mistake, ROBOT, SITE, check, edit, lines, sets};
use super::{FILES, Plan};

const DOCKING: &str = include_str!("../../../../../config/sites/docking.toml");
const COURSE: &str = include_str!("../../../../../config/sites/course.toml");

pub(super) fn robot(file: &str, set: &[&str]) -> RobotConfig {
    load_robot(format!("{FILES}/robots/{file}.toml"), &sets(set))
        .unwrap_or_else(|error| panic!("{}", lines(&error)))
}

pub(super) fn planned(robot: &RobotConfig, file: &str, text: &str) -> Result<Plan, ConfigError> {
    Plan::new(robot.clone(), parse_site(file, text, &[])?)
}

/// Why amr-1 cannot drive this site.
fn fails(file: &str, text: &str) -> Option<ConfigError> {
    planned(&robot("amr-1", &[]), file, text).err()
}

#[test]
fn states_and_skills_of_the_corridor() {
    let mistakes = [
        Mistake {
            name: "a stability that nothing estimates",
            from: "perception = \"B\"",
            to: "perception = \"A\"",
            kind: Inconsistent,
            key: "skills.search-end.monitors[0]",
            line: "monitors = [\"end-stable\"",
            found: "monitor `end-stable` of `lane-end`, which kind `A` neither tracks nor searches",
            expected: "a monitor of something that the skill perceives",
            hint: "",
        },
        Mistake {
            name: "an end of what never ends",
            from: "monitors = []",
            to: "monitors = [\"turned\"]",
            kind: Inconsistent,
            key: "skills.stop.monitors[0]",
            line: "monitors = [\"turned\"]\n\n# ---",
            found: "monitor `turned` for the end of the controller `stop`, which never ends",
            expected: "it with a controller that ends",
            hint: "",
        },
        Mistake {
            name: "a controller that lacks its feature",
            from: "perception = \"C\"\nmonitors = [\"lane-ended\"",
            to: "perception = \"B\"\nmonitors = [\"lane-ended\"",
            kind: Inconsistent,
            key: "skills.end-of-lane.perception",
            line: "perception = \"B\"\nmonitors = [\"lane-ended\"",
            found: "kind `B`, which does not track `lane-end`",
            expected: "a kind that does, for the controller `end-of-lane`",
            hint: "",
        },
        Mistake {
            name: "a radius that misses the lane",
            from: "radius_m = 0.5\n",
            to: "radius_m = 0.4\n",
            kind: Inconsistent,
            key: "skills.u-turn-left.radius_m",
            line: "radius_m = 0.4",
            found: "0.4, which ends 0.800 m to the left of lane `east`",
            expected: "a turn onto lane `west`, 1.000 m to the left: radius 0.500",
            hint: "",
        },
        Mistake {
            name: "a lane that ends before the next area",
            from: "distance_m = 1.2",
            to: "distance_m = 1.6",
            kind: Inconsistent,
            key: "skills.end-of-lane.distance_m",
            line: "distance_m = 1.6",
            found: "1.6, so that `end-2` ends at (8.400, -0.500)",
            expected: "an end inside area `3` of the next state, `u-turn-3`",
            hint: "",
        },
        Mistake {
            name: "a manoeuvre that does not fit the area",
            from: "halt-4 = { area = \"4\", skill = \"stop\" }",
            to: "halt-4 = { area = \"4\", skill = \"u-turn-left\" }",
            kind: Inconsistent,
            key: "fsm.normal.states.halt-4.skill",
            line: "halt-4 = {",
            found: "skill `u-turn-left` with the controller `u-turn`",
            expected: "a skill for the manoeuvre `forward` of area `4`",
            hint: "",
        },
    ];
    check(&mistakes, SITE, fails);
}

#[test]
fn skills_of_the_course() {
    let mistakes = [
        Mistake {
            name: "a stable what",
            from: "feature = \"corridor\"\nscans = 3",
            to: "feature = \"walls\"\nscans = 3",
            kind: Inconsistent,
            key: "monitors.reacquired.feature",
            line: "feature = \"walls\"",
            found: "`walls`, of which there is no estimate",
            expected: "`corridor` or `lane-end`",
            hint: "",
        },
        Mistake {
            name: "a dock that nothing measures",
            from: "distance_m = 0.30\nperception = \"C\"",
            to: "distance_m = 0.30\nperception = \"B\"",
            kind: Inconsistent,
            key: "skills.dock.perception",
            line: "perception = \"B\"\nmonitors = [\"done\"",
            found: "kind `B`, which does not track `lane-end`",
            expected: "for the controller `dock`",
            hint: "",
        },
    ];
    check(&mistakes, COURSE, fails);
}

#[test]
fn a_state_that_lacks_its_lane() {
    let mistakes = [Mistake {
        name: "no lane at all",
        from: "lane = \"in\", skill = \"back-off\"",
        to: "skill = \"back-off\"",
        kind: Inconsistent,
        key: "fsm.small.states.back-off",
        line: "back-off = { area = \"dock\", skill = \"back-off\"",
        found: "state `back-off`, which needs a lane, and neither its area nor its neighbours give one",
        expected: "a lane",
        hint: "",
    }];
    check(&mistakes, DOCKING, fails);
}

#[test]
fn a_lane_far_from_its_state() {
    // The small robots' state: the big ones' is followed by another.
    let next = "\nback-off = { area = \"dock\", lane = \"in\", skill = \"back-off\"";
    let wait = |lane: &str| {
        format!("wait = {{ area = \"dock\", lane = \"{lane}\", skill = \"wait\" }}{next}")
    };
    let text = edit(DOCKING, &wait("in"), &wait("far")).replace(
        "[lanes.middle-in]",
        "[lanes.far]\nfrom_m = [3.0, 0.5]\nto_m = [1.0, 0.5]\n\n[lanes.middle-in]",
    );
    let error = fails("some.toml", &text).expect("refused");
    let problem = &error.problems()[0];
    assert_eq!(
        problem.key,
        "fsm.small.states.wait.lane",
        "{}",
        lines(&error)
    );
    assert_eq!(
        problem.found,
        "lane `far`, which does not touch area `dock`"
    );
}

#[test]
fn a_pose_that_nobody_brings() {
    let text = edit(
        COURSE,
        "{ from = \"drive-6\", on = \"stop\", to = \"stop-6\" },\n    { from = \"stop-6\", on = \"stop\", to = \"stop-6\" },",
        "{ from = \"drive-6\", on = \"near-west\", to = \"stop-6\" },",
    );
    let text = edit(
        &text,
        "{ from = \"drive-6\", on = \"near-west\", to = \"search-6\" },\n",
        "",
    );
    let text = edit(
        &text,
        "{ from = \"stop-6\", on = \"go\", to = \"drive-6\" },",
        "{ from = \"stop-6\", on = \"go\", to = \"search-6\" },",
    );
    let error = fails("some.toml", &text).expect("refused");
    let [problem] = error.problems() else {
        panic!("{}", lines(&error));
    };
    assert_eq!(problem.key, "skills.stop-there.controller");
    assert!(
        problem
            .found
            .contains("in state `stop-6`, which no external event leads to"),
        "{problem}"
    );
}

#[test]
fn a_robot_too_wide_for_its_lane_or_areas() {
    let refused =
        |robot: &RobotConfig, text: &str| planned(robot, "site.toml", text).expect_err("refused");
    // Half a metre to its right is the border of areas 1 and 2.
    let wide = robot("amr-1", &["footprint.right_m=0.41"]);
    let error = refused(&wide, SITE);
    let problem = &error.problems()[0];
    assert_eq!(
        problem.key,
        "fsm.normal.states.drive-1",
        "{}",
        lines(&error)
    );
    assert!(
        problem
            .found
            .starts_with("a body whose right side leaves `1` on lane `east`"),
        "{problem}"
    );
    assert!(
        problem.line.is_some() && problem.expected.contains("0.56 m"),
        "{problem}"
    );
    // In the access the big robot needs both areas.
    let alone = edit(
        DOCKING,
        "\nmiddle-in = { area = \"access-in\", also = [\"access-out\"], lane",
        "\nmiddle-in = { area = \"access-in\", lane",
    );
    let error = refused(&robot("amr-big", &[]), &alone);
    let [problem] = error.problems() else {
        panic!("{}", lines(&error));
    };
    assert_eq!(problem.key, "fsm.big.states.middle-in");
    assert!(
        problem.found.contains("left side leaves `access-in`"),
        "{problem}"
    );
    // Small robots do not care.
    assert!(planned(&robot("amr-1", &["identity.id=amr-2"]), "site.toml", &alone).is_ok());
}

#[test]
fn a_turn_after_docking_needs_room_too() {
    let text = edit(COURSE, "distance_m = -0.70", "distance_m = -0.10");
    let error = fails("some.toml", &text).expect("refused");
    let [problem] = error.problems() else {
        panic!("{}", lines(&error));
    };
    assert_eq!(problem.key, "skills.back-off.distance_m");
    assert_eq!(problem.found, "-0.1, which ends 0.720 m before the wall");
    assert!(problem.expected.contains("above 0.724 m"), "{problem}");
}

#[test]
fn files_that_do_not_fit_together() {
    // What is changed in robot and site; then file, key, found, expected.
    type Case = (
        (&'static str, &'static str),
        (&'static str, &'static str),
        [&'static str; 4],
    );
    let same = ("[fleet]", "[fleet]");
    let same_site = ("[lanes.east]", "[lanes.east]");
    let cases: &[Case] = &[
        (
            ("front_m = 0.32", "front_m = 1.1"),
            same_site,
            [
                "site.toml",
                "skills.end-of-lane.distance_m",
                "1.2",
                "above 1.278 m, which the body takes",
            ],
        ),
        (
            (
                "omega_max_rad_s = 1.5707963267948966",
                "omega_max_rad_s = 0.16",
            ),
            same_site,
            [
                "site.toml",
                "skills.u-turn-left.radius_m",
                "0.5",
                "at least 0.625 m, for the robot's `tubes.omega_max_rad_s`",
            ],
        ),
        (
            ("range_max_m = 4.0", "range_max_m = 0.9"),
            same_site,
            [
                "site.toml",
                "skills.end-of-lane.distance_m",
                "1.2",
                "at most 1.180 m, as far as the lidar sees",
            ],
        ),
        (
            same,
            ("start = { x_m = 2.0, y_m", "start = { x_m = 2.25, y_m"),
            [
                "site.toml",
                "robots.amr-1.start",
                "a start with the body in wall `post`",
                "the whole footprint free",
            ],
        ),
        (
            ("right_m = 0.15", "right_m = 1.15"),
            same_site,
            [
                "site.toml",
                "lanes.east",
                "a lane 1.100 m from wall `south`",
                "more than 1.15 m",
            ],
        ),
    ];
    for (robot_edit, site_edit, [file, key, found, expected]) in cases {
        let robot = edit(ROBOT, robot_edit.0, robot_edit.1);
        let robot = parse_robot("robot.toml", &robot, &[])
            .unwrap_or_else(|error| panic!("{}", lines(&error)));
        let mut site = edit(SITE, site_edit.0, site_edit.1);
        if found.contains("post") {
            site = edit(
                &site,
                "[walls.south]",
                "[walls.post]\nfrom_m = [2.5, -0.65]\nto_m = [2.5, -0.68]\n\n[walls.south]",
            );
            site = edit(&site, "y_m = -0.5, theta", "y_m = -0.55, theta");
        }
        let error = planned(&robot, "site.toml", &site).expect_err(key);
        let problem = error.problems().iter().find(|p| p.key == *key);
        let problem = problem.unwrap_or_else(|| panic!("{key}: {}", lines(&error)));
        assert_eq!(
            (problem.file.as_str(), problem.kind),
            (*file, Inconsistent),
            "{problem}"
        );
        assert_eq!(problem.found, *found, "{problem}");
        assert!(problem.expected.contains(expected), "{problem}");
        assert!(problem.line.is_some(), "{problem}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_never_panic(
        changes in prop::collection::vec(change(), 1..4),
        of_robot in any::<bool>(),
    ) {
        let (mut of, mut at) = (ROBOT.to_owned(), SITE.to_owned());
        let changed = if of_robot { &mut of } else { &mut at };
        *changed = apply(changed, &changes);
        let files = (parse_robot("some.toml", &of, &[]), parse_site("some.toml", &at, &[]));
        if let (Ok(robot), Ok(site)) = files
            && let Err(error) = Plan::new(robot, site)
        {
            sound(&error, if of.lines().count() > at.lines().count() { &of } else { &at });
        }
    }
}
