//! Mistakes in maps that drive a robot into a wall or leave it stranded: gaps in lanes,
//! areas through walls, floor that no robot reaches, lanes and areas too narrow.

use crate::common::{Mistake, SITE, check, edit, lines};
use config::ProblemKind::{Duplicate, Inconsistent, MissingKey, OutOfRange, UnknownReference};
use config::{ConfigError, parse_site};

const DOCKING: &str = include_str!("../../sites/docking.toml");
const COURSE: &str = include_str!("../../sites/course.toml");

fn fails(file: &str, text: &str) -> Option<ConfigError> {
    parse_site(file, text, &[]).err()
}

#[test]
fn floors_of_the_corridor() {
    let mistakes = [
        Mistake {
            name: "a gap in a lane",
            from: "min_m = [5.5, -0.9], max_m = [8.5, 0.0] }\nlane",
            to: "min_m = [5.8, -0.9], max_m = [8.5, 0.0] }\nlane",
            kind: Inconsistent,
            key: "lanes.east",
            line: "[lanes.east]",
            found: "a gap of 0.300 m between areas `1` and `2`, from (5.5, -0.5) to (5.8, -0.5)",
            expected: "areas all along the lane",
            hint: "",
        },
        Mistake {
            name: "an area through a wall",
            from: "region = { min_m = [3.0, -1.6], max_m = [5.0, -0.9] }",
            to: "region = { min_m = [3.0, -1.9], max_m = [5.0, -0.9] }",
            kind: Inconsistent,
            key: "areas.5.region",
            line: "min_m = [3.0, -1.9]",
            found: "a region of which wall `south` cuts off 0.60 m²",
            expected: "with its border inside the walls",
            hint: "",
        },
        Mistake {
            name: "a wall across the way to the shoulder",
            from: "[walls.north]",
            to: "[walls.kerb]\nfrom_m = [2.9, -0.9]\nto_m = [5.1, -0.9]\n\n[walls.north]",
            kind: Inconsistent,
            key: "areas.5.region",
            line: "region = { min_m = [3.0, -1.6]",
            found: "area `5`, which no robot can reach: no open border joins it to the areas where they start",
            expected: "areas that are joined",
            hint: "",
        },
        Mistake {
            name: "a state without an area",
            from: "halt-4 = { area = \"4\", skill = \"stop\" }",
            to: "halt-4 = { skill = \"stop\" }",
            kind: MissingKey,
            key: "fsm.normal.states.halt-4.area",
            line: "halt-4 = {",
            found: "nothing",
            expected: "an area's id",
            hint: "",
        },
    ];
    check(&mistakes, SITE, fails);
}

#[test]
fn an_area_beside_the_walls_is_reached_by_nobody() {
    let text = format!(
        "{SITE}\n[areas.yard]\nregion = {{ min_m = [3.0, 1.6], max_m = [5.0, 2.6] }}\nmanoeuvre = \"any\"\nspeed_limit_m_s = 0.2\ndeviation_limit_m = 0.3\n"
    );
    let error = fails("some.toml", &text).expect("refused");
    let [problem] = error.problems() else {
        panic!("{}", lines(&error));
    };
    assert_eq!(problem.key, "areas.yard.region");
}

/// A pillar or a short wall inside an area is no border.
#[test]
fn a_stub_of_wall_inside_an_area_is_accepted() {
    for wall in [
        "from_m = [9.4, 0.6]\nto_m = [9.4, 1.6]",
        "from_m = [9.3, 1.0]\nto_m = [9.6, 1.2]",
    ] {
        let text = edit(
            SITE,
            "[walls.north]",
            &format!("[walls.stub]\n{wall}\n\n[walls.north]"),
        );
        if let Some(error) = fails("some.toml", &text) {
            panic!("{}", lines(&error));
        }
    }
}

