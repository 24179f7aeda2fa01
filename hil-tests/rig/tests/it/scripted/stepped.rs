//! Faults that are scripted and never drawn.
//!
//! Each test says what happens, and that it does not happen without the fault. Nothing that is unsafe does; where a fleet does not
//! come through, the test is to be turned round when it does.

use rig::scenario::{Scenario, ScriptedFault};
use rig::summary::Summary;

use crate::stepped::{ended, plans, watched, without_faults};

/// One run with this fault, and one without.
fn with_and_without(mut scenario: Scenario, fault: &str, seed: u64) -> [Summary; 2] {
    let without = without_faults(&scenario, seed);
    [with(&mut scenario, fault, seed), without]
}

/// As it stands in a file, on one line.
fn fault(text: &str) -> ScriptedFault {
    toml::from_str(&text.replace("; ", "\n")).expect("a fault")
}

/// A run with this fault.
fn with(scenario: &mut Scenario, fault: &str, seed: u64) -> Summary {
    scenario.faults = vec![self::fault(fault)];
    ended(scenario, &plans(scenario), seed).1
}

/// Three robots that meet, for a while.
fn junction() -> Scenario {
    let mut scenario = crate::stepped::scenario("t-junction").with_at_most(1);
    scenario.patience_s = 20.0;
    scenario
}

