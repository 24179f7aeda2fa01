//! The site file: what ships loads, and every kind of mistake is named precisely.

use crate::common::{Mistake, SITE, check, edit, lines};
use config::ProblemKind::{
    Duplicate, Inconsistent, MissingKey, OutOfRange, UnknownKey, UnknownReference, WrongType,
};
use config::{ConfigError, SiteConfig, load_site, parse_site};
use description::site::{ControllerConfig, Feature, MonitorKind, RegionRef, TurnDirection};

fn fails(file: &str, text: &str) -> Option<ConfigError> {
    parse_site(file, text, &[]).err()
}

fn shipped() -> SiteConfig {
    load_site("sites/corridor.toml", &[]).unwrap_or_else(|error| panic!("{}", lines(&error)))
}

#[test]
fn the_shipped_site_is_the_corridor() {
    let site = shipped();
    assert!(!site.areas_managed);
    let areas: Vec<&str> = site.areas.iter().map(|area| area.id.as_str()).collect();
    assert_eq!(areas, ["1", "2", "3", "4", "5", "6", "7"]);
    assert_eq!(
        site.area_at([8.8, -0.5].into())
            .map(|area| area.id.as_str()),
        Some("3")
    );
    assert_eq!(
        site.area_at([1.2, 0.5].into()).map(|area| area.id.as_str()),
        Some("7")
    );
    assert_eq!(site.perception_kinds["B"].searches, [Feature::LaneEnd]);
    assert_eq!(
        site.perception_kinds["C"].tracks,
        [Feature::Corridor, Feature::LaneEnd]
    );
    assert_eq!(
        site.skill("u-turn-left").unwrap().controller,
        ControllerConfig::UTurn {
            direction: TurnDirection::Left,
            radius_m: 0.5
        }
    );
    assert_eq!(
        site.monitor("in-2").unwrap().kind,
        MonitorKind::RegionReached {
            region: site.area("2").unwrap().region,
            of: RegionRef::Area("2".to_owned())
        }
    );
    let start = site.robots["amr-1"].start;
    assert_eq!((start.x_m, start.y_m, start.theta_rad), (2.0, -0.5, 0.0));
}

#[test]
fn a_lap_goes_through_areas_1_2_3_4_6_7_and_raises_lap() {
    let site = shipped();
    let fsm = &site.fsm["normal"];
    let mut state = fsm.initial.as_str();
    let (mut areas, mut outputs) = (Vec::new(), Vec::new());
    for event in [
        "in-2",
        "end-stable",
        "lane-ended",
        "turned",
        "in-6",
        "end-stable",
        "lane-ended",
        "turned",
    ] {
        let area = fsm.state(state).unwrap().area.as_str();
        if areas.last() != Some(&area) {
            areas.push(area);
        }
        let transition = fsm
            .transitions
            .iter()
            .find(|t| t.from == state && t.on == event)
            .unwrap();
        outputs.extend(transition.outputs.iter().map(String::as_str));
        state = &transition.to;
    }
    assert_eq!(state, fsm.initial);
    assert_eq!(areas, ["1", "2", "3", "4", "6", "7"]);
    assert_eq!(outputs, ["lap"]);
}

