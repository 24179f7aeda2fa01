//! What campaigns have found: each is the line that the campaign printed of it, as it was printed.
//!
//! They are a campaign by themselves, of minutes: `cargo test --workspace stepped:: -- --ignored`, which CI runs.

use rig::cli::asked;
use rig::summary::Summary;

use crate::stepped::{ended, plans, shipped};

/// Makes the run of a command, of a scenario's first round, which the fleet comes through. It ends when the robots that the faults
/// hit have done what they are to do, and until then it is the run that the campaign made.
#[track_caller]
fn passes(command: &str) -> Summary {
    let mut words = shlex::split(command).expect("a command");
    // A name is that of a scenario that ships, found from the project's folder.
    let file = shipped(&format!("scenarios/{}.toml", words[2]));
    words[2] = file.display().to_string();
    let (scenario, seed) = asked(words).unwrap_or_else(|failure| panic!("{failure:?}"));
    let mut scenario = scenario.with_at_most(1);
    let faults = scenario.faults.clone();
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

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_restarts_in_the_middle_of_a_shift_finishes_it() {
    passes(
        r#"rig scenario overtaking --stepped --seed 46 --fault '{ at_s = 33.018, for_s = 1.449, what = "kill-robot", robot = "amr-1" }'"#,
    );
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_restarts_in_the_middle_of_a_turn_finishes_it() {
    passes(
        r#"rig scenario t-junction --stepped --seed 21 --fault '{ at_s = 24.836, for_s = 0.255, what = "kill-robot", robot = "amr-3" }'"#,
    );
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_program_is_ended_beside_a_wall_in_the_middle_of_a_shift_finishes_it() {
    passes(
        r#"rig scenario overtaking --stepped --seed 17 --fault '{ at_s = 34.26, for_s = 1.61, what = "end-robot", robot = "amr-1" }'"#,
    );
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_nobody_manages_goes_on_where_it_has_ended() {
    passes(
        r#"rig scenario lap --stepped --seed 6 --fault '{ at_s = 17.71, for_s = 2.472, what = "end-robot", robot = "amr-1" }'"#,
    );
}

/// Where it believes to be while the mediator has not been heard is where the process before has ended.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_is_ended_and_then_killed_before_the_mediator_is_heard_goes_on_where_it_is() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1 --fault '{ at_s = 29.0, for_s = 14.0, what = "partition", robot = "amr-1" }' --fault '{ at_s = 30.0, for_s = 1.5, what = "end-robot", robot = "amr-1" }' --fault '{ at_s = 35.0, for_s = 1.0, what = "kill-robot", robot = "amr-1" }'"#,
    );
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_is_placed_behind_a_crossing_does_not_cross_it_again() {
    passes(
        r#"rig scenario t-junction --stepped --seed 35 --fault '{ at_s = 24.0, for_s = 10.0, what = "cover-lidar", robot = "amr-3" }'"#,
    );
}

/// Nobody has looked at the floor behind it but the process before.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_restarts_in_the_dock_backs_out_of_it() {
    passes(
        r#"rig scenario docking --stepped --seed 3 --fault '{ at_s = 58.849, for_s = 0.068, what = "kill-robot", robot = "amr-2" }'"#,
    );
}

/// A moment is no time for anybody to push it: it need not forget the floor behind it.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_without_power_for_a_moment_backs_out_of_the_dock() {
    passes(
        r#"rig scenario docking --stepped --seed 110 --fault '{ at_s = 25.367, for_s = 0.051, what = "cut-power", robot = "amr-1" }'"#,
    );
}

/// It may have rolled, so what it knew of the floor is void: the operator who resets it says that it is free.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_was_without_power_in_the_dock_backs_out_when_an_operator_says_that_it_may() {
    passes(
        r#"rig scenario docking --stepped --seed 324 --fault '{ at_s = 70.185, for_s = 0.628, what = "cut-power", robot = "amr-2" }'"#,
    );
}

/// By its wheels it backs out farther than it does.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_wheels_slip_backs_out_of_the_dock() {
    passes(
        r#"rig scenario docking --stepped --seed 326 --fault '{ at_s = 68.164, for_s = 7.337, what = "slip", robot = "amr-2", share = 0.2724 }'"#,
    );
}

