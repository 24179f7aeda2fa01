//! What is judged from messages: fences, and discrete control.

use contract::wire::{Control, ControlFlag, Instruction, Level, MediatorReport, RobotReport};
use sim::world::Truth;

use super::tests::{MS, grant, heard, kinds, observe, overtaking, truth};
use super::*;
use crate::network::observations::{Observations, Owning};
use crate::scenario::{Scenario, ScriptedFault};

#[test]
fn fences_that_do_not_grow_are_found_when_it_is_not_only_the_order_of_hearing() {
    let mut scenario = overtaking();
    let own = |robot: &str, fence: u64, asked_ms: u64, granted_ms: u64| Owning {
        area: "1".into(),
        robot: robot.into(),
        fence,
        journal: 7,
        requested_ns: Some(asked_ms * MS),
        granted_ns: granted_ms * MS,
        entered_ns: None,
        released_ns: None,
        returned: false,
    };
    let found = |scenario: &Scenario, ownings: &[Owning]| {
        let found = fences_not_grown(scenario, ownings).into_iter();
        found
            .map(|(robot, at_ns, _)| (robot, at_ns / MS))
            .collect::<Vec<_>>()
    };
    let first = own("a", 5, 900, 1000);
    let good = [
        first.clone(),
        own("b", 6, 1400, 1500),
        own("a", 7, 3000, 3001),
    ];
    assert_eq!(found(&scenario, &good), []);
    let b = |fence, asked_ms| [first.clone(), own("b", fence, asked_ms, 2000)];
    let of_b = vec![("b".to_owned(), 2000)];
    assert_eq!(found(&scenario, &b(4, 1400)), of_b, "smaller");
    assert_eq!(found(&scenario, &b(5, 1400)), of_b, "the same");
    let mut over = b(5, 1400);
    over[0].released_ns = Some(over[0].granted_ns);
    assert_eq!(found(&scenario, &over), [], "of another journal");
    assert_eq!(
        found(&scenario, &b(5, 900)),
        of_b,
        "the same, whenever it was asked for"
    );
    // Granted before it, and heard after it.
    assert_eq!(found(&scenario, &b(4, 900)), []);
    // It is told what it has when it registers anew, and has not asked.
    let again = [first.clone(), own("a", 5, 2000, 2000)];
    assert_eq!(found(&scenario, &again), []);
    let mut other = b(4, 1400);
    other[1].journal = 8;
    assert_eq!(found(&scenario, &other), [], "another journal");
    let restored = "at_s = 1.0\nfor_s = 1.0\nwhat = \"restore-journal\"";
    let restored: ScriptedFault = toml::from_str(restored).expect("a fault");
    scenario.faults = vec![restored];
    assert_eq!(found(&scenario, &b(4, 1400)), []);
}