#[test]
fn map() {
    let mistakes = [
        Mistake {
            name: "the same area twice",
            from: "[areas.4]",
            to: "[areas.3]",
            kind: Duplicate,
            key: "areas.3",
            line: "[areas.3]\nregion = { min_m = [4.5",
            found: "`3` a second time",
            expected: "each name once",
            hint: "",
        },
        Mistake {
            name: "areas on the same floor",
            from: "min_m = [5.5, -0.9], max_m = [8.5, 0.0]",
            to: "min_m = [5.0, -0.9], max_m = [8.5, 0.0]",
            kind: Inconsistent,
            key: "areas.2.region",
            line: "min_m = [5.0, -0.9]",
            found: "a region that overlaps area `1`",
            expected: "areas that share no floor",
            hint: "",
        },
        Mistake {
            name: "corners the wrong way round",
            from: "min_m = [8.5, -1.6], max_m = [10.0, 1.6] }\ncapacity",
            to: "min_m = [10.0, -1.6], max_m = [8.5, 1.6] }\ncapacity",
            kind: Inconsistent,
            key: "areas.3.region.max_m",
            line: "min_m = [10.0, -1.6]",
            found: "[8.5, 1.6]",
            expected: "a corner north-east of min_m [10.0, -1.6]",
            hint: "",
        },
        Mistake {
            name: "NaN in a point",
            from: "from_m = [0.0, 1.6]",
            to: "from_m = [0.0, nan]",
            kind: OutOfRange,
            key: "walls.north.from_m[1]",
            line: "from_m = [0.0, nan]",
            found: "NaN",
            expected: "a position",
            hint: "",
        },
        Mistake {
            name: "a point in space",
            from: "from_m = [0.0, 1.6]",
            to: "from_m = [0.0, 1.6, 0.0]",
            kind: WrongType,
            key: "walls.north.from_m",
            line: "1.6, 0.0]",
            found: "an array of 3 values",
            expected: "[x, y], each a position",
            hint: "",
        },
        Mistake {
            name: "negative limit",
            from: "speed_limit_m_s = 0.20",
            to: "speed_limit_m_s = -0.20",
            kind: OutOfRange,
            key: "areas.5.speed_limit_m_s",
            line: "speed_limit_m_s = -0.20",
            found: "-0.2",
            expected: "a speed above 0",
            hint: "",
        },
        Mistake {
            name: "managed is missing",
            from: "managed = false\n",
            to: "",
            kind: MissingKey,
            key: "areas.managed",
            line: "[areas]",
            found: "nothing",
            expected: "true or false",
            hint: "",
        },
        Mistake {
            name: "unknown lane",
            from: "lane = \"shoulder\"",
            to: "lane = \"sholder\"",
            kind: UnknownReference,
            key: "areas.5.lane",
            line: "\"sholder\"",
            found: "lane `sholder`, which does not exist",
            expected: "the name of a lane",
            hint: "did you mean `shoulder`?",
        },
        Mistake {
            name: "a lane elsewhere",
            from: "lane = \"shoulder\"",
            to: "lane = \"west\"",
            kind: Inconsistent,
            key: "areas.5.lane",
            line: "lane = \"west\"\ncapacity = 1\nmanoeuvre = \"stop\"",
            found: "lane `west`, which does not pass through the area",
            expected: "a lane through the area's region",
            hint: "",
        },
        Mistake {
            name: "a lane that ends in no area",
            from: "to_m = [5.0, -1.2]",
            to: "to_m = [5.4, -1.2]",
            kind: Inconsistent,
            key: "lanes.shoulder.to_m",
            line: "to_m = [5.4, -1.2]",
            found: "[5.4, -1.2], which is in no area",
            expected: "an end of the lane inside an area",
            hint: "",
        },
        Mistake {
            name: "a lane of no length",
            from: "from_m = [3.0, -1.2]",
            to: "from_m = [5.0, -1.2]",
            kind: Inconsistent,
            key: "lanes.shoulder.to_m",
            line: "to_m = [5.0, -1.2]",
            found: "[5.0, -1.2], 0 m from `from_m`",
            expected: "an end at least 0.01 m away",
            hint: "",
        },
        Mistake {
            name: "unknown wall",
            from: "end_wall = \"east\"",
            to: "end_wall = \"feast\"",
            kind: UnknownReference,
            key: "lanes.east.end_wall",
            line: "\"feast\"",
            found: "wall `feast`, which does not exist",
            expected: "the name of a wall",
            hint: "did you mean `east`?",
        },
        Mistake {
            name: "the wall behind",
            from: "end_wall = \"east\"",
            to: "end_wall = \"west\"",
            kind: Inconsistent,
            key: "lanes.east.end_wall",
            line: "end_wall = \"west\"",
            found: "wall `west`, which is not ahead of the lane's end",
            expected: "the wall that the lane runs up to",
            hint: "",
        },
        Mistake {
            name: "unknown perception kind",
            from: "kind = \"C\"\nregion = { min_m = [8.5",
            to: "kind = \"D\"\nregion = { min_m = [8.5",
            kind: UnknownReference,
            key: "perception.zones.C-east.kind",
            line: "kind = \"D\"",
            found: "perception kind `D`, which does not exist",
            expected: "the name of a perception kind",
            hint: "",
        },
        Mistake {
            name: "unknown feature",
            from: "searches = [\"lane-end\"]",
            to: "searches = [\"laneend\"]",
            kind: OutOfRange,
            key: "perception.kinds.B.searches[0]",
            line: "laneend",
            found: "text \"laneend\"",
            expected: "`corridor`, `lane-end` or `walls`",
            hint: "did you mean `lane-end`?",
        },
        Mistake {
            name: "unknown key in an area",
            from: "deviation_limit_m = 0.20",
            to: "deviation_limit_m = 0.20\nspeed_limit = 1",
            kind: UnknownKey,
            key: "areas.5.speed_limit",
            line: "speed_limit = 1",
            found: "unknown key `speed_limit`",
            expected: "in [areas.5]",
            hint: "",
        },
    ];
    check(&mistakes, SITE, fails);
}

