//! What campaigns have found, each by the lines that the campaign printed of it.

use rig::scenario::{ScriptedFault, ScriptedKind};
use rig::summary::Summary;

use crate::{ended, plans};

/// A run of a scenario's first round with these faults, which the fleet comes through. It ends when the robots that the faults
/// hit have done what they are to do, and until then it is the run that the campaign made.
#[track_caller]
fn passes(scenario: &str, seed: u64, faults: &[ScriptedFault]) -> Summary {
    let mut scenario = crate::scenario(scenario).with_at_most(1);
    scenario.faults = faults.to_vec();
    let hit = |id: &str| {
        faults
            .iter()
            .any(|own| own.robot.as_ref().is_none_or(|robot| robot == id))
    };
    for player in &mut scenario.robots {
        if !hit(&player.id) {
            player.goal.limit_rounds(0);
        }
    }
    let summary = ended(&scenario, &plans(&scenario), seed).1;
    assert!(summary.passed(), "{summary:?}");
    summary
}

fn killed(at_s: f64, for_s: f64, robot: &str) -> ScriptedFault {
    fault(at_s, for_s, ScriptedKind::KillRobot, robot)
}

fn of_mediator(at_s: f64, for_s: f64, what: ScriptedKind) -> ScriptedFault {
    ScriptedFault {
        robot: None,
        ..fault(at_s, for_s, what, "")
    }
}

fn fault(at_s: f64, for_s: f64, what: ScriptedKind, robot: &str) -> ScriptedFault {
    ScriptedFault {
        at_s,
        for_s,
        what,
        robot: Some(robot.to_owned()),
        share: None,
        by_s: None,
        thread: None,
        pose: None,
        motion: None,
        way: None,
    }
}

#[test]
fn a_robot_that_restarts_in_the_middle_of_a_shift_finishes_it() {
    passes("overtaking", 46, &[killed(33.018, 1.449, "amr-1")]);
}

#[test]
fn a_robot_that_restarts_in_the_middle_of_a_turn_finishes_it() {
    passes("t-junction", 21, &[killed(24.836, 0.255, "amr-3")]);
}

#[test]
fn a_robot_whose_program_is_ended_beside_a_wall_in_the_middle_of_a_shift_finishes_it() {
    let ended = fault(34.26, 1.61, ScriptedKind::EndRobot, "amr-1");
    passes("overtaking", 17, &[ended]);
}

#[test]
fn a_robot_that_nobody_manages_goes_on_where_it_has_ended() {
    let ended = fault(17.71, 2.472, ScriptedKind::EndRobot, "amr-1");
    passes("lap", 6, &[ended]);
}

/// Where it believes to be while the mediator has not been heard is where the process before has ended.
#[test]
fn a_robot_that_is_ended_and_then_killed_before_the_mediator_is_heard_goes_on_where_it_is() {
    let faults = [
        fault(29.0, 14.0, ScriptedKind::Partition, "amr-1"),
        fault(30.0, 1.5, ScriptedKind::EndRobot, "amr-1"),
        killed(35.0, 1.0, "amr-1"),
    ];
    passes("overtaking", 1, &faults);
}

#[test]
fn a_robot_that_is_placed_behind_a_crossing_does_not_cross_it_again() {
    let covered = fault(24.0, 10.0, ScriptedKind::CoverLidar, "amr-3");
    passes("t-junction", 35, &[covered]);
}

/// Nobody has looked at the floor behind it but the process before.
#[test]
fn a_robot_that_restarts_in_the_dock_backs_out_of_it() {
    passes("docking", 3, &[killed(58.849, 0.068, "amr-2")]);
}

/// A moment is no time for anybody to push it: it need not forget the floor behind it.
#[test]
fn a_robot_without_power_for_a_moment_backs_out_of_the_dock() {
    let cut = fault(25.367, 0.051, ScriptedKind::CutPower, "amr-1");
    passes("docking", 110, &[cut]);
}

/// It may have rolled, so what it knew of the floor is void: the operator who resets it says that it is free.
#[test]
fn a_robot_that_was_without_power_in_the_dock_backs_out_when_an_operator_says_that_it_may() {
    let cut = fault(70.185, 0.628, ScriptedKind::CutPower, "amr-2");
    passes("docking", 324, &[cut]);
}

