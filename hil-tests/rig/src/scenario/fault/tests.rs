//! Faults as they stand in files.

use serde::Deserialize;

use super::*;

#[test]
fn the_scenario_that_explains_the_keys_names_every_kind_with_its_keys() {
    let shipped = include_str!("../../../../../config/scenarios/overtaking.toml");
    let lines = { shipped.lines() }.filter_map(|line| line.strip_prefix("#   "));
    let page = lines.collect::<Vec<_>>().join(" ");
    let words: Vec<&str> = { page.split(|c: char| !c.is_ascii_alphanumeric() && c != '-') }
        .filter(|word| !word.is_empty())
        .collect();
    for kind in ScriptedKind::all() {
        let name = kind.name();
        assert!(words.contains(&name.as_str()), "{name} is not named");
    }
}

#[test]
fn a_clock_may_run_slow_and_nothing_else_less_than_never() {
    let fault = |what: &str| -> ScriptedFault {
        let text = format!("at_s = 1.0\nfor_s = 2.0\nwhat = {what:?}\nshare = -0.001");
        toml::from_str(&text).expect("a fault")
    };
    assert_eq!(fault("drift").complaints(&[]), Vec::<String>::new());
    let expected = ["found share = -0.001, expected 0 to 1"];
    assert_eq!(fault("lose").complaints(&[]), expected);
}

#[derive(Deserialize)]
struct File {
    faults: Vec<ScriptedFault>,
}

#[test]
fn a_fault_reads_as_it_is_written() {
    let lines = [
        "{ at_s = 12.5, for_s = 3.0, what = \"partition\", robot = \"amr-1\" }",
        "{ at_s = 0.25, for_s = 0.5, what = \"lose\", share = 0.3 }",
        "{ at_s = 1.0, for_s = 2.0, what = \"delay\", robot = \"amr-1\", by_s = 0.125 }",
        "{ at_s = 1.0, for_s = 2.0, what = \"late-threads\", robot = \"amr-1\", share = 0.5, by_s = 0.125, thread = \"motion\" }",
        "{ at_s = 1.0, for_s = 2.0, what = \"clone-robot\", robot = \"amr-1\", pose = [2.0, -0.5, 90.0] }",
        "{ at_s = 1.0, for_s = 2.0, what = \"teleop\", robot = \"amr-1\", motion = [-0.1, 0.0] }",
        "{ at_s = 1.0, for_s = 2.0, what = \"lose\", share = 0.3, way = \"to-mediator\" }",
        "{ at_s = 1.0, for_s = 2.0, what = \"partition\", robot = \"amr-1\", way = \"to-robots\" }",
    ];
    let text = format!("faults = [{}]", lines.join(", "));
    let File { faults } = toml::from_str(&text).expect("good");
    let shown: Vec<String> = faults.iter().map(ToString::to_string).collect();
    assert_eq!(shown, lines);
    for fault in &faults {
        assert_eq!(
            fault.complaints(&[("amr-1", vec!["motion"])]),
            Vec::<String>::new()
        );
    }
    assert_eq!(
        faults[0].complaints(&[("amr-2", vec![])]),
        ["found robot `amr-1`, expected one of `amr-2`"]
    );
}

#[test]
fn keys_that_do_not_belong_are_named() {
    let fault = ScriptedFault {
        at_s: -1.0,
        for_s: 1.0,
        what: ScriptedKind::KillMediator,
        robot: Some("amr-1".into()),
        share: None,
        by_s: Some(f64::NAN),
        thread: Some("motion".into()),
        pose: Some([0.0, f64::NAN, 0.0]),
        motion: Some([9.0, 0.0]),
        way: Some(Direction::ToRobots),
        mediator: Some(WhichMediator::Second),
    };
    assert_eq!(
        fault.complaints(&[("amr-1", vec!["motion"])]),
        [
            "found at_s = -1, expected 0 to 3600",
            "found by_s = NaN, expected 0 to 60",
            "found `robot`, expected none for this fault",
            "found `by_s`, expected none for this fault",
            "found `thread`, expected none for this fault",
            "found `pose`, expected none for this fault",
            "found `motion`, expected none for this fault",
            "found `way`, expected none for this fault",
            "found `mediator`, expected none for this fault",
            "found pose = [0.0, NaN, 0.0], expected metres, metres and degrees, each from -1000 to 1000",
            "found motion = [9.0, 0.0], expected metres and radians per second, each from -3 to 3",
        ]
    );
    let nobody = ScriptedFault {
        at_s: 1.0,
        what: ScriptedKind::Hang,
        robot: None,
        by_s: None,
        thread: None,
        pose: None,
        motion: None,
        way: None,
        mediator: None,
        ..fault
    };
    assert_eq!(
        nobody.complaints(&[("amr-1", vec!["motion"])]),
        ["found no `robot`, expected one for this fault"]
    );
}