/// Between two walls the lidar cannot tell how far along it is: it gave back floor that it stood on.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_wheels_slip_stops_before_it_loses_its_place() {
    let summary = passes(
        r#"rig scenario docking --stepped --seed 27 --fault '{ at_s = 19.016, for_s = 10.748, what = "late-threads", robot = "amr-1", share = 0.8489000000000001, by_s = 0.06 }' --fault '{ at_s = 58.802, for_s = 11.18, what = "slip", robot = "amr-1", share = 0.2577 }'"#,
    );
    let robot = { summary.robots.iter() }.find(|robot| robot.id == "amr-1");
    let faults = &robot.expect("it drives").faults;
    let slips = faults.iter().any(|(fault, _)| fault == "wheel-slip");
    assert!(slips, "{faults:?}");
}

/// It did not know well where it was, and gave area 1 back before it was through: that stays kept for it.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_was_wrong_about_an_area_is_let_in_again_by_the_same_order() {
    passes(
        r#"rig scenario overtaking --stepped --seed 64 --fault '{ at_s = 57.4, for_s = 5.931, what = "freeze-sensors", robot = "amr-1" }'"#,
    );
}

/// Whoever looks after it says where it stands when its drive says so, too.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_sensors_are_frozen_while_it_loses_its_place_is_not_placed_before_it_stands() {
    passes(
        r#"rig scenario overtaking --stepped --seed 13 --fault '{ at_s = 35.98, for_s = 9.936, what = "freeze-sensors", robot = "amr-1" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 51 --fault '{ at_s = 59.0, for_s = 7.344, what = "freeze-sensors", robot = "amr-1" }'"#,
    );
}

/// Nobody sees it move meanwhile, so that it refuses to be placed, and is right.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_drive_is_silent_is_not_placed() {
    passes(
        r#"rig scenario overtaking --stepped --seed 880 --fault '{ at_s = 51.4, for_s = 11.351, what = "lose-frames", robot = "amr-2", share = 1.0 }' --fault '{ at_s = 58.059, for_s = 0.307, what = "place", robot = "amr-2" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 1934 --fault '{ at_s = 45.52, for_s = 0.334, what = "place", robot = "amr-2" }' --fault '{ at_s = 45.619, for_s = 0.763, what = "freeze-sensors", robot = "amr-2" }'"#,
    );
}

/// It stops with its nose to the lay-by's wall.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_finds_no_way_is_driven_out_by_hand_and_goes_on() {
    let summary = passes(
        r#"rig scenario overtaking --stepped --seed 65 --fault '{ at_s = 33.64, for_s = 6.638, what = "jam-pivot", robot = "amr-1" }'"#,
    );
    assert_eq!(summary.robots[0].driven_out, 1, "{:?}", summary.robots[0]);
}

/// Its mediator's journal is from before the coordination was over: robots that are past it all are let go at once.
#[test]
#[ignore = "CI makes these runs"]
fn a_coordination_that_an_older_journal_brings_back_holds_nobody() {
    let summary = passes(
        r#"rig scenario overtaking --stepped --seed 79 --fault '{ at_s = 59.88, for_s = 8.046, what = "restore-journal" }'"#,
    );
    assert!(summary.duration_s < 120.0, "{}", summary.duration_s);
}

/// Its turn had ended but for a hand's breadth when its lidar was covered; an operator says where it stands, and it does not turn on.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_is_told_that_its_turn_has_ended_does_not_begin_it_again() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1567 --fault '{ at_s = 22.037, for_s = 10.623, what = "cover-lidar", robot = "amr-1" }'"#,
    );
}

/// Its new process has done what was ordered before the mediator has taken it in.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_restarts_and_answers_before_it_is_registered_holds_nobody() {
    passes(
        r#"rig scenario overtaking --stepped --seed 6669 --fault '{ at_s = 55.793, for_s = 0.072, what = "kill-robot", robot = "amr-2" }'"#,
    );
}

/// It stands just over the border while the way is blocked, and sees the end of the lane.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_waits_on_a_border_has_not_left_the_area_before() {
    passes(
        r#"rig scenario overtaking --stepped --seed 19 --fault '{ at_s = 53.14, for_s = 7.559, what = "box", robot = "amr-2" }'"#,
    );
}

/// It starts only then, and whoever stops it is still there.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_is_stopped_before_it_has_started_stands() {
    passes(
        r#"rig scenario overtaking --stepped --seed 4454 --fault '{ at_s = 2.375, for_s = 9.004, what = "stop", robot = "amr-2" }'"#,
    );
}

