//! What is judged while something else is.

use contract::wire::{Control, MediatorReport, RobotReport};

use super::tests::{MS, heard, observe, overtaking, truth};
use super::*;
use crate::network::observations::Observations;
use crate::scenario::{Coordination, During, Scenario, Stop};
use crate::violation::ViolationKind;

/// Nothing is asked of `amr-1`, which stands half outside, before a coordination has had it inside again.
fn another_mediator_lets_it_go(scenario: &Scenario, mut observations: Observations) {
    let aside = scenario.during[0].other_area.region;
    let middle = [0, 1].map(|axis| 0.5 * (aside.min.xy_m()[axis] + aside.max.xy_m()[axis]));
    let mut judge = Judge::new(scenario, 0, true);
    let follows = |observations: &mut Observations, robot: &str, journal, at_ms| {
        let report = RobotReport {
            robot_id: robot.into(),
            session: 1,
            mediator_instance: journal,
            mediator_journal: journal,
            mediator_epoch: journal,
            ..RobotReport::default()
        };
        observations.report(&report, at_ms * MS);
        // Whoever speaks next has the discrete control of both again.
        for robot_id in ["amr-1", "amr-2"].map(String::from) {
            let control = Some(Control {
                coordination: 1,
                net: "overtaking".into(),
                ..Control::default()
            });
            let answer = MediatorReport {
                robot_id,
                session: 1,
                instance: journal,
                journal,
                mediator_epoch: journal,
                control,
                ..MediatorReport::default()
            };
            observations.answer(&answer, at_ms * MS);
        }
    };
    let mut found = |observations: &Observations, y_m, at_ms| {
        observe(&mut judge, 0, &truth(at_ms, middle[0], y_m), observations);
        observe(&mut judge, 1, &truth(at_ms, 3.0, -0.5), observations);
        let rules = judge.violations().iter();
        { rules.filter(|own| own.kind == ViolationKind::During) }.count()
    };
    let outside_m = aside.max.xy_m()[1];
    follows(&mut observations, "amr-2", 1, 70);
    follows(&mut observations, "amr-1", 2, 70);
    assert_eq!(found(&observations, outside_m, 80), 0);
    follows(&mut observations, "amr-2", 2, 90);
    assert_eq!(
        found(&observations, outside_m, 100),
        0,
        "it has to come back"
    );
    assert_eq!(found(&observations, middle[1], 120), 0);
    assert_eq!(found(&observations, outside_m, 140), 1, "it is asked again");
}

#[test]
fn what_must_be_true_during_something_is_checked_as_long_as_that_lasts() {
    let mut scenario = overtaking();
    let area = |id: &str| Stop {
        name: format!("area {id}"),
        region: scenario.site.area(id).expect("there").region,
        stands_s: 0.0,
    };
    scenario.during = vec![During {
        robot: "amr-2".into(),
        area: area("1"),
        coordination: Some(Coordination {
            id: "overtaking".into(),
            net: "overtaking".into(),
        }),
        other: "amr-1".into(),
        other_area: area("5"),
    }];
    let (mut judge, mut observations) = (Judge::new(&scenario, 0, true), heard(&scenario));
    let aside = scenario.during[0].other_area.region;
    let middle = [0, 1].map(|axis| 0.5 * (aside.min.xy_m()[axis] + aside.max.xy_m()[axis]));
    // Before the coordination nothing is asked.
    observe(
        &mut judge,
        0,
        &truth(0, middle[0], aside.max.xy_m()[1]),
        &observations,
    );
    observe(&mut judge, 1, &truth(0, 3.0, -0.5), &observations);
    observe(&mut judge, 1, &truth(20, 3.0, -0.5), &observations);
    assert_eq!(judge.rules()[0].checked_s, 0.0);
    observations.answer(
        &MediatorReport {
            robot_id: "amr-2".into(),
            session: 1,
            control: Some(Control {
                coordination: 1,
                net: "overtaking".into(),
                ..Control::default()
            }),
            ..MediatorReport::default()
        },
        30 * MS,
    );
    observe(
        &mut judge,
        0,
        &truth(40, middle[0], middle[1]),
        &observations,
    );
    observe(&mut judge, 1, &truth(40, 3.0, -0.5), &observations);
    assert_eq!(judge.rules()[0].checked_s, 0.02);
    let rules = |judge: &Judge| {
        let found = { judge.violations().iter() }.filter(|own| own.kind == ViolationKind::During);
        found.count()
    };
    assert_eq!(rules(&judge), 0);
    // Half of it reaches out.
    observe(
        &mut judge,
        0,
        &truth(60, middle[0], aside.max.xy_m()[1]),
        &observations,
    );
    observe(&mut judge, 1, &truth(60, 3.0, -0.5), &observations);
    assert_eq!((rules(&judge), judge.rules()[0].broken_s), (1, 0.02));
    another_mediator_lets_it_go(&scenario, observations.clone());
    // Nothing is asked of who was carried away.
    let absent = "at_s = 0.05\nfor_s = 1.0\nwhat = \"absent\"\nrobot = \"amr-1\"";
    scenario.faults = vec![toml::from_str(absent).expect("a fault")];
    let mut judge = Judge::new(&scenario, 0, true);
    observe(&mut judge, 0, &truth(60, 30.0, 0.0), &observations);
    observe(&mut judge, 1, &truth(60, 3.0, -0.5), &observations);
    observe(&mut judge, 1, &truth(80, 3.0, -0.5), &observations);
    assert_eq!(rules(&judge), 0);
}
