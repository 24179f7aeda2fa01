//! How commands are adapted, one rule a test.

use super::stand::{AHEAD, Stand, parameters, with_detours, with_disc, without_detours};
use super::world::{MS, Random, SMALL, Thing, corridor, urg};
use crate::tubes::{Adapted, MotionTubes, Reason, StopRules, TubeSet, Verdict};
use description::geometry::{MotionCommand, Point2, Segment, Twist2};
use description::robot::{AdaptPolicy, Horizon, Tubes};

#[test]
fn it_begins_stopped_until_scans_have_been_good_for_two_seconds() {
    let mut stand = Stand::new(with_detours());
    let first = stand.ask(AHEAD, 0);
    assert_eq!(
        (first.verdict, first.reason),
        (Verdict::Stopped, Reason::NoScan)
    );
    assert_eq!(first.scan_age_ns, u64::MAX);
    let seen = stand.look(&corridor(), AHEAD, 2.5);
    for (tick, adapted) in seen.iter().enumerate() {
        if tick < 20 {
            assert_eq!(adapted.reason, Reason::AwaitingScans, "tick {tick}");
            assert_eq!(adapted.command.speed_m_s, 0.0);
        } else {
            assert_eq!(
                (adapted.verdict, adapted.reason),
                (Verdict::Free, Reason::None)
            );
            assert_eq!(adapted.command, AHEAD);
            assert_eq!(adapted.stopped_since_ns, 0);
        }
    }
}

#[test]
fn without_a_scan_for_250_ms_it_stops_and_resumes_after_two_good_seconds() {
    let mut stand = Stand::ready();
    assert_eq!(stand.ask(AHEAD, 240).verdict, Verdict::Free);
    let blind = stand.ask(AHEAD, 260);
    assert_eq!(
        (blind.verdict, blind.reason),
        (Verdict::Stopped, Reason::NoScan)
    );
    assert_eq!(blind.stopped_since_ns, stand.robot.now_ns + 260 * MS);
    stand.robot.drive(Twist2::default(), 0.4);
    let seen = stand.look(&corridor(), AHEAD, 2.3);
    assert_eq!(seen[0].reason, Reason::AwaitingScans);
    assert_eq!(seen[19].reason, Reason::AwaitingScans);
    assert_eq!(seen[19].stopped_since_ns, blind.stopped_since_ns);
    assert_eq!(seen[21].verdict, Verdict::Free);
    // Once at the start, once now.
    assert_eq!(stand.tubes.counters().blind_stops, 1);
}

#[test]
fn the_times_are_configurable() {
    let mut stand = Stand::with_rules(StopRules {
        good_scans_s: 0.5,
        scan_timeout_s: 0.15,
        ..StopRules::default()
    });
    let seen = stand.look(&corridor(), AHEAD, 0.8);
    assert_eq!(seen[4].reason, Reason::AwaitingScans);
    assert_eq!(seen[5].verdict, Verdict::Free);
    assert_eq!(stand.ask(AHEAD, 160).reason, Reason::NoScan);
}

#[test]
fn a_wall_at_hand_stops_and_two_free_seconds_resume() {
    let mut stand = Stand::ready();
    let mut walled = corridor();
    walled.push(Thing::Wall(Segment::new(
        Point2::new(3.45, -1.6),
        Point2::new(3.45, 1.6),
    )));
    let stopped = stand.look(&walled, AHEAD, 1.0);
    for adapted in &stopped {
        assert_eq!(
            (adapted.verdict, adapted.reason),
            (Verdict::Stopped, Reason::Blocked)
        );
        assert!(
            (adapted.clearance_m - 0.13).abs() < 0.005,
            "{}",
            adapted.clearance_m
        );
        assert_eq!(adapted.stopped_since_ns, stopped[0].stopped_since_ns);
    }
    let freed = stand.look(&corridor(), AHEAD, 3.0);
    let resumed = freed
        .iter()
        .position(|adapted| adapted.verdict == Verdict::Free)
        .unwrap();
    // Three scans until a tube counts as free, then two seconds.
    assert_eq!(resumed, 22);
    assert_eq!(freed[10].reason, Reason::Resuming);
    assert_eq!(stand.tubes.counters().blocked_stops, 1);
}

#[test]
fn a_block_that_comes_back_starts_the_two_seconds_again() {
    let mut stand = Stand::ready();
    let walled = with_disc(3.6, -0.5, 0.2);
    stand.look(&walled, AHEAD, 0.5);
    stand.look(&corridor(), AHEAD, 1.8);
    stand.look(&walled, AHEAD, 0.1);
    let freed = stand.look(&corridor(), AHEAD, 2.1);
    assert!(
        freed
            .iter()
            .all(|adapted| adapted.verdict == Verdict::Stopped)
    );
}

#[test]
fn between_scans_it_only_slows_down() {
    let mut stand = Stand::ready();
    stand.twist = Twist2::new(0.2, 0.0);
    let slow = stand.ask(MotionCommand::new(0.2, 0.0), 10);
    assert_eq!(slow.command.speed_m_s, 0.2);
    assert_eq!(stand.ask(AHEAD, 20).command.speed_m_s, 0.2);
    let seen = stand.look(&corridor(), AHEAD, 0.1);
    assert_eq!(seen[0].command.speed_m_s, 0.4);
}