/// Operators wait for an answer before they ask again.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_hangs_while_it_is_looked_after_is_asked_once() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1862 --fault '{ at_s = 47.103, for_s = 2.762, what = "slip", robot = "amr-2", share = 0.24089999999999998 }' --fault '{ at_s = 50.304, for_s = 5.454, what = "hang", robot = "amr-2" }'"#,
    );
}

/// One that holds an unused grant gives it back.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_on_its_way_into_an_area_stops_before_a_clone_that_is_put_there() {
    passes(
        r#"rig scenario overtaking --stepped --seed 43 --fault '{ at_s = 15.675, for_s = 3.682, what = "pause", robot = "amr-2" }' --fault '{ at_s = 18.222, for_s = 27.748, what = "clone-robot", robot = "amr-2", pose = [4.0, -0.43, 204.0] }'"#,
    );
}

/// What a lidar repeats pulls the pose back to where the robot was, and it would drive over the border before which it stops.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_lidar_repeats_its_scan_stops_before_the_border() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1668 --fault '{ at_s = 23.86, for_s = 8.483, what = "freeze-scans", robot = "amr-2" }'"#,
    );
}

/// Its sensors say how fast it was before.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_restarts_while_its_sensors_are_frozen_does_not_brake_from_a_speed_that_it_has_not()
{
    passes(
        r#"rig scenario overtaking --stepped --seed 1932 --fault '{ at_s = 42.5, for_s = 9.208, what = "freeze-sensors", robot = "amr-2" }' --fault '{ at_s = 42.806, for_s = 1.977, what = "panic", robot = "amr-2", thread = "lidar" }'"#,
    );
}

/// What it stands in is its own yet, though neither the mediator nor its new process knows of the grant.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_and_the_mediator_that_forget_a_grant_at_once_harm_nobody() {
    passes(
        r#"rig scenario overtaking --stepped --seed 367 --fault '{ at_s = 64.86, for_s = 1.23, what = "kill-robot", robot = "amr-1" }' --fault '{ at_s = 65.993, for_s = 0.859, what = "lose-journal" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 2115 --fault '{ at_s = 50.68, for_s = 11.108, what = "lose-journal" }' --fault '{ at_s = 54.98, for_s = 1.353, what = "panic", robot = "amr-2", thread = "communication" }'"#,
    );
}

/// The mediator knows it to be elsewhere than it says: who says where it stands has not said that it may drive, and it stands while its
/// operator sees to what is behind it.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_its_mediator_has_elsewhere_stands_until_it_is_reset() {
    passes(
        r#"rig scenario overtaking --stepped --seed 411 --fault '{ at_s = 11.14, for_s = 0.337, what = "kill-mediator" }' --fault '{ at_s = 11.164, for_s = 5.683, what = "end-robot", robot = "amr-1" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 470 --fault '{ at_s = 13.74, for_s = 3.636, what = "reboot-mediator" }' --fault '{ at_s = 17.181, for_s = 3.59, what = "end-robot", robot = "amr-2" }'"#,
    );
}

/// Who looks at an area that such a robot has left sees it empty, however near it is.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_without_a_lease_does_not_come_back_to_where_it_was_a_moment_ago() {
    passes(
        r#"rig scenario overtaking --stepped --seed 305 --fault '{ at_s = 31.74, for_s = 0.422, what = "dead-link", robot = "amr-1" }' --fault '{ at_s = 31.858, for_s = 6.781, what = "teleop", robot = "amr-1", motion = [-0.394, 0.802] }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 832 --fault '{ at_s = 29.425, for_s = 2.711, what = "lose-journal" }'"#,
    );
}

/// Whoever wanted to drive it has gone before its program answers.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_hangs_is_not_in_the_hands_of_who_has_left() {
    passes(
        r#"rig scenario overtaking --stepped --seed 662 --fault '{ at_s = 25.02, for_s = 6.279, what = "hang", robot = "amr-1" }' --fault '{ at_s = 26.179, for_s = 0.643, what = "teleop", robot = "amr-1", motion = [-0.382, -0.682] }'"#,
    );
}