/// By its wheels it backs out farther than it does.
#[test]
fn a_robot_whose_wheels_slip_backs_out_of_the_dock() {
    let slip = ScriptedFault {
        share: Some(0.2724),
        ..fault(68.164, 7.337, ScriptedKind::Slip, "amr-2")
    };
    passes("docking", 326, &[slip]);
}

/// Between two walls the lidar cannot tell how far along it is: it gave back floor that it stood on.
#[test]
fn a_robot_whose_wheels_slip_stops_before_it_loses_its_place() {
    let late = ScriptedFault {
        share: Some(0.848_900_000_000_000_1),
        by_s: Some(0.06),
        ..fault(19.016, 10.748, ScriptedKind::LateThreads, "amr-1")
    };
    let slip = ScriptedFault {
        share: Some(0.2577),
        ..fault(58.802, 11.18, ScriptedKind::Slip, "amr-1")
    };
    let summary = passes("docking", 27, &[late, slip]);
    let robot = { summary.robots.iter() }.find(|robot| robot.id == "amr-1");
    let faults = &robot.expect("it drives").faults;
    let slips = faults.iter().any(|(fault, _)| fault == "wheel-slip");
    assert!(slips, "{faults:?}");
}

/// It did not know well where it was, and gave area 1 back before it was through: that stays kept for it.
#[test]
fn a_robot_that_was_wrong_about_an_area_is_let_in_again_by_the_same_order() {
    let frozen = fault(57.4, 5.931, ScriptedKind::FreezeSensors, "amr-1");
    passes("overtaking", 64, &[frozen]);
}

/// Whoever looks after it says where it stands when its drive says so, too.
#[test]
fn a_robot_whose_sensors_are_frozen_while_it_loses_its_place_is_not_placed_before_it_stands() {
    let frozen = fault(35.98, 9.936, ScriptedKind::FreezeSensors, "amr-1");
    passes("overtaking", 13, &[frozen]);
    let frozen = fault(59.0, 7.344, ScriptedKind::FreezeSensors, "amr-1");
    passes("overtaking", 51, &[frozen]);
}

/// It stops with its nose to the lay-by's wall.
#[test]
fn a_robot_that_finds_no_way_is_driven_out_by_hand_and_goes_on() {
    let jammed = fault(33.64, 6.638, ScriptedKind::JamPivot, "amr-1");
    let summary = passes("overtaking", 65, &[jammed]);
    assert_eq!(summary.robots[0].driven_out, 1, "{:?}", summary.robots[0]);
}

/// Its mediator's journal is from before the coordination was over: robots that are past it all are let go at once.
#[test]
fn a_coordination_that_an_older_journal_brings_back_holds_nobody() {
    let restored = of_mediator(59.88, 8.046, ScriptedKind::RestoreJournal);
    let summary = passes("overtaking", 79, &[restored]);
    assert!(summary.duration_s < 120.0, "{}", summary.duration_s);
}

/// Its turn had ended but for a hand's breadth when its lidar was covered; an operator says where it stands, and it does not turn on.
#[test]
fn a_robot_that_is_told_that_its_turn_has_ended_does_not_begin_it_again() {
    let covered = fault(22.037, 10.623, ScriptedKind::CoverLidar, "amr-1");
    passes("overtaking", 1567, &[covered]);
}

/// Its new process has done what was ordered before the mediator has taken it in.
#[test]
fn a_robot_that_restarts_and_answers_before_it_is_registered_holds_nobody() {
    passes("overtaking", 6669, &[killed(55.793, 0.072, "amr-2")]);
}

/// It stands just over the border while the way is blocked, and sees the end of the lane.
#[test]
fn a_robot_that_waits_on_a_border_has_not_left_the_area_before() {
    let blocked = fault(53.14, 7.559, ScriptedKind::Box, "amr-2");
    passes("overtaking", 19, &[blocked]);
}

/// It starts only then, and whoever stops it is still there.
#[test]
fn a_robot_that_is_stopped_before_it_has_started_stands() {
    let stopped = fault(2.375, 9.004, ScriptedKind::Stop, "amr-2");
    passes("overtaking", 4454, &[stopped]);
}