#[test]
fn states_with_lanes_and_areas_of_their_own() {
    let middle =
        "\nmiddle-in = { area = \"access-in\", also = [\"access-out\"], lane = \"middle-in\"";
    let mistakes = [
        Mistake {
            name: "unknown lane",
            from: "lane = \"in\", skill = \"back-off\"",
            to: "lane = \"inn\", skill = \"back-off\"",
            kind: UnknownReference,
            key: "fsm.small.states.back-off.lane",
            line: "\"inn\"",
            found: "lane `inn`, which does not exist",
            expected: "the name of a lane",
            hint: "did you mean `in`?",
        },
        Mistake {
            name: "unknown further area",
            from: middle,
            to: "\nmiddle-in = { area = \"access-in\", also = [\"access\"], lane = \"middle-in\"",
            kind: UnknownReference,
            key: "fsm.big.states.middle-in.also[0]",
            line: "[\"access\"]",
            found: "area `access`, which does not exist",
            expected: "the name of an area",
            hint: "",
        },
        Mistake {
            name: "the same area twice",
            from: middle,
            to: "\nmiddle-in = { area = \"access-in\", also = [\"access-in\"], lane = \"middle-in\"",
            kind: Duplicate,
            key: "fsm.big.states.middle-in.also[0]",
            line: "also = [\"access-in\"], lane = \"middle-in\", skill = \"follow-middle\"",
            found: "area `access-in` a second time",
            expected: "each area once",
            hint: "",
        },
    ];
    check(&mistakes, DOCKING, fails);
}

#[test]
fn skills_of_the_course() {
    let mistakes = [
        Mistake {
            name: "a creep without a speed",
            from: "distance_m = -0.70\nspeed_m_s = 0.10\n",
            to: "distance_m = -0.70\n",
            kind: MissingKey,
            key: "skills.back-off.speed_m_s",
            line: "[skills.back-off]",
            found: "nothing",
            expected: "a speed above 0",
            hint: "",
        },
        Mistake {
            name: "a creep to nowhere",
            from: "distance_m = -0.70",
            to: "distance_m = 0.0",
            kind: OutOfRange,
            key: "skills.back-off.distance_m",
            line: "distance_m = 0.0",
            found: "0.0",
            expected: "a way of at least 0.01 m",
            hint: "",
        },
        Mistake {
            name: "two places to stop",
            from: "before_area = \"J\"\nmargin_m = 0.10",
            to: "before_area = \"J\"\npose = { x_m = 7.0, y_m = -0.5, theta_rad = 0.0 }",
            kind: Inconsistent,
            key: "skills.stop-before-junction.pose",
            line: "pose = { x_m = 7.0",
            found: "`before_area` and `pose`",
            expected: "`before_area` or `pose`, or neither",
            hint: "",
        },
        Mistake {
            name: "a margin from nothing",
            from: "before_area = \"J\"\nmargin_m = 0.10",
            to: "pose = { x_m = 7.0, y_m = -0.5, theta_rad = 0.0 }\nmargin_m = 0.10",
            kind: Inconsistent,
            key: "skills.stop-before-junction.margin_m",
            line: "margin_m = 0.10\nperception",
            found: "a margin",
            expected: "it with `before_area`",
            hint: "",
        },
        Mistake {
            name: "an unknown border",
            from: "before_area = \"J\"",
            to: "before_area = \"X\"",
            kind: UnknownReference,
            key: "skills.stop-before-junction.before_area",
            line: "before_area = \"X\"",
            found: "area `X`, which does not exist",
            expected: "the name of an area",
            hint: "",
        },
        Mistake {
            name: "no time",
            from: "after_s = 2.0",
            to: "after_s = 0",
            kind: OutOfRange,
            key: "monitors.waited.after_s",
            line: "after_s = 0",
            found: "0",
            expected: "a duration above 0",
            hint: "",
        },
        Mistake {
            name: "a speed for what stands",
            from: "[skills.stop]\ncontroller = \"stop\"",
            to: "[skills.stop]\ncontroller = \"stop\"\nspeed_m_s = 0.2",
            kind: config::ProblemKind::UnknownKey,
            key: "skills.stop.speed_m_s",
            line: "speed_m_s = 0.2\nperception = \"A\"\nmonitors = []",
            found: "unknown key `speed_m_s`",
            expected: "in [skills.stop]",
            hint: "",
        },
    ];
    check(&mistakes, COURSE, fails);
}