/// It is told where it stands, and in which state it was.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_has_ended_while_its_bus_was_gone_goes_on() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1581 --fault '{ at_s = 25.36, for_s = 4.376, what = "lose-interface", robot = "amr-1" }' --fault '{ at_s = 27.965, for_s = 0.647, what = "end-robot", robot = "amr-1" }'"#,
    );
}

/// A grant of the mediator that stands by is none of the one that goes on, and one of the robot none of its clone.
#[test]
#[ignore = "CI makes these runs"]
fn who_stands_somewhere_by_what_nobody_knows_of_has_not_come_in() {
    passes(
        r#"rig scenario overtaking --stepped --seed 2199 --fault '{ at_s = 21.94, for_s = 11.059, what = "copied-mediator" }' --fault '{ at_s = 31.016, for_s = 2.64, what = "panic", robot = "amr-2", thread = "navigation" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 1017 --fault '{ at_s = 9.098, for_s = 3.08, what = "dead-link", robot = "amr-2" }' --fault '{ at_s = 25.993, for_s = 5.554, what = "clone-robot", robot = "amr-2", pose = [0.75, 0.0, 4.0] }'"#,
    );
}

/// Its operator carries it back.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_was_driven_by_hand_to_where_it_finds_no_way_goes_on() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1023 --fault '{ at_s = 40.402, for_s = 0.071, what = "reboot-robot", robot = "amr-1" }' --fault '{ at_s = 75.464, for_s = 89.243, what = "teleop", robot = "amr-2", motion = [0.275, -0.952] }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 47 --fault '{ at_s = 60.031, for_s = 4.222, what = "teleop", robot = "amr-1", motion = [0.239, 0.628] }'"#,
    );
}

/// While it says that it does not know where it is, and when it is sent on before it has stopped, it is held to nothing.
#[test]
#[ignore = "CI makes these runs"]
fn who_does_not_know_and_who_is_sent_on_are_not_held_to_where_they_are() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1956 --fault '{ at_s = 66.16, for_s = 0.329, what = "freeze-sensors", robot = "amr-2" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 2127 --fault '{ at_s = 35.631, for_s = 0.473, what = "lose-journal" }'"#,
    );
}

/// Its process starts when the fault is over.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_is_to_end_before_it_has_begun_does_not_begin() {
    passes(
        r#"rig scenario overtaking --stepped --seed 134 --fault '{ at_s = 0.628, for_s = 18.848, what = "panic", robot = "amr-1" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 134 --fault '{ at_s = 0.628, for_s = 18.848, what = "end-robot", robot = "amr-1" }'"#,
    );
}

/// The mediator that stood by knows only what was going on when its journal was copied.
#[test]
#[ignore = "CI makes these runs"]
fn a_mediator_that_goes_on_after_its_copy_may_have_older_orders() {
    passes(
        r#"rig scenario overtaking --stepped --seed 171 --fault '{ at_s = 21.492, for_s = 2.209, what = "freeze-sensors", robot = "amr-1" }' --fault '{ at_s = 56.316, for_s = 84.598, what = "copied-mediator" }'"#,
    );
}

/// Its people know in which state it was before it lost its place, and tell its next process.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_panics_once_it_is_awake_goes_on_where_it_was() {
    passes(
        r#"rig scenario overtaking --stepped --seed 2417 --fault '{ at_s = 63.08, for_s = 2.181, what = "sleep", robot = "amr-1" }' --fault '{ at_s = 64.642, for_s = 0.511, what = "panic", robot = "amr-1", thread = "navigation" }'"#,
    );
}

/// Of the wall at the end of its lane it saw what noise had made shorter, before the rest came into sight.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_takes_no_wall_for_nearer_than_it_is_because_it_sees_no_farther() {
    passes(
        r#"rig scenario overtaking --stepped --seed 86 --fault '{ at_s = 65.46, for_s = 2.212, what = "fill-disk", robot = "amr-1" }'"#,
    );
}

/// Who says where it stands before its drive answers is refused: its people wait until it does.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_was_asleep_is_placed_once_its_drive_answers() {
    passes(
        r#"rig scenario overtaking --stepped --seed 132 --fault '{ at_s = 54.88, for_s = 1.339, what = "sleep", robot = "amr-2" }' --fault '{ at_s = 55.422, for_s = 7.513, what = "hang", robot = "amr-2", thread = "fieldbus" }'"#,
    );
}