/// Operators wait for an answer before they ask again.
#[test]
fn a_robot_that_hangs_while_it_is_looked_after_is_asked_once() {
    let slips = ScriptedFault {
        share: Some(0.240_899_999_999_999_98),
        ..fault(47.103, 2.762, ScriptedKind::Slip, "amr-2")
    };
    let hangs = fault(50.304, 5.454, ScriptedKind::Hang, "amr-2");
    passes("overtaking", 1862, &[slips, hangs]);
}

/// One that holds an unused grant gives it back.
#[test]
fn a_robot_on_its_way_into_an_area_stops_before_a_clone_that_is_put_there() {
    let paused = fault(15.675, 3.682, ScriptedKind::Pause, "amr-2");
    let cloned = ScriptedFault {
        pose: Some([4.0, -0.43, 204.0]),
        ..fault(18.222, 27.748, ScriptedKind::CloneRobot, "amr-2")
    };
    passes("overtaking", 43, &[paused, cloned]);
}

/// What a lidar repeats pulls the pose back to where the robot was, and it would drive over the border before which it stops.
#[test]
fn a_robot_whose_lidar_repeats_its_scan_stops_before_the_border() {
    let frozen = fault(23.86, 8.483, ScriptedKind::FreezeScans, "amr-2");
    passes("overtaking", 1668, &[frozen]);
}

/// Its sensors say how fast it was before.
#[test]
fn a_robot_that_restarts_while_its_sensors_are_frozen_does_not_brake_from_a_speed_that_it_has_not()
{
    let frozen = fault(42.5, 9.208, ScriptedKind::FreezeSensors, "amr-2");
    let panics = ScriptedFault {
        thread: Some("lidar".to_owned()),
        ..fault(42.806, 1.977, ScriptedKind::Panic, "amr-2")
    };
    passes("overtaking", 1932, &[frozen, panics]);
}

/// What it stands in is its own yet, though neither the mediator nor its new process knows of the grant.
#[test]
fn a_robot_and_the_mediator_that_forget_a_grant_at_once_harm_nobody() {
    let lost = of_mediator(65.993, 0.859, ScriptedKind::LoseJournal);
    passes("overtaking", 367, &[killed(64.86, 1.23, "amr-1"), lost]);
    // Its new process registers with the number that the one before had with the other mediator.
    let lost = of_mediator(50.68, 11.108, ScriptedKind::LoseJournal);
    let panics = ScriptedFault {
        thread: Some("communication".to_owned()),
        ..fault(54.98, 1.353, ScriptedKind::Panic, "amr-2")
    };
    passes("overtaking", 2115, &[lost, panics]);
}

/// The mediator knows it to be elsewhere than it says: who says where it stands has not said that it may drive, and it stands while its
/// operator sees to what is behind it.
#[test]
fn a_robot_that_its_mediator_has_elsewhere_stands_until_it_is_reset() {
    let kill = of_mediator(11.14, 0.337, ScriptedKind::KillMediator);
    let end = fault(11.164, 5.683, ScriptedKind::EndRobot, "amr-1");
    passes("overtaking", 411, &[kill, end]);
    let reboot = of_mediator(13.74, 3.636, ScriptedKind::RebootMediator);
    let end = fault(17.181, 3.59, ScriptedKind::EndRobot, "amr-2");
    passes("overtaking", 470, &[reboot, end]);
}

/// Who looks at an area that such a robot has left sees it empty, however near it is.
#[test]
fn a_robot_without_a_lease_does_not_come_back_to_where_it_was_a_moment_ago() {
    let dead = fault(31.74, 0.422, ScriptedKind::DeadLink, "amr-1");
    let driven = ScriptedFault {
        motion: Some([-0.394, 0.802]),
        ..fault(31.858, 6.781, ScriptedKind::Teleop, "amr-1")
    };
    passes("overtaking", 305, &[dead, driven]);
    let lost = of_mediator(29.425, 2.711, ScriptedKind::LoseJournal);
    passes("overtaking", 832, &[lost]);
}

