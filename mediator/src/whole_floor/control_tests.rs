//! Coordinations that take discrete control, shipped and made worse.

use super::tests::{find_at, shipped_net, text};
use super::*;

fn overtaking(edit: impl Fn(String) -> String) -> Findings {
    find_at(
        &edit(text("sites/overtaking")),
        &[shipped_net("overtaking")],
    )
}

/// The normal robot passes the lay-by before it hears that it is to drive into it.
#[test]
fn a_coordination_that_only_its_pre_emption_ends_is_told() {
    let Findings {
        verdict, stills, ..
    } = overtaking(|site| site);
    assert_eq!(verdict, Verdict::Never);
    let [still] = &stills[..] else {
        panic!("{stills:?}");
    };
    assert_eq!(still.coordination, "overtaking");
    let begins = still
        .steps
        .iter()
        .any(|step| step.starts_with("`overtaking` begins with amr-2, amr-1: "));
    assert!(begins, "{still:#?}");
    let text = still.steps.last().expect("it begins first");
    assert_eq!(text, "amr-1 goes on in `1`");
}

/// Its robots are never told to get out of the way.
fn without_pre_emption(site: &str) -> String {
    let (before, _) = { site.split_once("# [coordinations.<id>.preempt]") }.expect("its last part");
    let yields = ["on = \"halt\"", "yield-", "release = { event"];
    let lines = { before.lines() }.filter(|line| !yields.iter().any(|own| line.contains(own)));
    lines.map(|line| format!("{line}\n")).collect()
}

/// And without that both wait for ever: the normal one to be in the lay-by that it has passed.
#[test]
fn robots_of_a_coordination_that_nothing_ends_wait_for_ever() {
    let verdict = overtaking(|site| without_pre_emption(&site)).verdict;
    let Verdict::May { waits, steps } = verdict else {
        panic!("{verdict:?}");
    };
    let robots: Vec<&str> = waits.iter().map(|own| own.robot.as_str()).collect();
    assert_eq!(robots, ["amr-1", "amr-2"], "{steps:#?}");
    assert_eq!(waits[0].has, ["1"], "it has not left it");
}

/// The robot that gives way comes out of the lay-by when it is told to, not before.
#[test]
fn a_robot_whose_machine_has_no_use_for_an_order_is_found() {
    let verdict = overtaking(|site| {
        let own = "    { from = \"wait-5\", on = \"back\", to = \"pull-out\" },\n";
        assert!(site.contains(own));
        without_pre_emption(&site.replace(
            own,
            "    { from = \"park\", on = \"back\", to = \"pull-out\" },\n",
        ))
    })
    .verdict;
    assert!(matches!(verdict, Verdict::May { .. }), "{verdict:?}");
}

/// One stands in the lay-by and waits for the lane, on which another one is told to drive into the lay-by.
#[test]
fn two_that_give_way_to_one_block_each_other() {
    let verdict = overtaking(|site| {
        site.replace(
            "[robots.amr-2]",
            "[robots.amr-3]\nrole = \"normal\"\nstart = { x_m = 7.0, y_m = -0.5, theta_rad = 0.0 }\nstart_state = \"search-2\"\n\n[robots.amr-2]",
        )
    })
    .verdict;
    let Verdict::May { waits, .. } = verdict else {
        panic!("{verdict:?}");
    };
    let mut both: Vec<(&str, &str)> = { waits.iter() }
        .filter(|own| own.robot != "amr-2")
        .map(|own| (own.has[0].as_str(), own.needs[0].as_str()))
        .collect();
    both.sort_unstable();
    assert_eq!(both, [("1", "5"), ("5", "1")], "{waits:?}");
}