#[test]
fn monitors_and_skills() {
    let mistakes = [
        Mistake {
            name: "unknown area",
            from: "area = \"7\"\n\n[monitors.end",
            to: "area = \"77\"\n\n[monitors.end",
            kind: UnknownReference,
            key: "monitors.in-7.area",
            line: "area = \"77\"",
            found: "area `77`, which does not exist",
            expected: "the name of an area",
            hint: "did you mean `7`?",
        },
        Mistake {
            name: "no region",
            from: "area = \"5\"\n",
            to: "",
            kind: MissingKey,
            key: "monitors.in-5.area",
            line: "[monitors.in-5]",
            found: "none of them",
            expected: "exactly one of `area`, `zone` and `region`",
            hint: "",
        },
        Mistake {
            name: "two regions",
            from: "area = \"5\"\n",
            to: "area = \"5\"\nzone = \"A-east\"\n",
            kind: Inconsistent,
            key: "monitors.in-5.area",
            line: "area = \"5\"",
            found: "2 of them",
            expected: "exactly one of `area`, `zone` and `region`",
            hint: "",
        },
        Mistake {
            name: "unknown monitor kind",
            from: "kind = \"deviation\"",
            to: "kind = \"deviatoin\"",
            kind: OutOfRange,
            key: "monitors.strayed.kind",
            line: "deviatoin",
            found: "text \"deviatoin\"",
            expected: "`deviation`",
            hint: "did you mean `deviation`?",
        },
        Mistake {
            name: "a key of another monitor kind",
            from: "[monitors.turned]\nkind = \"manoeuvre-done\"",
            to: "[monitors.turned]\nkind = \"manoeuvre-done\"\nscans = 5",
            kind: UnknownKey,
            key: "monitors.turned.scans",
            line: "scans = 5\n\n[monitors.strayed]",
            found: "unknown key `scans`",
            expected: "in [monitors.turned]: `kind`",
            hint: "",
        },
        Mistake {
            name: "unknown monitor",
            from: "monitors = [\"turned\"]",
            to: "monitors = [\"tuned\"]",
            kind: UnknownReference,
            key: "skills.u-turn-left.monitors[0]",
            line: "\"tuned\"",
            found: "monitor `tuned`, which does not exist",
            expected: "the name of a monitor",
            hint: "did you mean `turned`?",
        },
        Mistake {
            name: "unknown perception kind of a skill",
            from: "perception = \"B\"",
            to: "perception = \"b\"",
            kind: UnknownReference,
            key: "skills.search-end.perception",
            line: "perception = \"b\"",
            found: "perception kind `b`, which does not exist",
            expected: "the name of a perception kind",
            hint: "",
        },
        Mistake {
            name: "no radius",
            from: "radius_m = 0.5\n",
            to: "",
            kind: MissingKey,
            key: "skills.u-turn-left.radius_m",
            line: "[skills.u-turn-left]",
            found: "nothing",
            expected: "a length above 0",
            hint: "",
        },
    ];
    check(&mistakes, SITE, fails);
}