#[test]
fn who_enters_long_after_it_has_heard_the_mediator_is_found() {
    let scenario = overtaking();
    let (mut judge, mut observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
    let outside = |at_ms| truth(at_ms, 9.0, 0.0);
    let inside = |at_ms| truth(at_ms, 3.0, -0.4);
    grant(&mut observations, "amr-1", "1", 2, 100);
    observe(&mut judge, 0, &outside(100), &observations);
    // Without word of what arrives, as on a real network, it is not judged.
    observe(&mut judge, 0, &inside(60_000), &observations);
    observe(&mut judge, 0, &outside(60_100), &observations);
    let report = RobotReport {
        robot_id: "amr-1".into(),
        boot_epoch: 7,
        sequence: 1,
        ..RobotReport::default()
    };
    let echo = MediatorReport {
        robot_id: "amr-1".into(),
        boot_epoch: 7,
        robot_sequence: 1,
        ..MediatorReport::default()
    };
    observations.report(&report, 61_000 * MS);
    observations.delivered(&echo, 61_000 * MS);
    for (at_ms, found) in [(65_900, 0), (66_100, 1)] {
        observe(&mut judge, 0, &inside(at_ms), &observations);
        let leases = kinds(&judge)
            .iter()
            .filter(|kind| **kind == "lease")
            .count();
        assert_eq!(leases, found, "{:?}", judge.violations());
        observe(&mut judge, 0, &outside(at_ms + 20), &observations);
    }
}

#[test]
fn who_enters_by_its_own_word_or_by_a_grant_that_was_lost_is_found() {
    let scenario = overtaking();
    let outside = |at_ms| truth(at_ms, 9.0, 0.0);
    let inside = |at_ms| truth(at_ms, 3.0, -0.4);
    let level = |progress| Level {
        run: 1,
        progress,
        ..Level::default()
    };
    let answer = MediatorReport {
        robot_id: "amr-1".into(),
        session: 5,
        instance: 7,
        journal: 7,
        mediator_epoch: 1,
        access: vec![contract::wire::AccessGrant {
            area: "1".into(),
            level: Some(level(2)),
            fence: 3,
            ..Default::default()
        }],
        ..MediatorReport::default()
    };
    let claim = RobotReport {
        robot_id: "amr-1".into(),
        session: 5,
        mediator_instance: 7,
        mediator_journal: 7,
        mediator_epoch: 1,
        boot_epoch: 7,
        sequence: 1,
        access: vec![contract::wire::Access {
            area: "1".into(),
            level: Some(level(3)),
            fence: 3,
        }],
        ..RobotReport::default()
    };
    let found = |says: &dyn Fn(&mut Observations)| {
        let (mut judge, mut observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
        observe(&mut judge, 0, &outside(900), &observations);
        says(&mut observations);
        for at_ms in (1_000..2_000).step_by(20) {
            observe(&mut judge, 0, &inside(at_ms), &observations);
        }
        kinds(&judge).contains(&"entry-without-grant")
    };
    assert!(found(&|own| own.report(&claim, 990 * MS)), "its own word");
    assert!(!found(&|own| own.answer(&answer, 990 * MS)));
    let late = |own: &mut Observations| {
        own.report(&claim, 990 * MS);
        own.answer(&answer, 1_500 * MS);
    };
    assert!(found(&late), "the mediator says so afterwards");
    let lost = |own: &mut Observations| {
        own.delivered(&MediatorReport::default(), 900 * MS);
        own.answer(&answer, 990 * MS);
    };
    assert!(found(&lost), "it was lost on its way");
    let arrives = |own: &mut Observations| {
        own.answer(&answer, 980 * MS);
        own.delivered(&answer, 990 * MS);
    };
    assert!(!found(&arrives));
}

#[test]
fn a_second_robot_of_an_identity_is_too_many_where_others_could_know_of_it() {
    let mut scenario = overtaking();
    let cloned = "at_s = 1.0\nfor_s = 60.0\nwhat = \"clone-robot\"\nrobot = \"amr-2\"";
    scenario.faults = vec![toml::from_str(cloned).expect("a fault")];
    let clone = scenario.robots.len();
    let outside = |at_ms| truth(at_ms, 9.0, 0.0);
    let inside = |at_ms| truth(at_ms, 3.0, -0.4);
    let over_capacity = |said_ms: Option<u64>, clone_at: &[Truth], entered_ms: u64| {
        let (mut judge, mut observations) = (Judge::new(&scenario, 0, false), heard(&scenario));
        observe(&mut judge, 0, &outside(900), &observations);
        for truth in clone_at {
            observe(&mut judge, clone, truth, &observations);
        }
        if let Some(at_ms) = said_ms {
            let report = RobotReport {
                robot_id: "amr-2".into(),
                boot_epoch: 9,
                sequence: 1,
                located: true,
                stands_in: vec!["1".into()],
                ..RobotReport::default()
            };
            observations.report(&report, at_ms * MS);
            observe(&mut judge, clone, &inside(at_ms), &observations);
        }
        observe(&mut judge, 0, &inside(entered_ms), &observations);
        kinds(&judge).contains(&"over-capacity")
    };
    // It says where it stands, and who comes in has had time to hear of it, or not.
    assert!(over_capacity(Some(2_000), &[inside(1_000)], 7_100));
    assert!(!over_capacity(Some(2_000), &[inside(1_000)], 6_900));
    // It does not know where it is.
    assert!(!over_capacity(None, &[inside(1_000)], 60_000));
    // It came in by itself.
    assert!(over_capacity(None, &[outside(1_000), inside(1_020)], 2_000));
}

#[test]
fn who_came_in_by_a_grant_that_was_lost_with_the_journal_is_excused_until_it_is_out() {
    let mut scenario = overtaking();
    let found = |scenario: &Scenario| {
        let (mut judge, mut observations) = (Judge::new(scenario, 0, true), heard(scenario));
        let [outside, inside] = [(9.0, 0.0), (3.0, -0.4)];
        let at = |at_ms, (x_m, y_m)| truth(at_ms, x_m, y_m);
        observe(&mut judge, 0, &at(900, outside), &observations);
        grant(&mut observations, "amr-1", "1", 2, 1_000);
        observe(&mut judge, 0, &at(1_200, inside), &observations);
        observations.cleared("1", &["amr-1"], 2_000 * MS);
        for at_ms in [2_200, 2_400, 2_600] {
            observe(&mut judge, 0, &at(at_ms, inside), &observations);
        }
        let inside_yet = kinds(&judge).len();
        observe(&mut judge, 0, &at(3_000, outside), &observations);
        for at_ms in [3_200, 3_400, 3_600] {
            observe(&mut judge, 0, &at(at_ms, inside), &observations);
        }
        [inside_yet, kinds(&judge).len()].map(|count| count > 0)
    };
    assert_eq!(found(&scenario), [true, true]);
    let lost = "at_s = 1.5\nfor_s = 1.0\nwhat = \"lose-journal\"";
    scenario.faults = vec![toml::from_str(lost).expect("a fault")];
    assert_eq!(found(&scenario), [false, true]);
}

/// The mediator's word that this coordination commands the robot, `progress` flags far: taken, then sent into area 1.
fn command(observations: &mut Observations, robot: &str, number: u64, progress: u32, at_ms: u64) {
    let flag = |by_mediator: bool, area: Option<&str>| ControlFlag {
        by_mediator,
        instruction: area.map(|area| Instruction {
            areas: vec![area.into()],
            ..Instruction::default()
        }),
        ..ControlFlag::default()
    };
    let report = MediatorReport {
        robot_id: robot.into(),
        session: 1,
        control: Some(Control {
            coordination: number,
            net: "passing".into(),
            flags: vec![
                flag(true, None),
                flag(false, None),
                flag(true, Some("1")),
                flag(false, None),
                flag(true, None),
                flag(false, None),
            ],
            level: Some(Level {
                progress,
                ..Level::default()
            }),
            ..Control::default()
        }),
        ..MediatorReport::default()
    };
    observations.answer(&report, at_ms * MS);
}

/// The robot's word that it is so far.
fn obeys(observations: &mut Observations, robot: &str, number: u64, progress: u32, at_ms: u64) {
    let report = RobotReport {
        robot_id: robot.into(),
        session: 1,
        control: Some(Control {
            coordination: number,
            level: Some(Level {
                progress,
                ..Level::default()
            }),
            ..Control::default()
        }),
        ..RobotReport::default()
    };
    observations.report(&report, at_ms * MS);
}

#[test]
fn two_nets_that_command_one_robot_are_found() {
    let scenario = overtaking();
    let found = |more: &dyn Fn(&mut Observations)| {
        let mut observations = heard(&scenario);
        command(&mut observations, "amr-1", 1, 1, 1000);
        command(&mut observations, "amr-2", 1, 1, 1000);
        more(&mut observations);
        let found = two_nets(&scenario, observations.controlled()).into_iter();
        found
            .map(|(robot, at_ns, _)| (robot, at_ns / MS))
            .collect::<Vec<_>>()
    };
    // The first one is broken off; what was on its way to the other robot is heard after that.
    let broken_off = |observations: &mut Observations| {
        command(observations, "amr-1", 2, 1, 2000);
        command(observations, "amr-2", 1, 1, 2200);
    };
    assert_eq!(found(&broken_off), []);
    let of_1 = vec![("amr-1".to_owned(), 2400)];
    for robot in ["amr-1", "amr-2"] {
        let goes_on = |observations: &mut Observations| {
            command(observations, "amr-1", 2, 1, 2000);
            command(observations, robot, 1, 3, 2400);
        };
        assert_eq!(found(&goes_on), of_1, "{robot} hears both");
    }
    // The first robot was let go before.
    let let_go = |observations: &mut Observations| {
        obeys(observations, "amr-1", 1, 6, 1900);
        command(observations, "amr-1", 2, 1, 2000);
        command(observations, "amr-2", 1, 3, 2400);
    };
    assert_eq!(found(&let_go), []);
}

#[test]
fn who_enters_what_the_net_in_control_has_not_ordered_is_found() {
    let scenario = overtaking();
    let border_m = scenario.site.area("1").expect("there").region.max.xy_m()[0];
    // Both areas are granted, so that the order alone is judged.
    let found_at = |m_s: f64, enters_ms: u64, into: f64, commands: &dyn Fn(&mut Observations)| {
        let (mut judge, mut observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
        grant(&mut observations, "amr-2", "1", 3, 0);
        grant(&mut observations, "amr-2", "2", 3, 0);
        commands(&mut observations);
        let from_m = border_m - into * 0.6;
        for at_ms in (0..enters_ms + 500).step_by(20) {
            let over_m = if at_ms < enters_ms { 0.0 } else { into * 1.2 };
            let mut truth = truth(at_ms, from_m + over_m, -0.5);
            truth.twist.v_m_s = m_s;
            observe(&mut judge, 1, &truth, &observations);
        }
        kinds(&judge)
            .into_iter()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let found =
        |into: f64, commands: &dyn Fn(&mut Observations)| found_at(0.0, 1000, into, commands);
    let nobody = |_: &mut Observations| {};
    let taken = |observations: &mut Observations| {
        command(observations, "amr-2", 1, 1, 100);
        obeys(observations, "amr-2", 1, 2, 200);
    };
    let sent = |observations: &mut Observations| {
        taken(observations);
        command(observations, "amr-2", 1, 3, 300);
    };
    let let_go = |observations: &mut Observations| {
        taken(observations);
        obeys(observations, "amr-2", 1, 6, 900);
    };
    assert_eq!(found(1.0, &nobody), [""; 0]);
    assert_eq!(found(1.0, &taken), ["uncommanded-entry"]);
    assert_eq!(found(-1.0, &taken), ["uncommanded-entry"]);
    // It is sent into area 1 alone.
    assert_eq!(found(-1.0, &sent), [""; 0]);
    assert_eq!(found(1.0, &sent), ["uncommanded-entry"]);
    assert_eq!(found(1.0, &let_go), [""; 0]);
    // From 0.6 m before the border it can stop.
    assert_eq!(found_at(0.2, 1000, 1.0, &taken), ["uncommanded-entry"]);
    // So fast it cannot.
    assert_eq!(found_at(0.9, 1000, 1.0, &taken), [""; 0]);
    // It has stopped by then.
    assert_eq!(found_at(0.9, 4000, 1.0, &taken), ["uncommanded-entry"]);
    assert_eq!(
        found_at(-0.9, 1000, 1.0, &taken),
        ["uncommanded-entry"],
        "it drove away"
    );
    // It had not given its control away when it was on its way in.
    let asked = |observations: &mut Observations| command(observations, "amr-2", 1, 1, 100);
    assert_eq!(found(1.0, &asked), [""; 0]);
}