#[test]
#[ignore = "CI makes these runs"]
fn a_fleet_goes_on_with_a_mediator_that_has_lost_its_journal() {
    let fault = "at_s = 10.0; for_s = 6.0; what = \"lose-journal\"";
    let mut scenario = junction();
    scenario.patience_s = 600.0;
    let [with, without] = with_and_without(scenario, fault, 1);
    assert!(with.passed() && without.passed(), "{with:?}");
    assert_eq!(with.mediator.as_ref().expect("a mediator").starts, 2);
    let faults = ["mediator-silent", "second-mediator"].map(|fault| raised(&with, fault));
    assert_eq!(faults, [1, 0], "{with:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn a_mediator_whose_disk_is_full_answers_nobody_and_goes_on_when_it_has_room() {
    let fault = "at_s = 10.0; for_s = 8.0; what = \"full-disk\"";
    let mut scenario = junction();
    scenario.patience_s = 600.0;
    let [with, without] = with_and_without(scenario, fault, 1);
    assert!(with.passed() && without.passed(), "{with:?}");
    assert_eq!(with.mediator.as_ref().expect("a mediator").starts, 1);
    let faults = ["mediator-silent", "second-mediator"].map(|fault| raised(&with, fault));
    assert_eq!(faults, [1, 0], "{with:?}");
}

#[test]
fn a_mediator_that_two_faults_keep_down_starts_when_the_longer_one_is_over() {
    let mut scenario = crate::stepped::scenario("overtaking");
    let killed = fault("at_s = 20.0; for_s = 4.0; what = \"kill-mediator\"");
    let rebooted = fault("at_s = 22.0; for_s = 8.0; what = \"reboot-mediator\"");
    scenario.faults = vec![killed, rebooted];
    let spans = watched(&scenario, &scenario, &plans(&scenario), 3, 35.0)
        .1
        .mediator;
    let [first, second] = &spans[..] else {
        panic!("{spans:?}");
    };
    // While it writes next.
    assert!((20.0..=21.0).contains(&first.to_s), "{spans:?}");
    assert_eq!(second.from_s.round(), 30.0, "{spans:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn a_mediator_that_ends_again_and_again_while_it_writes_lets_nobody_in_uninvited() {
    let mut scenario = junction();
    scenario.patience_s = 600.0;
    for number in 0..20 {
        let at_s = 5.0 + 3.0 * f64::from(number);
        let what = ["kill", "reboot"][number as usize % 2];
        let fault = format!("at_s = {at_s:?}\nfor_s = 1.5\nwhat = \"{what}-mediator\"");
        scenario
            .faults
            .push(toml::from_str(&fault).expect("a fault"));
    }
    let record = watched(&scenario, &scenario, &plans(&scenario), 2, f64::INFINITY).1;
    assert!(record.summary.passed(), "{:?}", record.summary);
    let ends: Vec<f64> = record.mediator.iter().map(|span| span.to_s).collect();
    assert_eq!(ends.len(), 21, "{ends:?}");
    let waited = |end: &f64| (end - 5.0).rem_euclid(3.0) >= 0.99;
    let writing = ends[..20].iter().filter(|end| !waited(end)).count();
    assert!(writing >= 5, "{ends:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn operators_who_ask_a_mediator_with_a_full_disk_give_up_after_a_while() {
    let mut scenario = crate::stepped::scenario("overtaking");
    scenario.faults = vec![
        fault("at_s = 24.0; for_s = 30.0; what = \"full-disk\""),
        fault("at_s = 24.5; for_s = 1.0; what = \"end-coordination\""),
    ];
    let summary = ended(&scenario, &plans(&scenario), 3).1;
    assert!(summary.passed(), "{summary:?}");
    let mediator = summary.mediator.as_ref().expect("a mediator");
    assert_eq!((mediator.starts, mediator.dropped), (1, Some(0)));
    // Ended by an operator it would not have come to its end.
    assert_eq!(summary.coordinations.len(), 1, "{summary:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn a_mediator_without_its_journal_lets_nobody_in_before_it_has_heard_where_everybody_stands() {
    let mut scenario = crate::stepped::scenario("overtaking");
    scenario.patience_s = 600.0;
    let lost = "at_s = 24.0; for_s = 4.0; what = \"lose-journal\"";
    // It stands in the middle of the corridor, and says so only long after the mediator has started again.
    let killed = "at_s = 23.0; for_s = 30.0; what = \"kill-robot\"; robot = \"amr-1\"";
    // When the first area was granted by the mediator that has started again.
    let first_s = [&[lost][..], &[lost, killed]].map(|faults| {
        let faults = { faults.iter() }.map(|text| toml::from_str(&text.replace("; ", "\n")));
        scenario.faults = faults.map(|fault| fault.expect("a fault")).collect();
        let summary = ended(&scenario, &plans(&scenario), 3).1;
        assert!(summary.passed(), "{summary:?}");
        assert_eq!(summary.mediator.as_ref().expect("a mediator").starts, 2);
        let granted = summary.areas.iter().flat_map(|area| &area.owners);
        let granted_s = granted.map(|own| own.granted_s).filter(|&at_s| at_s > 28.0);
        granted_s.fold(f64::INFINITY, f64::min)
    });
    // 5 s after its start a process that it does not know speaks for its robot's body.
    assert!((33.0..45.0).contains(&first_s[0]), "{first_s:?}");
    assert!((53.0..75.0).contains(&first_s[1]), "{first_s:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn robots_stay_with_their_mediator_beside_a_second_one_and_say_so() {
    let fault = "at_s = 10.0; for_s = 6.0; what = \"second-mediator\"";
    let with = with(&mut junction(), fault, 1);
    assert_eq!(with.violations, [], "{with:?}");
    assert_eq!(raised(&with, "second-mediator"), 1, "{with:?}");
    assert_eq!(raised(&with, "mediator-silent"), 0, "{with:?}");
    // They go on as if it were not there. After a fault a run has patience anew, so the other one needs more of it.
    let mut alone = junction();
    alone.patience_s = with.duration_s;
    let alone = ended(&alone, &plans(&alone), 1).1;
    assert_eq!(alone.duration_s, with.duration_s);
    assert_eq!(alone.violations, []);
    assert_eq!(alone.areas, with.areas);
    assert!(
        alone
            .areas
            .iter()
            .map(|area| area.owners.len())
            .sum::<usize>()
            > 10
    );
}

/// It goes on with their own journal, as one does that was started again: they follow it, and the other one again when it is gone.
#[test]
#[ignore = "CI makes these runs"]
fn robots_follow_one_mediator_at_a_time_beside_a_copy_of_theirs() {
    for (at_s, for_s) in [(4.0, 20.0), (10.0, 6.0), (25.0, 40.0)] {
        let fault = format!("at_s = {at_s:?}; for_s = {for_s:?}; what = \"copied-mediator\"");
        let mut scenario = junction();
        scenario.patience_s = 600.0;
        let with = with(&mut scenario, &fault, 1);
        assert!(with.passed(), "{fault}: {with:?}");
    }
}

/// The one hears only the one, the other only the other: neither of the two knows where both are.
#[test]
#[ignore = "CI makes these runs"]
fn two_mediators_that_hear_a_robot_each_let_both_into_no_area_and_all_go_on_when_they_are_heard_again()
 {
    for what in ["second-mediator", "copied-mediator"] {
        for (at_s, seed) in [(8.0, 1), (24.0, 3)] {
            let mut scenario = crate::stepped::scenario("overtaking");
            let plans = plans(&scenario);
            let lasting = |what: &str| {
                let text = format!("at_s = {at_s:?}\nfor_s = 30.0\n{what}");
                toml::from_str(&text).expect("a fault")
            };
            let apart = [
                "amr-1\"\nmediator = \"first",
                "amr-2\"\nmediator = \"second",
            ];
            let mut faults = vec![lasting(&format!("what = {what:?}"))];
            faults.extend(
                apart.map(|own| lasting(&format!("what = \"partition\"\nrobot = \"{own}\""))),
            );
            scenario.faults = faults;
            scenario.patience_s = 600.0;
            let summary = ended(&scenario, &plans, seed).1;
            assert!(summary.passed(), "{what} at {at_s} s: {summary:?}");
        }
    }
}

/// It is taken for the sleeper's next process, which was carried there: where the one before was stays blocked until somebody has looked.
#[test]
#[ignore = "CI makes these runs"]
fn nobody_is_let_in_where_a_robot_sleeps_while_a_copy_of_it_is_switched_on_elsewhere() {
    let mut scenario = crate::stepped::scenario("overtaking");
    let plans = plans(&scenario);
    scenario.faults = vec![
        fault("at_s = 17.284; for_s = 106.392; what = \"sleep\"; robot = \"amr-1\""),
        fault(
            "at_s = 86.018; for_s = 20.627; what = \"clone-robot\"; robot = \"amr-1\"; pose = [3.0, 0.8, 359.0]",
        ),
    ];
    let summary = ended(&scenario, &plans, 292).1;
    assert!(summary.passed(), "{summary:?}");
    // Found to be the second one, it waits for an operator who starts it again.
    assert_eq!(raised(&summary, "mediator-refused"), 1, "{summary:?}");
    assert_eq!(summary.robots[0].restarted, 1, "{summary:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn a_mediator_with_an_older_journal_hinders_the_overtaking_that_it_forgot() {
    let mut scenario = crate::stepped::scenario("overtaking");
    let without = without_faults(&scenario, 3);
    assert!(without.passed() && without.duration_s < 80.0, "{without:?}");
    // As long again, behind the fault.
    scenario.patience_s = 80.0;
    let fault = "at_s = 24.0; for_s = 4.0; what = \"restore-journal\"";
    let with = with(&mut scenario, fault, 3);
    // Safe, and of no use: until it is broken off, both robots wait for each other.
    assert!(!with.is_done() && with.violations.is_empty(), "{with:?}");
    assert_eq!(with.mediator.expect("a mediator").starts, 2);
    let lasted_s = |summary: &Summary| summary.coordinations[0].duration_s;
    assert!(lasted_s(&without).is_some_and(|lasted_s| lasted_s < 50.0));
    assert_eq!(lasted_s(&with), None, "{with:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn a_coordination_that_an_operator_ends_leaves_robots_that_go_on_by_themselves() {
    let mut scenario = crate::stepped::scenario("overtaking");
    let without = without_faults(&scenario, 3);
    assert!(without.passed(), "{without:?}");
    // It never comes to the end of the coordination that its goal asks for.
    scenario.patience_s = 60.0;
    let fault = "at_s = 35.0; for_s = 1.0; what = \"end-coordination\"";
    let with = with(&mut scenario, fault, 3);
    assert_eq!(with.violations, [], "{with:?}");
    let first = |summary: &Summary| summary.coordinations[0].duration_s.expect("it is over");
    assert!(first(&with) < first(&without), "{with:?}");
}

/// How often the first robot raised this fault.
fn raised(summary: &Summary, fault: &str) -> u64 {
    let mut faults = summary.robots[0].faults.iter();
    faults.find(|own| own.0 == fault).map_or(0, |own| own.1)
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_goes_on_beside_a_clone_of_it_and_both_say_so() {
    let scenario = crate::stepped::scenario("overtaking");
    // It asks from the store. A short while is no longer than a restart takes.
    for (for_s, times) in [(2.5, 0), (10.0, 1)] {
        let fault = "what = \"clone-robot\"; robot = \"amr-1\"";
        let fault = format!("at_s = 24.0; for_s = {for_s:?}; {fault}");
        let [with, without] = with_and_without(scenario.clone(), &fault, 3);
        assert!(with.passed() && without.passed(), "{with:?}");
        assert_eq!(raised(&with, "identity-doubled").min(1), times, "{with:?}");
        assert_eq!(raised(&with, "mediator-silent"), 0, "{with:?}");
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn a_clone_on_the_floor_gets_nothing_and_stands() {
    let scenario = crate::stepped::scenario("overtaking");
    // Where its robot started.
    let fault = "at_s = 40.0; for_s = 45.0; what = \"clone-robot\"; robot = \"amr-1\"; pose = [3.0, 0.5, 180.0]";
    let [with, without] = with_and_without(scenario, fault, 3);
    assert!(without.passed(), "{without:?}");
    assert!(with.passed(), "{with:?}");
    assert_eq!(raised(&with, "identity-doubled"), 1, "{with:?}");
}

/// One that is on its way to an area which it was granted stops before it, when a clone says that it stands there.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_enters_no_area_in_which_a_clone_says_that_it_stands() {
    let mut scenario = crate::stepped::scenario("overtaking");
    scenario.patience_s = 60.0;
    let fault = "at_s = 10.0; for_s = 45.0; what = \"clone-robot\"; robot = \"amr-2\"; pose = [4.0, -0.5, 0.0]";
    let [with, without] = with_and_without(scenario, fault, 43);
    let enters_s = |summary: &Summary| {
        let area = summary.areas.iter().find(|own| own.id == "1");
        let owners = area.into_iter().flat_map(|own| &own.owners);
        let mut entered = owners.filter(|own| own.robot == "amr-1");
        entered.find_map(|own| own.entered_s)
    };
    assert!(with.violations.is_empty() && without.violations.is_empty());
    assert!(
        enters_s(&without).is_some_and(|at_s| at_s < 40.0),
        "{without:?}"
    );
    assert!(enters_s(&with).is_none_or(|at_s| at_s > 55.0), "{with:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn a_fleet_goes_on_after_one_of_its_robots_was_driven_by_hand() {
    let by_hand = |(at_s, for_s): (f64, f64), motion: &str, patience_s: f64| {
        let mut scenario = crate::stepped::scenario("overtaking");
        scenario.patience_s = patience_s;
        let fault = format!(
            "at_s = {at_s:?}\nfor_s = {for_s:?}\nwhat = \"teleop\"\nrobot = \"amr-1\"\nmotion = {motion}"
        );
        scenario.faults = vec![toml::from_str(&fault).expect("a fault")];
        ended(&scenario, &plans(&scenario), 3).1
    };
    // A little aside and back, by somebody who leaves it where it can go on.
    for (at_s, motion) in [
        (4.0, "[0.1, 0.05]"),
        (15.0, "[0.1, -0.05]"),
        (24.0, "[-0.1, 0.0]"),
    ] {
        let summary = by_hand((at_s, 3.0), motion, 600.0);
        assert!(summary.passed(), "{motion} at {at_s} s: {summary:?}");
    }
    // By somebody who does not look: what it stands in stays granted, what it has no leave for is not entered, and nothing is
    // hit. The judge looks at all of it.
    for (at_s, motion) in [
        (4.0, "[0.4, 0.2]"),
        (15.0, "[0.4, -0.2]"),
        (24.0, "[-0.4, 0.2]"),
    ] {
        let summary = by_hand((at_s, 20.0), motion, 30.0);
        assert_eq!(summary.violations, [], "{motion} at {at_s} s: {summary:?}");
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn what_an_operator_clears_no_robot_enters_behind_a_broken_link() {
    let mut scenario = crate::stepped::scenario("overtaking");
    scenario.patience_s = 600.0;
    let fault = |text: String| toml::from_str(&text.replace("; ", "\n")).expect("a fault");
    let plans = plans(&scenario);
    for seed in 1..=4 {
        let at_s = 6.0 + 6.0 * seed as f64;
        let robot = ["amr-1", "amr-2"][seed as usize % 2];
        scenario.faults = vec![
            fault(format!(
                "at_s = {at_s:?}; for_s = 12.0; what = \"partition\"; robot = \"{robot}\""
            )),
            fault(format!(
                "at_s = {at_s:?}; for_s = 12.0; what = \"clear-areas\""
            )),
        ];
        let summary = ended(&scenario, &plans, seed).1;
        assert_eq!(summary.violations, [], "seed {seed}: {summary:?}");
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn nobody_is_let_into_an_area_while_it_is_closed_and_all_go_on_when_it_is_open() {
    for name in ["overtaking", "docking", "t-junction"] {
        let mut scenario = crate::stepped::scenario(name).with_at_most(1);
        let granted = |summary: Summary| -> Vec<f64> {
            assert!(summary.passed(), "{name}: {summary:?}");
            let owners = summary.areas.iter().flat_map(|area| &area.owners);
            // Before and after the operator has done all of it.
            let closed = owners.map(|own| own.granted_s - 20.5);
            closed.filter(|at_s| (0.0..30.0).contains(at_s)).collect()
        };
        assert!(granted(without_faults(&scenario, 3)).len() > 2, "{name}");
        let fault = "at_s = 20.0; for_s = 30.5; what = \"close-areas\"";
        assert_eq!(
            granted(with(&mut scenario, fault, 3)),
            Vec::<f64>::new(),
            "{name}"
        );
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_has_driven_past_its_place_in_the_lay_by_comes_back() {
    let plans = plans(&crate::stepped::scenario("overtaking"));
    // Both were put where they stand within a shift, which then ends late.
    for (seed, fault) in [
        (98, "at_s = 29.14; for_s = 4.844; what = \"cover-lidar\""),
        (15, "at_s = 30.98; for_s = 6.678; what = \"reboot-robot\""),
    ] {
        let mut scenario = crate::stepped::scenario("overtaking");
        let fault = format!("{fault}; robot = \"amr-1\"").replace("; ", "\n");
        scenario.faults = vec![toml::from_str(&fault).expect("a fault")];
        let summary = ended(&scenario, &plans, seed).1;
        assert!(summary.passed(), "{summary:?}");
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_on_a_slope_with_a_load_drives_on_and_none_rolls_away() {
    let mut scenario = crate::stepped::scenario("overtaking");
    let plans = plans(&scenario);
    let load = "at_s = 10.0; for_s = 120.0; what = \"load\"; robot = \"amr-1\"; share = 1.0";
    for share in [-0.08, 0.08] {
        let slope = format!(
            "at_s = 24.0; for_s = 60.0; what = \"slope\"; robot = \"amr-1\"; share = {share:?}"
        );
        // It must stop downhill, too.
        let stop = "at_s = 26.0; for_s = 5.0; what = \"stop\"; robot = \"amr-1\"";
        let motors = "at_s = 36.0; for_s = 5.0; what = \"cut-motors\"; robot = \"amr-1\"";
        scenario.faults = vec![fault(load), fault(&slope), fault(stop), fault(motors)];
        let summary = ended(&scenario, &plans, 3).1;
        assert!(summary.passed(), "{share}: {summary:?}");
        assert_eq!(
            raised(&summary, "wheels-disobey"),
            0,
            "{share}: {summary:?}"
        );
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_area_is_free_by_an_operators_word_lets_the_other_one_go_on() {
    let mut scenario = crate::stepped::scenario("overtaking");
    scenario.patience_s = 60.0;
    let granted_s = |scenario: &Scenario| {
        let summary = ended(scenario, &plans(scenario), 3).1;
        assert_eq!(summary.violations, [], "{summary:?}");
        let owners = summary.areas.iter().flat_map(|area| &area.owners);
        let others = owners.filter(|own| own.robot == "amr-2" && own.granted_s > 30.0);
        others
            .map(|own| own.granted_s)
            .fold(f64::INFINITY, f64::min)
    };
    // It stands where the other one wants to go: switched off, and then carried away.
    let [killed_s, absent_s] = ["kill-robot", "absent"].map(|what| {
        let fault = format!("at_s = 24.0\nfor_s = 40.0\nwhat = \"{what}\"\nrobot = \"amr-1\"");
        scenario.faults = vec![toml::from_str(&fault).expect("a fault")];
        granted_s(&scenario)
    });
    assert!(absent_s + 10.0 < killed_s, "{absent_s} s, {killed_s} s");
}

#[test]
fn a_robot_whose_file_is_read_again_while_it_drives_keeps_to_what_stands_there() {
    let mut scenario = crate::stepped::scenario("lap");
    for player in &mut scenario.robots {
        player.goal = rig::scenario::Goal::Laps(1);
    }
    let mut top_m_s = |faults: &[&str]| {
        let faults = faults
            .iter()
            .map(|text| toml::from_str(&text.replace("; ", "\n")));
        scenario.faults = faults.map(|fault| fault.expect("a fault")).collect();
        let summary = ended(&scenario, &plans(&scenario), 1).1;
        assert!(summary.passed(), "{summary:?}");
        (summary.robots[0].max_speed_m_s, summary.duration_s)
    };
    let without = top_m_s(&[]);
    // Before it drives off; and in the middle of its way, from where on the rest takes longer.
    let all =
        top_m_s(&["at_s = 0.2; for_s = 300.0; what = \"reload\"; robot = \"amr-1\"; share = 0.5"]);
    let part =
        top_m_s(&["at_s = 15.0; for_s = 20.0; what = \"reload\"; robot = \"amr-1\"; share = 0.5"]);
    assert!(
        all.0 < 0.55 * without.0 && part.0 > 0.9 * without.0,
        "{all:?}, {part:?}, {without:?}"
    );
    assert!(
        without.1 < part.1 && part.1 < all.1,
        "{all:?}, {part:?}, {without:?}"
    );
}