#[test]
fn state_machines() {
    let mistakes = [
        Mistake {
            name: "unknown state",
            from: "on = \"in-2\", to = \"search-2\"",
            to: "on = \"in-2\", to = \"serach-2\"",
            kind: UnknownReference,
            key: "fsm.normal.transitions[0].to",
            line: "serach-2",
            found: "state `serach-2`, which does not exist",
            expected: "the name of a state",
            hint: "did you mean `search-2`?",
        },
        Mistake {
            name: "unknown initial state",
            from: "initial = \"drive-1\"",
            to: "initial = \"begin\"",
            kind: UnknownReference,
            key: "fsm.normal.initial",
            line: "initial = \"begin\"",
            found: "state `begin`, which does not exist",
            expected: "the name of a state",
            hint: "there are `drive-1`, ",
        },
        Mistake {
            name: "unknown event",
            from: "from = \"drive-4\", on = \"in-6\"",
            to: "from = \"drive-4\", on = \"in6\"",
            kind: UnknownReference,
            key: "fsm.normal.transitions[4].on",
            line: "\"in6\"",
            found: "event `in6`, which does not exist",
            expected: "the name of an event",
            hint: "did you mean `in-6`?",
        },
        Mistake {
            name: "an event that the skill does not monitor",
            from: "from = \"drive-4\", on = \"in-6\"",
            to: "from = \"drive-4\", on = \"in-5\"",
            kind: Inconsistent,
            key: "fsm.normal.transitions[4].on",
            line: "on = \"in-5\"",
            found: "`in-5`, which skill `follow-lane` does not monitor",
            expected: "an event that can occur in the state",
            hint: "",
        },
        Mistake {
            name: "unknown skill",
            from: "end-6 = { area = \"6\", skill = \"end-of-lane\" }",
            to: "end-6 = { area = \"6\", skill = \"end-of-line\" }",
            kind: UnknownReference,
            key: "fsm.normal.states.end-6.skill",
            line: "end-of-line",
            found: "skill `end-of-line`, which does not exist",
            expected: "the name of a skill",
            hint: "did you mean `end-of-lane`?",
        },
        Mistake {
            name: "unknown area of a state",
            from: "end-6 = { area = \"6\"",
            to: "end-6 = { area = \"sixteen\"",
            kind: UnknownReference,
            key: "fsm.normal.states.end-6.area",
            line: "sixteen",
            found: "area `sixteen`, which does not exist",
            expected: "the name of an area",
            hint: "there are `1`, `2`,",
        },
        Mistake {
            name: "a state that cannot be reached",
            from: "halt-6 = {",
            to: "halt-7 = { area = \"7\", skill = \"stop\" }\nhalt-6 = {",
            kind: Inconsistent,
            key: "fsm.normal.states.halt-7",
            line: "halt-7 =",
            found: "state `halt-7`, which no transitions lead to",
            expected: "states that can be reached from `drive-1`",
            hint: "",
        },
        Mistake {
            name: "two ways out on one event",
            from: "    # The lane's end was never found",
            to: "    { from = \"drive-1\", on = \"in-2\", to = \"halt-1\" },\n    # The lane's end was never found",
            kind: Duplicate,
            key: "fsm.normal.transitions[8]",
            line: "{ from = \"drive-1\", on = \"in-2\", to = \"halt-1\" }",
            found: "a second transition from `drive-1` on `in-2`",
            expected: "at most one for a state and an event",
            hint: "",
        },
        Mistake {
            name: "the same state twice",
            from: "halt-6 = {",
            to: "halt-4 = {",
            kind: Duplicate,
            key: "fsm.normal.states.halt-4",
            line: "halt-4 = { area = \"6\"",
            found: "`halt-4` a second time",
            expected: "each name once",
            hint: "",
        },
        Mistake {
            name: "an external event that a monitor raises",
            from: "external = [\"reset\"]",
            to: "external = [\"reset\", \"turned\"]",
            kind: Duplicate,
            key: "fsm.normal.external[1]",
            line: "external =",
            found: "`turned`, which is a monitor's or stands here already",
            expected: "events of other origin",
            hint: "",
        },
        Mistake {
            name: "a misspelt key in a transition",
            from: "from = \"end-2\", on = \"lane-ended\"",
            to: "from = \"end-2\", when = \"lane-ended\"",
            kind: UnknownKey,
            key: "fsm.normal.transitions[2].when",
            line: "when =",
            found: "unknown key `when`",
            expected: "`from`, `on`, `to` or `outputs`",
            hint: "",
        },
    ];
    // The last one cannot be guessed, so `on` is missing as well.
    let (last, others) = mistakes.split_last().unwrap();
    check(others, SITE, fails);
    let error = fails("some.toml", &edit(SITE, last.from, last.to)).unwrap();
    let keys: Vec<&str> = error
        .problems()
        .iter()
        .map(|problem| problem.key.as_str())
        .collect();
    assert_eq!(keys, [last.key, "fsm.normal.transitions[2].on"]);
}