/// Whoever wanted to drive it has gone before its program answers.
#[test]
fn a_robot_that_hangs_is_not_in_the_hands_of_who_has_left() {
    let hangs = fault(25.02, 6.279, ScriptedKind::Hang, "amr-1");
    let driven = ScriptedFault {
        motion: Some([-0.382, -0.682]),
        ..fault(26.179, 0.643, ScriptedKind::Teleop, "amr-1")
    };
    passes("overtaking", 662, &[hangs, driven]);
}

/// It is told where it stands, and in which state it was.
#[test]
fn a_robot_that_has_ended_while_its_bus_was_gone_goes_on() {
    let gone = fault(25.36, 4.376, ScriptedKind::LoseInterface, "amr-1");
    let ends = fault(27.965, 0.647, ScriptedKind::EndRobot, "amr-1");
    passes("overtaking", 1581, &[gone, ends]);
}

/// A grant of the mediator that stands by is none of the one that goes on, and one of the robot none of its clone.
#[test]
fn who_stands_somewhere_by_what_nobody_knows_of_has_not_come_in() {
    let copied = of_mediator(21.94, 11.059, ScriptedKind::CopiedMediator);
    let panics = ScriptedFault {
        thread: Some("navigation".to_owned()),
        ..fault(31.016, 2.64, ScriptedKind::Panic, "amr-2")
    };
    passes("overtaking", 2199, &[copied, panics]);
    let dead = fault(9.098, 3.08, ScriptedKind::DeadLink, "amr-2");
    let cloned = ScriptedFault {
        pose: Some([0.75, 0.0, 4.0]),
        ..fault(25.993, 5.554, ScriptedKind::CloneRobot, "amr-2")
    };
    passes("overtaking", 1017, &[dead, cloned]);
}

/// Its operator carries it back.
#[test]
fn a_robot_that_was_driven_by_hand_to_where_it_finds_no_way_goes_on() {
    let boots = fault(40.402, 0.071, ScriptedKind::RebootRobot, "amr-1");
    let driven = ScriptedFault {
        motion: Some([0.275, -0.952]),
        ..fault(75.464, 89.243, ScriptedKind::Teleop, "amr-2")
    };
    passes("overtaking", 1023, &[boots, driven]);
    let driven = ScriptedFault {
        motion: Some([0.239, 0.628]),
        ..fault(60.031, 4.222, ScriptedKind::Teleop, "amr-1")
    };
    passes("overtaking", 47, &[driven]);
}

/// While it says that it does not know where it is, and when it is sent on before it has stopped, it is held to nothing.
#[test]
fn who_does_not_know_and_who_is_sent_on_are_not_held_to_where_they_are() {
    let frozen = fault(66.16, 0.329, ScriptedKind::FreezeSensors, "amr-2");
    passes("overtaking", 1956, &[frozen]);
    let lost = of_mediator(35.631, 0.473, ScriptedKind::LoseJournal);
    passes("overtaking", 2127, &[lost]);
}

/// Its process starts when the fault is over.
#[test]
fn a_robot_that_is_to_end_before_it_has_begun_does_not_begin() {
    for what in [ScriptedKind::Panic, ScriptedKind::EndRobot] {
        passes("overtaking", 134, &[fault(0.628, 18.848, what, "amr-1")]);
    }
}

/// The mediator that stood by knows only what was going on when its journal was copied.
#[test]
fn a_mediator_that_goes_on_after_its_copy_may_have_older_orders() {
    let frozen = fault(21.492, 2.209, ScriptedKind::FreezeSensors, "amr-1");
    let copied = of_mediator(56.316, 84.598, ScriptedKind::CopiedMediator);
    passes("overtaking", 171, &[frozen, copied]);
}

/// Its people know in which state it was before it lost its place, and tell its next process.
#[test]
fn a_robot_that_panics_once_it_is_awake_goes_on_where_it_was() {
    let sleeps = fault(63.08, 2.181, ScriptedKind::Sleep, "amr-1");
    let panics = ScriptedFault {
        thread: Some("navigation".into()),
        ..fault(64.642, 0.511, ScriptedKind::Panic, "amr-1")
    };
    passes("overtaking", 2417, &[sleeps, panics]);
}