#[test]
fn an_ageing_scan_costs_speed_where_the_tube_is_short() {
    let parameters = Tubes {
        horizons: vec![Horizon {
            horizon_s: 0.25,
            speed_m_s: 0.4,
        }],
        ..parameters()
    };
    let (set, _) = TubeSet::generate(&parameters, &SMALL, &urg()).unwrap();
    let mut stand = Stand::ready();
    stand.tubes = MotionTubes::new(set, with_detours(), StopRules::default()).unwrap();
    stand.look(&corridor(), AHEAD, 2.5);
    let mut before = 0.4;
    for age_ms in [0, 50, 100, 150, 200, 250] {
        let speed_m_s = stand.ask(AHEAD, age_ms).command.speed_m_s;
        // v·(age + reaction) + v²/2a stays within the 0.1 m of the tube.
        let needed_m = speed_m_s * (age_ms as f64 * 1e-3 + 0.1) + speed_m_s.powi(2) / 4.0;
        assert!(needed_m <= 0.1 + 1e-9, "{needed_m}");
        assert!(speed_m_s <= before && speed_m_s > 0.2);
        before = speed_m_s;
    }
    assert!(before < 0.28);
    stand.look(&corridor(), AHEAD, 0.1);
    stand.twist = Twist2::new(0.8, 0.0);
    assert_eq!(stand.ask(AHEAD, 0).reason, Reason::TooFast);
}

#[test]
fn a_thing_at_the_edge_of_the_lane_shifts_within_the_band() {
    // 1.2 m ahead of the front, its rim 6 cm into the tube.
    let things = with_disc(4.5, -0.5 - 0.15 - 0.04, 0.1);
    let mut stand = Stand::ready();
    let seen = stand.look(&things, AHEAD, 1.0);
    let last = seen.last().unwrap();
    assert_eq!(last.verdict, Verdict::Shifted, "{last:?}");
    let shift_1_m = last.command.curvature_1_m;
    assert!(
        shift_1_m > 0.0 && shift_1_m <= 0.4,
        "to the left, by {shift_1_m}"
    );

    // With no band it keeps the path, and slows.
    let mut stand = Stand::new(AdaptPolicy {
        curvature_band_1_m: 0.0,
        ..with_detours()
    });
    let seen = stand.look(&things, AHEAD, 3.0);
    let last = seen.last().unwrap();
    assert_eq!(
        (last.verdict, last.command.curvature_1_m),
        (Verdict::Slowed, 0.0)
    );
    assert!(last.command.speed_m_s < 0.36);
}

#[test]
fn a_thing_in_the_middle_does_not_make_it_flutter() {
    let mut stand = Stand::ready();
    let random = &mut Random(11);
    let things = with_disc(5.05, -0.5, 0.05);
    let mut changes = 0;
    let mut before: Option<Adapted> = None;
    for _ in 0..100 {
        // The wanted curvature wavers about the middle, and ranges about the end of the longest tube.
        let wanted = MotionCommand::new(0.4, random.between(-0.03, 0.03));
        stand.robot.drive(Twist2::default(), 0.1);
        stand.robot.noise_m = 0.01;
        stand.robot.measure_with(&things, random);
        stand
            .tubes
            .observe(&stand.robot.scan, stand.robot.now_ns)
            .unwrap();
        let adapted = stand.ask(wanted, 0);
        if let Some(before) = before {
            let sides = before.command.curvature_1_m * adapted.command.curvature_1_m;
            changes += usize::from(adapted.verdict == Verdict::Shifted && sides < -0.01);
            changes +=
                usize::from((before.command.speed_m_s - adapted.command.speed_m_s).abs() > 0.04);
        }
        before = Some(adapted);
    }
    assert!(changes <= 6, "{changes} changes in 10 s");
}

#[test]
fn what_it_cannot_judge_it_does_not_drive() {
    let mut stand = Stand::ready();
    let reason = |stand: &mut Stand, wanted| {
        stand.look(&corridor(), AHEAD, 0.1);
        let adapted = stand.ask(wanted, 0);
        assert_eq!(
            (adapted.verdict, adapted.command.speed_m_s),
            (Verdict::Stopped, 0.0)
        );
        adapted.reason
    };
    assert_eq!(
        reason(&mut stand, MotionCommand::new(-0.1, 0.0)),
        Reason::UnknownFloor
    );
    assert_eq!(
        reason(&mut stand, MotionCommand::new(f64::NAN, 0.0)),
        Reason::NotFinite
    );
    assert_eq!(
        reason(&mut stand, MotionCommand::new(0.1, f64::INFINITY)),
        Reason::NotFinite
    );
    assert_eq!(
        reason(&mut stand, MotionCommand::new(0.1, 9.0)),
        Reason::BeyondTubes
    );
    assert_eq!(
        reason(&mut stand, MotionCommand::new(0.1, -1e300)),
        Reason::BeyondTubes
    );
    stand.twist = Twist2::new(0.0, f64::NAN);
    assert_eq!(stand.ask(AHEAD, 0).reason, Reason::NotFinite);
}