#[test]
fn robots() {
    let start = "start = { x_m = 2.0, y_m = -0.5, theta_rad = 0.0 }";
    let mistakes = [
        Mistake {
            name: "a start in no area",
            from: start,
            to: "start = { x_m = 2.0, y_m = -1.5, theta_rad = 0.0 }",
            kind: Inconsistent,
            key: "robots.amr-1.start",
            line: "[robots.amr-1]",
            found: "(2.0, -1.5), which is in no area",
            expected: "a start inside an area",
            hint: "",
        },
        Mistake {
            name: "a start in another area than the first state's",
            from: start,
            to: "start = { x_m = 6.0, y_m = -0.5, theta_rad = 0.0 }",
            kind: Inconsistent,
            key: "robots.amr-1.start",
            line: "start = { x_m = 6.0",
            found: "(6.0, -0.5), which is in area `2`",
            expected: "a start in area `1` of its first state, `drive-1`",
            hint: "",
        },
        Mistake {
            name: "a start against the lane",
            from: start,
            to: "start = { x_m = 2.0, y_m = -0.5, theta_rad = 3.14 }",
            kind: Inconsistent,
            key: "robots.amr-1.start.theta_rad",
            line: "start = { x_m = 2.0",
            found: "3.14",
            expected: "within 45° of lane `east`",
            hint: "",
        },
        Mistake {
            name: "a start beside the lane",
            from: start,
            to: "start = { x_m = 2.0, y_m = -0.1, theta_rad = 0.0 }",
            kind: Inconsistent,
            key: "robots.amr-1.start",
            line: "start = { x_m = 2.0",
            found: "(2.0, -0.1), 0.400 m from lane `east`",
            expected: "at most the area's deviation limit, 0.3 m",
            hint: "",
        },
        Mistake {
            name: "unknown role",
            from: "role = \"normal\"",
            to: "role = \"emergency\"",
            kind: UnknownReference,
            key: "robots.amr-1.role",
            line: "\"emergency\"",
            found: "role `emergency`, which does not exist",
            expected: "the name of a role",
            hint: "there are `normal`",
        },
        Mistake {
            name: "unknown start state",
            from: start,
            to: "start = { x_m = 2.0, y_m = -0.5, theta_rad = 0.0 }\nstart_state = \"drive-2\"",
            kind: UnknownReference,
            key: "robots.amr-1.start_state",
            line: "start_state = ",
            found: "state `drive-2`, which does not exist",
            expected: "the name of a state",
            hint: "did you mean `drive-1`?",
        },
    ];
    let mut mistakes = Vec::from(mistakes);
    mistakes[0].line = "start = { x_m = 2.0";
    check(&mistakes, SITE, fails);
}

#[test]
fn more_robots_than_an_area_holds() {
    let text = format!(
        "{SITE}\n[robots.amr-2]\nrole = \"normal\"\nstart = {{ x_m = 4.0, y_m = -0.5, theta_rad = 0.0 }}\n"
    );
    let error = fails("some.toml", &text).unwrap();
    let [problem] = error.problems() else {
        panic!("{}", lines(&error))
    };
    assert_eq!(problem.key, "robots.amr-2.start");
    assert_eq!(problem.found, "2 robots that start in area `1`");
}

#[test]
fn an_empty_file_lacks_its_sections_and_says_no_more() {
    let error = fails("empty.toml", "").unwrap();
    let keys: Vec<&str> = error
        .problems()
        .iter()
        .map(|problem| problem.key.as_str())
        .collect();
    let sections = [
        "name",
        "walls",
        "lanes",
        "areas",
        "perception",
        "monitors",
        "skills",
        "fsm",
        "robots",
    ];
    assert_eq!(keys, sections, "{}", lines(&error));
}

#[test]
fn every_shipped_site_is_good() {
    for (name, managed) in [
        ("corridor", false),
        ("course", false),
        ("docking", true),
        ("overtaking", true),
        ("t-junction", true),
    ] {
        let site = load_site(format!("sites/{name}.toml"), &[])
            .unwrap_or_else(|error| panic!("{name}: {}", lines(&error)));
        assert_eq!(site.name, name);
        assert_eq!(site.areas_managed, managed, "{name}");
        assert_eq!(!site.coordinations.is_empty(), managed, "{name}");
    }
}