/// A stop is not judged behind a jam, which ends while it is still off its path.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_pivot_was_jammed_stops_where_it_can() {
    passes(
        r#"rig scenario overtaking --stepped --seed 266 --fault '{ at_s = 35.614, for_s = 4.706, what = "delay-scans", robot = "amr-1", by_s = 0.248 }' --fault '{ at_s = 39.865, for_s = 32.634, what = "jam-pivot", robot = "amr-1" }' --fault '{ at_s = 41.67, for_s = 10.891, what = "stick-encoder", robot = "amr-1" }'"#,
    );
}

/// It was reset again and again while its pivot was jammed, a little farther off its path each time.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_pivot_is_jammed_for_long_is_reset_less_and_less_often() {
    passes(
        r#"rig scenario overtaking --stepped --seed 427 --fault '{ at_s = 30.36, for_s = 36.9, what = "jam-pivot", robot = "amr-1" }'"#,
    );
    passes(
        r#"rig scenario overtaking --stepped --seed 1250 --fault '{ at_s = 25.298, for_s = 85.56, what = "jam-pivot", robot = "amr-1" }'"#,
    );
}

/// One was let into the area ahead, and could not go there before the other one had left the area between, which waited for that one.
#[test]
#[ignore = "CI makes these runs"]
fn robots_that_wait_for_an_area_that_nobody_is_in_go_on() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1463 --fault '{ at_s = 42.883, for_s = 34.082, what = "jam-pivot", robot = "amr-2" }' --fault '{ at_s = 81.289, for_s = 2.981, what = "restore-journal" }'"#,
    );
}

/// Areas keep them apart, not the coordination, of which the second mediator does not know.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_another_mediator_lets_go_leaves_its_lay_by_and_enters_nothing() {
    let summary = passes(
        r#"rig scenario overtaking --stepped --seed 239 --fault '{ at_s = 48.221, for_s = 5.021, what = "cut-power", robot = "amr-2" }' --fault '{ at_s = 57.952, for_s = 5.956, what = "second-mediator" }' --fault '{ at_s = 57.952, for_s = 5.956, what = "partition", robot = "amr-1", mediator = "first" }' --fault '{ at_s = 57.952, for_s = 5.956, what = "partition", robot = "amr-2", mediator = "second" }'"#,
    );
    assert!(summary.during[0].checked_s > 10.0, "{summary:?}");
}

/// He asked while the motors were off, and was answered when they were on.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_is_reset_as_its_emergency_stop_is_released_may_go_on() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1261 --fault '{ at_s = 6.348, for_s = 6.157, what = "cut-motors", robot = "amr-2" }'"#,
    );
}

/// Its operator had just begun to speak.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_loses_its_power_while_it_is_placed_is_placed_later() {
    passes(
        r#"rig scenario overtaking --stepped --seed 1223 --fault '{ at_s = 0.383, for_s = 7.783, what = "hang", robot = "amr-2" }' --fault '{ at_s = 9.796, for_s = 0.614, what = "kill-robot", robot = "amr-1" }' --fault '{ at_s = 44.166, for_s = 38.933, what = "cover-lidar", robot = "amr-2" }' --fault '{ at_s = 51.137, for_s = 0.164, what = "freeze-lidar", robot = "amr-2" }' --fault '{ at_s = 82.117, for_s = 0.32, what = "cut-power", robot = "amr-2" }' --fault '{ at_s = 83.107, for_s = 78.94, what = "reload", robot = "amr-2", share = 0.3948 }'"#,
    );
}

/// What it turned meanwhile no encoder has counted: its pose was 2.9° off, and said to be certain to 0.2°.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_turns_without_power_for_a_moment_doubts_where_it_points() {
    passes(
        r#"rig scenario t-junction --stepped --seed 324 --fault '{ at_s = 29.158, for_s = 0.063, what = "cut-power", robot = "amr-1" }'"#,
    );
}

/// Who carries it stops it first.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_was_driven_off_its_lane_is_carried_back_when_all_is_over() {
    passes(
        r#"rig scenario t-junction --stepped --seed 431 --fault '{ at_s = 34.429, for_s = 3.021, what = "teleop", robot = "amr-3", motion = [0.138, -0.126] }' --fault '{ at_s = 137.175, for_s = 9.697, what = "panic", robot = "amr-1", thread = "navigation" }'"#,
    );
}