#[test]
fn unknown_directions_are_blocked_where_they_are_wide() {
    let mut stand = Stand::ready();
    let raw_with = |unknown: std::ops::Range<usize>| {
        let mut raw = vec![0u16; 682];
        for (code, beam) in (1..20u16).cycle().zip(unknown) {
            raw[beam] = code;
        }
        raw
    };
    let mut verdict = |raw: &[u16]| {
        let mut adapted = Adapted::default();
        for _ in 0..30 {
            stand.robot.drive(Twist2::default(), 0.1);
            let stamp_ns = stand.robot.now_ns - urg().duration_ns();
            stand
                .robot
                .scan
                .align(raw, stamp_ns, &stand.robot.history)
                .unwrap();
            stand
                .tubes
                .observe(&stand.robot.scan, stand.robot.now_ns)
                .unwrap();
            adapted = stand.ask(AHEAD, 0);
        }
        adapted.verdict
    };
    assert_eq!(verdict(&raw_with(340..341)), Verdict::Free);
    assert_eq!(verdict(&raw_with(330..350)), Verdict::Slowed);
    assert_eq!(verdict(&raw_with(0..682)), Verdict::Stopped);
    assert_eq!(verdict(&raw_with(0..0)), Verdict::Free);
}
#[test]
fn a_nonsense_policy_is_refused() {
    let (set, _) = TubeSet::generate(&parameters(), &SMALL, &urg()).unwrap();
    let refused = |policy, rules, key: &str| {
        let error = MotionTubes::new(set.clone(), policy, rules).unwrap_err();
        assert!(error.to_string().starts_with(key), "{error}");
    };
    let (policy, rules) = (with_detours(), StopRules::default());
    for (key, spoil) in [
        (
            "tubes.curvature_band_1_m",
            (|policy| policy.curvature_band_1_m = -0.1) as fn(&mut AdaptPolicy),
        ),
        ("tubes.free_scans", |policy| policy.free_scans = 0),
        ("tubes.resume_after_s", |policy| {
            policy.resume_after_s = -1.0
        }),
        ("tubes.detour_after_s", |policy| {
            policy.detour.after_s = f64::NAN
        }),
    ] {
        let mut policy = policy;
        spoil(&mut policy);
        refused(policy, rules, key);
    }
    let deceleration_m_s2 = 0.0;
    let stop = StopRules {
        deceleration_m_s2,
        ..rules
    };
    refused(policy, stop, "drive.stop_deceleration_m_s2");
    let scan_timeout_s = f64::NAN;
    let blind = StopRules {
        scan_timeout_s,
        ..rules
    };
    refused(policy, blind, "lidar.scan_timeout_ms");
}

#[test]
fn by_hand_it_creeps_with_a_smaller_margin_where_nothing_else_is_free() {
    let parameters = Tubes {
        augment_m: 0.12,
        by_hand_augment_m: 0.045,
        ..parameters()
    };
    let (set, _) = TubeSet::generate(&parameters, &SMALL, &urg()).unwrap();
    let tubes = MotionTubes::new(set, without_detours(), StopRules::default()).unwrap();
    // A wall 0.12 m beside it.
    let mut things = corridor();
    let wall = Segment::new(Point2::new(0.0, -0.77), Point2::new(10.0, -0.77));
    things.push(Thing::Wall(wall));
    let mut stand = Stand::new(without_detours());
    stand.tubes = tubes;
    let last = |seen: Vec<Adapted>| *seen.last().expect("it looked");
    let speed_m_s = |adapted: Adapted| adapted.command.speed_m_s;
    let alone = last(stand.look(&things, AHEAD, 3.0));
    assert_eq!(alone.reason, Reason::Blocked);
    stand.tubes.drive_by_hand(true);
    assert_eq!(
        speed_m_s(last(stand.look(&things, AHEAD, 0.2))),
        0.0,
        "three scans"
    );
    let by_hand = last(stand.look(&things, AHEAD, 3.0));
    assert_eq!(
        (by_hand.verdict, by_hand.reason),
        (Verdict::Slowed, Reason::Blocked)
    );
    assert_eq!(speed_m_s(by_hand), 0.1, "the slowest");
    let back = MotionCommand::new(-0.4, 0.0);
    stand.tubes.trust_behind(2.0);
    let behind = last(stand.look(&things, back, 3.0));
    assert_eq!(speed_m_s(behind), -0.1, "{behind:?}");
    // Nearer than the smaller margin.
    things.push(Thing::Wall(Segment::new(
        Point2::new(0.0, -0.68),
        Point2::new(10.0, -0.68),
    )));
    assert_eq!(
        last(stand.look(&things, AHEAD, 0.5)).reason,
        Reason::Blocked
    );
    assert_eq!(last(stand.look(&things, back, 0.5)).reason, Reason::Blocked);
    things.truncate(5);
    stand.tubes.drive_by_hand(false);
    assert_eq!(
        last(stand.look(&things, AHEAD, 3.0)).reason,
        Reason::Blocked
    );
}
