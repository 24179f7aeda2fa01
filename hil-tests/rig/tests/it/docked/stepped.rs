//! Robots that start again where nobody expects it, with nothing of what they knew.

use rig::scenario::{Scenario, ScriptedFault};
use rig::summary::{RobotSummary, Summary};

use crate::stepped::{ended, plans, without_faults};

/// After entering the dock a robot stands before its wall by then.
const STANDS_S: f64 = 12.0;

fn fault(what: &str, robot: &str, at_s: f64, for_s: f64) -> ScriptedFault {
    let text =
        format!("at_s = {at_s:?}\nfor_s = {for_s:?}\nwhat = \"{what}\"\nrobot = \"{robot}\"");
    toml::from_str(&text).expect("a fault")
}

fn run(mut scenario: Scenario, faults: &[ScriptedFault], seed: u64) -> Summary {
    scenario.faults = faults.to_vec();
    ended(&scenario, &plans(&scenario), seed).1
}

fn raised(robot: &RobotSummary, fault: &str) -> u64 {
    let mut faults = robot.faults.iter();
    faults.find(|own| own.0 == fault).map_or(0, |own| own.1)
}

/// It says what it needs, and drives on when it has it: where it is, after its computer was switched off; or, after its drive was,
/// that it may drive at all, and what is behind it, since nobody has counted the wheels' turns meanwhile.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_starts_again_in_the_dock_asks_for_what_it_cannot_know() {
    let docking = crate::stepped::scenario("docking").with_at_most(1);
    let before = without_faults(&docking, 3);
    assert!(before.passed(), "{}", before.reason());
    let dock = { before.areas.iter() }.find(|area| area.id == "dock");
    for (number, robot) in before.robots.iter().enumerate() {
        let docks = dock.expect("an area").owners.iter();
        let entered_s = { docks.filter(|own| own.robot == robot.id) }
            .find_map(|own| own.entered_s)
            .expect("it docked");
        let at_s = entered_s + STANDS_S;
        let (faults, asks) = if number % 2 == 0 {
            let faults = vec![fault("reboot-robot", &robot.id, at_s, 3.0)];
            (faults, (1, 0, 0))
        } else {
            let faults = vec![
                fault("kill-robot", &robot.id, at_s, 3.0),
                fault("cut-power", &robot.id, at_s, 2.0),
            ];
            (faults, (0, 0, 1))
        };
        // The others come to the dock once, and do not drive on.
        let mut docking = docking.clone();
        for player in docking.robots.iter_mut().filter(|own| own.id != robot.id) {
            player.goal.limit_rounds(0);
        }
        let summary = run(docking, &faults, 3);
        let own = &summary.robots[number];
        let what = format!("{}: {:?}", robot.id, own.faults);
        assert!(summary.passed(), "{what}: {}", summary.reason());
        let asked = (
            raised(own, "place-unknown"),
            raised(own, "floor-unknown"),
            raised(own, "drive-returned"),
        );
        assert_eq!((asked, own.resets), (asks, 1), "{what}");
    }
}

/// Its checkpoint is too old, and there is no mediator: it must not believe that it stands where it starts.
#[test]
fn a_robot_that_has_lost_its_place_waits_to_be_told() {
    for seed in [1, 2, 3] {
        let mut lap = crate::stepped::scenario("lap").with_at_most(1);
        lap.standstill_s = 120.0;
        let kill = fault("kill-robot", "amr-1", 8.0, 61.0);
        let summary = run(lap, &[kill], seed);
        assert!(summary.passed(), "seed {seed}: {}", summary.reason());
        let own = &summary.robots[0];
        assert_eq!(raised(own, "place-unknown"), 1, "{own:?}");
        assert_eq!(raised(own, "pose-uncertain"), 0, "{own:?}");
        assert_eq!(own.resets, 1, "{own:?}");
    }
}

/// The button that takes the drive's supply as well, while the process is gone: whoever releases it starts no robot.
#[test]
fn a_robot_that_restarts_beside_a_released_button_waits_for_an_operator() {
    for (seed, restarts_s, released_s) in [(1, 0.5, 0.3), (2, 0.5, 1.5), (3, 3.0, 2.0)] {
        let mut lap = crate::stepped::scenario("lap").with_at_most(1);
        lap.standstill_s = 60.0;
        let faults = [
            fault("kill-robot", "amr-1", 8.0, restarts_s),
            fault("cut-power", "amr-1", 8.0, released_s),
        ];
        let summary = run(lap, &faults, seed);
        assert!(summary.passed(), "seed {seed}: {}", summary.reason());
        let own = &summary.robots[0];
        assert_eq!(raised(own, "drive-returned"), 1, "{own:?}");
        assert!(own.resets >= 1, "{own:?}");
    }
}
