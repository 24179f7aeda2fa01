//! Second processes with the name of a robot that is heard: each is another body, which stands where it says.

use contract::VERSION;
use contract::client::{Client, Situation};
use contract::timing::{ENTERS_NO_MORE_NS, SILENT_AFTER_NS};
use contract::wire;
use mediator::journal::{ClosedRecord, Stored};
use mediator::manager::{AbsentError, Alarm, ClearError, Manager};
use mediator::setup::Setup;

use crate::takeover::{AREA, NOW_NS, cleared_of, floor, robot, setup, start, talk};

const STEP_NS: u64 = SILENT_AFTER_NS / 5;

type Robots = Vec<(Client, Situation)>;

/// The first robot asks for the gate, the third one for the yard; the second one has clones.
fn asked_for() -> (Manager, Robots) {
    let mut manager = start(&Stored::new(1), 50, 0);
    let mut robots: Robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[])).into();
    talk(&mut manager, &mut robots, NOW_NS);
    robots[0].1.wanted = vec![AREA.to_owned()];
    robots[2].1.wanted = vec!["yard".to_owned()];
    (manager, robots)
}

/// All know which areas there are, and nobody asks for one.
fn on_a_known_floor() -> (Manager, Robots) {
    on_a_floor_of(&setup())
}

fn on_a_floor_of(setup: &Setup) -> (Manager, Robots) {
    let setup = Setup {
        floor: floor(3.0),
        ..setup.clone()
    };
    let mut manager = Manager::new(&setup, &Stored::new(1), 0).expect("valid");
    let mut robots: Robots = { ["amr-1", "amr-2", "amr-3"].iter() }
        .map(|id| {
            let (client, situation) = robot(id, &[]);
            (client.on(floor(3.0)), situation)
        })
        .collect();
    talk(&mut manager, &mut robots, NOW_NS);
    (manager, robots)
}

/// All talk, once in each of these rounds.
fn rounds(manager: &mut Manager, robots: &mut Robots, rounds: std::ops::Range<u64>) {
    for round in rounds {
        talk(manager, robots, NOW_NS + round * STEP_NS);
    }
}

fn stands_in(area: &str) -> Situation {
    Situation {
        located: true,
        stands_in: vec![area.to_owned()],
        ..Situation::default()
    }
}

fn clone_of_the_second(boot_epoch: u64, area: &str) -> (Client, Situation) {
    (Client::new("amr-2", "hall", boot_epoch), stands_in(area))
}

/// It is refused.
fn one_with_another_floor(boot_epoch: u64, area: &str) -> (Client, Situation) {
    let (client, situation) = clone_of_the_second(boot_epoch, area);
    (client.on(floor(4.0)), situation)
}

#[test]
fn each_of_several_is_in_the_way() {
    let (mut manager, mut robots) = asked_for();
    robots.push(clone_of_the_second(8, AREA));
    robots.push(clone_of_the_second(9, "yard"));
    // Robots report in this order: the clones are heard before anybody is granted anything.
    robots.rotate_right(2);
    for round in 0..40 {
        let status = talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(
            !robots[2].0.holds(AREA) && !robots[4].0.holds("yard"),
            "{round}: {status:?}"
        );
        assert_eq!(status.robots[1].second_in, [AREA, "yard"]);
    }
    // One is taken away, which changes nothing for the other.
    robots.remove(0);
    for round in 40..50 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    let now_ns = NOW_NS + 50 * STEP_NS;
    assert_eq!(
        manager.clear(AREA, true, now_ns),
        cleared_of("a second process of amr-2")
    );
    let heard = manager.clear("yard", true, now_ns);
    assert!(matches!(heard, Err(ClearError::Heard { .. })), "{heard:?}");
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[1].0.holds(AREA) && !robots[3].0.holds("yard"));
}

#[test]
fn one_that_was_found_before_and_comes_back_is_in_the_way_again() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    rounds(&mut manager, &mut robots, 0..30);
    let first = robots.pop().expect("the clone");
    // Another one is found meanwhile.
    robots.push(clone_of_the_second(9, AREA));
    rounds(&mut manager, &mut robots, 30..70);
    robots.pop();
    rounds(&mut manager, &mut robots, 70..80);
    let told = { manager.alarms() }.filter(|alarm| matches!(alarm, Alarm::Doubled { .. }));
    assert_eq!(told.count(), 2);
    robots.push(first);
    rounds(&mut manager, &mut robots, 80..81);
    robots[0].1.wanted = vec![AREA.to_owned()];
    for round in 81..120 {
        let status = talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(!robots[0].0.holds(AREA), "{round}: {status:?}");
    }
}

#[test]
fn one_that_speaks_for_the_robot_later_is_not_in_its_own_way() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    // The second robot starts again where it stands: its process before still counts as heard.
    robots[1] = clone_of_the_second(8, AREA);
    robots[1].1.wanted = vec![AREA.to_owned()];
    let mut registered = false;
    for round in 0..20 {
        let was_registered = registered;
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        registered = robots[1].0.is_registered();
        assert!(!was_registered || robots[1].0.holds(AREA), "{round}");
    }
    assert!(registered);
}

#[test]
fn the_body_of_a_second_process_is_in_the_way_of_everybody() {
    let mut manager = start(&Stored::new(1), 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    // A clone of the second one stands in the gate.
    robots.push((Client::new("amr-2", "hall", 8), robots[1].1.clone()));
    robots[3].1.stands_in = vec![AREA.to_owned()];
    talk(&mut manager, &mut robots, NOW_NS);
    robots[0].1.wanted = vec![AREA.to_owned()];
    robots[1].1.wanted = vec![AREA.to_owned()];
    for round in 0..40 {
        let now_ns = NOW_NS + round * SILENT_AFTER_NS / 5;
        let status = talk(&mut manager, &mut robots, now_ns);
        assert!(
            robots.iter().all(|(client, _)| !client.holds(AREA)),
            "{round}: {status:?}"
        );
        assert!(!robots[3].0.is_registered());
    }
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(
        matches!(&alarms[..], [Alarm::Doubled { .. }]),
        "nobody is accused: {alarms:?}"
    );
    // Its link breaks: silent is not gone.
    robots.pop();
    let mut now_ns = NOW_NS;
    for round in 40..60 {
        now_ns = NOW_NS + round * STEP_NS;
        talk(&mut manager, &mut robots, now_ns);
        assert!(robots.iter().all(|(client, _)| !client.holds(AREA)));
    }
    let alarms: Vec<Alarm> = manager.alarms().collect();
    let silent = matches!(&alarms[..], [Alarm::SilentSecond { areas, .. }] if areas == AREA);
    assert!(silent, "{alarms:?}");
    let inside = manager.clear(AREA, false, now_ns);
    assert!(
        matches!(inside, Err(ClearError::Inside { .. })),
        "{inside:?}"
    );
    // People are told that it is not the robot itself, which is heard elsewhere.
    let why = manager.why("amr-1", now_ns).expect("a robot");
    assert!(
        why.contains("a second process of amr-2 (silent") && !why.contains(", amr-2"),
        "{why}"
    );
    let area = manager.status(now_ns).areas.remove(0);
    assert!(area.blocked && area.standing.is_empty(), "{area:?}");
    assert_eq!(area.seconds, ["amr-2"]);
    let closed = manager.close(AREA, ClosedRecord::default(), now_ns);
    let closed = closed.expect("a known area");
    assert!(closed.standing.is_empty() && closed.granted.is_empty());
    assert_eq!(closed.seconds, ["amr-2"]);
    assert_eq!(manager.open(AREA, now_ns), Ok(true));
    // Somebody takes it away.
    assert_eq!(
        manager.clear(AREA, true, now_ns),
        cleared_of("a second process of amr-2")
    );
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[0].0.holds(AREA));
    let status = manager.status(now_ns);
    assert!(status.robots[1].heard && status.robots[1].second_in.is_empty());
}

/// The mediator starts again before its link is back.
#[test]
fn one_that_was_found_is_where_it_was_heard_last_also_for_the_next_mediator() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots: Robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[])).into();
    talk(&mut manager, &mut robots, NOW_NS);
    robots.push(clone_of_the_second(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    manager.entries().for_each(|entry| stored.apply(entry));
    let (mut clone, _) = robots.pop().expect("the clone");
    let mut manager = start(&stored, 51, NOW_NS + 30 * STEP_NS);
    robots[0].1.wanted = vec![AREA.to_owned()];
    for round in 30..80 {
        let status = talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(
            status.awaited.is_empty() && !robots[0].0.holds(AREA),
            "{round}: {status:?}"
        );
    }
    // It is heard again, and elsewhere.
    let now_ns = NOW_NS + 80 * STEP_NS;
    clone.step(stands_in("yard"), now_ns, SILENT_AFTER_NS);
    robots.push((clone, stands_in("yard")));
    talk(&mut manager, &mut robots, now_ns);
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[0].0.holds(AREA));
    assert_eq!(manager.status(now_ns).robots[1].second_in, ["yard"]);
}

/// Nobody has told it from a restart yet, and the robot's own report is the last one that the mediator waits for.
#[test]
fn one_that_is_heard_before_its_robot_after_a_start_is_in_the_way() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots: Robots = ["amr-1", "amr-3", "amr-2"].map(|id| robot(id, &[])).into();
    talk(&mut manager, &mut robots, NOW_NS);
    robots[0].1.wanted = vec![AREA.to_owned()];
    manager.entries().for_each(|entry| stored.apply(entry));
    for first_ns in [1, SILENT_AFTER_NS / 4, SILENT_AFTER_NS] {
        let (mut robots, started_ns) = (robots.clone(), NOW_NS + SILENT_AFTER_NS);
        let mut manager = start(&stored, 51, started_ns);
        let (mut clone, situation) = clone_of_the_second(8, AREA);
        for round in 0..5 {
            let now_ns = started_ns + first_ns + round;
            clone.step(situation.clone(), now_ns, SILENT_AFTER_NS);
            manager.report(&clone.report(), now_ns);
            while let Some(message) = manager.next_message(now_ns) {
                clone.receive(&message, now_ns);
            }
            manager.tick(now_ns);
        }
        for round in 0..4 {
            let now_ns = started_ns + first_ns + 10 + round;
            let status = talk(&mut manager, &mut robots, now_ns);
            assert!(
                status.awaited.is_empty() && !robots[0].0.holds(AREA),
                "{first_ns}: {status:?}"
            );
        }
    }
}

/// A link is tried once a second: the clone's may be first.
#[test]
fn one_that_is_heard_before_its_robot_after_a_start_does_not_speak_for_it() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots: Robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[])).into();
    talk(&mut manager, &mut robots, NOW_NS);
    manager.entries().for_each(|entry| stored.apply(entry));
    let started_ns = NOW_NS + SILENT_AFTER_NS;
    let mut manager = start(&stored, 51, started_ns);
    let mut clones = vec![clone_of_the_second(8, "yard")];
    for round in 3..8 {
        talk(&mut manager, &mut clones, started_ns + round * STEP_NS);
    }
    assert!(!clones[0].0.is_registered());
    for round in 8..12 {
        talk(&mut manager, &mut robots, started_ns + round * STEP_NS);
    }
    assert!(robots[1].0.is_registered());
}

/// One image on three robots.
#[test]
fn each_of_several_is_found_and_speaks_for_nobody() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots.push(clone_of_the_second(8, "yard"));
    robots.push(clone_of_the_second(9, "yard"));
    for round in 0..40 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    let alarms = { manager.alarms() }.filter(|alarm| matches!(alarm, Alarm::Doubled { .. }));
    assert_eq!(alarms.count(), 2);
    // The robot's link breaks.
    let (own, situation) = robots.remove(1);
    for round in 40..80 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(robots[2..].iter().all(|(clone, _)| !clone.is_registered()));
    }
    robots.push((own, situation));
    talk(&mut manager, &mut robots, NOW_NS + 80 * STEP_NS);
    assert!(robots[4].0.is_registered());
}

/// Of another robot, or of the one that was let in: its body meets the clone's.
#[test]
fn one_that_appears_where_somebody_was_let_in_takes_back_what_was_not_entered_yet() {
    for of in ["amr-2", "amr-1"] {
        let (mut manager, mut robots) = asked_for();
        talk(&mut manager, &mut robots, NOW_NS);
        assert!(robots[0].0.holds(AREA) && robots[2].0.holds("yard"));
        let now_ns = NOW_NS + STEP_NS;
        let (mut clone, situation) = (Client::new(of, "hall", 8), stands_in(AREA));
        clone.step(situation.clone(), now_ns, SILENT_AFTER_NS);
        manager.report(&clone.report(), now_ns);
        manager.tick(now_ns);
        assert_eq!(manager.counters().revocations, 1, "{of}");
        let status = manager.status(now_ns);
        assert!(status.areas[0].closed && !status.areas[1].closed, "{of}");
        // It was not in there, and gives it back. It is let in when the clone has gone.
        robots.push((clone, situation));
        talk(&mut manager, &mut robots, now_ns);
        assert!(
            !robots[0].0.holds(AREA) && robots[2].0.holds("yard"),
            "{of}"
        );
        robots.pop();
        for round in 2..20 {
            talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        }
        assert!(robots[0].0.holds(AREA), "{of}");
        assert_eq!(manager.counters().revocations, 1, "{of}");
        let alarms: Vec<Alarm> = manager.alarms().collect();
        assert!(alarms.is_empty(), "nobody is accused: {alarms:?}");
    }
}

#[test]
fn one_that_appears_where_somebody_is_takes_nothing_back() {
    for of in ["amr-2", "amr-1"] {
        let (mut manager, mut robots) = asked_for();
        talk(&mut manager, &mut robots, NOW_NS);
        robots[0].1.stands_in = vec![AREA.to_owned()];
        talk(&mut manager, &mut robots, NOW_NS);
        robots.push((Client::new(of, "hall", 8), stands_in(AREA)));
        for round in 1..10 {
            talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
            assert!(robots[0].0.holds(AREA), "{of}");
        }
        assert_eq!(manager.counters().revocations, 0, "{of}");
    }
}

/// It asks to speak for the silent robot, and stands where another one was let in.
#[test]
fn a_process_that_does_not_speak_for_its_robot_yet_takes_back_what_was_not_entered_yet() {
    let (mut manager, mut robots) = asked_for();
    robots.remove(1);
    assert_eq!(manager.status(NOW_NS).robots[1].id, "amr-2");
    for round in 0..10 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    assert!(robots[0].0.holds(AREA));
    let now_ns = NOW_NS + 10 * STEP_NS;
    let (mut next, situation) = (Client::new("amr-2", "hall", 8), stands_in(AREA));
    next.step(situation, now_ns, SILENT_AFTER_NS);
    manager.report(&next.report(), now_ns);
    manager.tick(now_ns);
    assert!(!next.is_registered());
    assert_eq!(manager.counters().revocations, 1);
    talk(&mut manager, &mut robots, now_ns);
    assert!(!robots[0].0.holds(AREA));
}

/// People end the wrong one of the two, or it loses its link: the body of the other one is where it was.
#[test]
fn one_that_was_found_stays_in_the_way_when_the_first_one_is_heard_no_more() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(matches!(&alarms[..], [Alarm::Doubled { .. }]), "{alarms:?}");
    robots.remove(1);
    robots[0].1.wanted = vec![AREA.to_owned()];
    let mut now_ns = NOW_NS;
    for round in 30..80 {
        now_ns = NOW_NS + round * STEP_NS;
        let status = talk(&mut manager, &mut robots, now_ns);
        assert!(!robots[0].0.holds(AREA), "{round}: {status:?}");
    }
    assert!(matches!(
        manager.clear(AREA, true, now_ns),
        Err(ClearError::Heard { .. })
    ));
    let heard = AbsentError::Heard("amr-2".to_owned());
    assert_eq!(manager.absent("amr-2", false, now_ns), Err(heard));
    // It is heard no more as well, and people take both away.
    robots.pop();
    now_ns += ENTERS_NO_MORE_NS;
    talk(&mut manager, &mut robots, now_ns);
    assert!(!robots[0].0.holds(AREA));
    let inside = manager.absent("amr-2", false, now_ns);
    assert!(
        matches!(inside, Err(AbsentError::Inside { .. })),
        "{inside:?}"
    );
    assert_eq!(
        manager.absent("amr-2", true, now_ns),
        Ok(vec![AREA.to_owned()])
    );
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[0].0.holds(AREA));
}

/// People end the wrong one and restart the right one, which is another process where the one before stood.
#[test]
fn one_that_is_restarted_where_it_was_found_is_told_what_blocks_it() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    rounds(&mut manager, &mut robots, 0..30);
    robots.pop();
    robots[1] = clone_of_the_second(9, AREA);
    robots[1].1.wanted = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 30..50);
    let now_ns = NOW_NS + 50 * STEP_NS;
    assert!(robots[1].0.is_registered() && !robots[1].0.holds(AREA));
    let why = manager.why("amr-2", now_ns).expect("a robot");
    let remedy = "`mediator clear gate --taken-away`";
    assert!(
        why.contains("a second process of amr-2") && why.contains(remedy),
        "{why}"
    );
    assert!(manager.clear(AREA, true, now_ns).is_ok());
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[1].0.holds(AREA));
}

/// Somebody is heard there, so what is silent may be taken for gone of second processes only.
#[test]
fn who_clears_them_is_told_who_is_still_there() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots[2].1.wanted.clear();
    for robot in [0, 2] {
        robots[robot].1.stands_in = vec![AREA.to_owned()];
    }
    robots.push(clone_of_the_second(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    robots.truncate(2);
    let now_ns = NOW_NS + 40 * STEP_NS;
    talk(&mut manager, &mut robots, now_ns);
    let done = manager.clear(AREA, true, now_ns).expect("silent");
    assert_eq!(done.of, ["a second process of amr-2"]);
    let silent = "amr-3 (silent: `mediator absent amr-3 --taken-away`)";
    assert_eq!(done.left, ["amr-1 (heard)", silent]);
}

/// Somebody pushes it: it reports on, and does not know where it is.
#[test]
fn one_that_has_lost_its_pose_is_heard_where_it_was_found() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    robots[3].1.located = false;
    let mut now_ns = NOW_NS;
    for round in 30..50 {
        now_ns = NOW_NS + round * STEP_NS;
        talk(&mut manager, &mut robots, now_ns);
    }
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(matches!(&alarms[..], [Alarm::Doubled { .. }]), "{alarms:?}");
    let heard = manager.clear(AREA, true, now_ns);
    assert!(matches!(heard, Err(ClearError::Heard { .. })), "{heard:?}");
    assert_eq!(manager.status(now_ns).robots[1].second_in, [AREA]);
}

/// Somebody pushes it before it is known to be another body.
#[test]
fn one_that_loses_its_pose_before_it_is_found_is_where_it_was() {
    for lost_in in [5, 9, 14] {
        let mut stored = Stored::new(1);
        let (mut manager, mut robots) = asked_for();
        robots[0].1.wanted.clear();
        robots[2].1.wanted.clear();
        robots.push(clone_of_the_second(8, AREA));
        rounds(&mut manager, &mut robots, 0..lost_in);
        assert_eq!(manager.alarms().count(), 0, "not found yet");
        robots[3].1.located = false;
        rounds(&mut manager, &mut robots, lost_in..30);
        robots.pop();
        robots[0].1.wanted = vec![AREA.to_owned()];
        rounds(&mut manager, &mut robots, 30..50);
        assert!(!robots[0].0.holds(AREA), "lost in round {lost_in}");
        manager.entries().for_each(|entry| stored.apply(entry));
        let started_ns = NOW_NS + 50 * STEP_NS;
        let status = start(&stored, 51, started_ns).status(started_ns);
        assert_eq!(status.robots[1].second_in, [AREA]);
    }
}

/// A report from before it was pushed comes after the mediator has started.
#[test]
fn one_that_was_found_is_not_moved_back_by_what_is_late_after_a_start() {
    let mut stored = Stored::new(1);
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots[2].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    let late = robots[3].0.report();
    robots[3].1 = stands_in("yard");
    talk(&mut manager, &mut robots, NOW_NS + 30 * STEP_NS);
    manager.entries().for_each(|entry| stored.apply(entry));
    let started_ns = NOW_NS + 31 * STEP_NS;
    let mut manager = start(&stored, 51, started_ns);
    manager.report(&late, started_ns + 1);
    assert_eq!(manager.status(started_ns + 1).robots[1].second_in, ["yard"]);
}

#[test]
fn one_that_was_found_has_its_time_to_be_heard_after_a_start() {
    let mut stored = Stored::new(1);
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    manager.entries().for_each(|entry| stored.apply(entry));
    let started_ns = NOW_NS + 30 * STEP_NS;
    let mut manager = start(&stored, 51, started_ns);
    manager.tick(started_ns + STEP_NS);
    assert_eq!(manager.alarms().count(), 0);
    let early = manager.clear(AREA, true, started_ns + STEP_NS);
    assert!(matches!(early, Err(ClearError::Heard { .. })), "{early:?}");
    let now_ns = started_ns + ENTERS_NO_MORE_NS + 1;
    manager.tick(now_ns);
    let mut alarms = manager.alarms();
    assert!(alarms.any(|alarm| matches!(alarm, Alarm::SilentSecond { .. })));
    drop(alarms);
    assert!(manager.clear(AREA, true, now_ns).is_ok());
}

/// Robots follow another mediator meanwhile.
#[test]
fn one_that_was_found_is_where_it_was_heard_last_while_the_mediator_stands_by() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    let mut clones = vec![clone_of_the_second(8, AREA)];
    for round in 0..30 {
        let now_ns = NOW_NS + round * STEP_NS;
        talk(&mut manager, &mut robots, now_ns);
        talk(&mut manager, &mut clones, now_ns);
    }
    manager.alarms().for_each(drop);
    let mut stand_by = |manager: &mut Manager, now_ns: u64| {
        for (client, situation) in &mut robots {
            client.step(situation.clone(), now_ns, SILENT_AFTER_NS);
            let mut report = client.report();
            (report.mediator_instance, report.mediator_journal) = (99, 9);
            report.mediator_heard = true;
            manager.report(&report, now_ns);
        }
        manager.tick(now_ns);
        assert!(manager.stands_by());
    };
    for round in 30..40 {
        stand_by(&mut manager, NOW_NS + round * STEP_NS);
    }
    let silent = { manager.alarms() }.any(|alarm| matches!(alarm, Alarm::SilentSecond { .. }));
    assert!(!silent, "nobody can clear it here");
    clones[0].1 = stands_in("yard");
    let now_ns = NOW_NS + 40 * STEP_NS;
    stand_by(&mut manager, now_ns);
    talk(&mut manager, &mut clones, now_ns);
    assert_eq!(manager.status(now_ns).robots[1].second_in, ["yard"]);
}

/// Nobody could drive the robot out of an area in which only another body with its name is.
#[test]
fn robots_that_wait_for_one_do_not_wait_for_each_other() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted = vec!["yard".to_owned()];
    robots[2].1.wanted.clear();
    talk(&mut manager, &mut robots, NOW_NS);
    robots[0].1.stands_in = vec!["yard".to_owned()];
    robots[0].1.wanted = vec!["yard".to_owned(), AREA.to_owned()];
    robots.push(clone_of_the_second(8, AREA));
    // The clone is heard before the area is granted.
    robots.rotate_right(1);
    robots[2].1.wanted = vec!["yard".to_owned()];
    for round in 1..60 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(matches!(&alarms[..], [Alarm::Doubled { .. }]), "{alarms:?}");
    assert!(robots[1].0.holds("yard") && !robots[1].0.holds(AREA));
}

/// A copied image with an older site file.
#[test]
fn one_that_is_refused_for_its_floor_is_found_as_well() {
    let (mut manager, mut robots) = on_a_known_floor();
    robots.push(one_with_another_floor(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    let alarms: Vec<Alarm> = manager.alarms().collect();
    let [floor, doubled] = &alarms[..] else {
        panic!("{alarms:?}");
    };
    assert!(matches!(floor, Alarm::Floor { .. }) && matches!(doubled, Alarm::Doubled { .. }));
    robots.pop();
    robots[0].1.wanted = vec![AREA.to_owned()];
    for round in 30..50 {
        let status = talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(!robots[0].0.holds(AREA), "{round}: {status:?}");
    }
}

/// A robot that was carried, and switched on with the site file of yesterday: no other process of it runs.
#[test]
fn one_that_is_refused_while_nobody_speaks_for_its_robot_is_in_the_way() {
    let (mut manager, mut robots) = on_a_known_floor();
    robots[1] = one_with_another_floor(8, AREA);
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    let (_, there) = robots.remove(1);
    robots[0].1.wanted = vec![AREA.to_owned()];
    for round in 30..60 {
        let status = talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(!robots[0].0.holds(AREA), "{round}: {status:?}");
    }
    // With the right file it says itself where it is.
    let (client, _) = clone_of_the_second(9, AREA);
    robots.push((client.on(floor(3.0)), there));
    for round in 60..100 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(!robots[0].0.holds(AREA), "{round}");
    }
    robots[2].1.stands_in.clear();
    for round in 100..110 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    assert!(robots[0].0.holds(AREA), "it has left");
}

/// It was a copied image after all: the robot, whose link was cut meanwhile, is heard again from where it was.
#[test]
fn one_that_was_refused_alone_is_in_the_way_when_the_first_one_is_back() {
    let mut stored = Stored::new(1);
    let (mut manager, mut robots) = on_a_known_floor();
    let first = robots.remove(1);
    robots.push(one_with_another_floor(8, AREA));
    rounds(&mut manager, &mut robots, 0..30);
    robots.pop();
    rounds(&mut manager, &mut robots, 30..40);
    let alarms: Vec<Alarm> = manager.alarms().collect();
    let told = |alarm: &Alarm| matches!(alarm, Alarm::SilentSecond { areas, .. } if areas == AREA);
    assert!(alarms.iter().any(told), "{alarms:?}");
    robots.push(first);
    robots[0].1.wanted = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 40..60);
    assert!(!robots[0].0.holds(AREA));
    manager.entries().for_each(|entry| stored.apply(entry));
    let started_ns = NOW_NS + 60 * STEP_NS;
    let status = start(&stored, 51, started_ns).status(started_ns);
    assert_eq!(status.robots[1].second_in, [AREA]);
    let now_ns = NOW_NS + 60 * STEP_NS;
    assert!(manager.clear(AREA, true, now_ns).is_ok());
    rounds(&mut manager, &mut robots, 60..62);
    assert!(robots[0].0.holds(AREA));
}

/// A copied image is heard on, and does not know where it is when the robot itself is switched on.
#[test]
fn one_that_was_refused_alone_is_in_the_way_beside_a_new_one() {
    let (mut manager, mut robots) = on_a_known_floor();
    robots[1] = one_with_another_floor(8, AREA);
    rounds(&mut manager, &mut robots, 0..20);
    robots[1].1.located = false;
    let (client, _) = clone_of_the_second(9, "yard");
    robots.push((client.on(floor(3.0)), stands_in("yard")));
    robots[0].1.wanted = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 20..100);
    assert!(robots[3].0.is_registered() && !robots[0].0.holds(AREA));
    robots.remove(1);
    rounds(&mut manager, &mut robots, 100..120);
    assert!(!robots[0].0.holds(AREA), "found beside it");
}

/// It keeps the area that it has left, since it is to come back, as in a turn.
#[test]
fn one_that_appears_where_somebody_has_left_takes_back_what_that_keeps() {
    let (mut manager, mut robots) = asked_for();
    robots[2].1.wanted.clear();
    rounds(&mut manager, &mut robots, 0..3);
    assert!(robots[0].0.holds(AREA));
    robots[0].1.stands_in = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 3..5);
    robots[0].1.stands_in.clear();
    robots[1].1.wanted = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 5..7);
    assert!(robots[0].0.holds(AREA));
    let why = manager.why("amr-2", NOW_NS + 7 * STEP_NS);
    let why = why.expect("a robot");
    assert!(why.contains("amr-1 (has left it, may come back"), "{why}");
    robots[1].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    rounds(&mut manager, &mut robots, 7..12);
    assert!(!robots[0].0.holds(AREA));
}

/// A bay for two: the robot, out of reach, stands there beside a copied image, and drives on.
#[test]
fn one_that_was_refused_where_its_robot_stood_is_in_the_way_when_that_has_left() {
    for is_heard_on in [true, false] {
        let mut two = setup();
        two.areas[0].capacity = 2;
        let (mut manager, mut robots) = on_a_floor_of(&two);
        robots[0].1.wanted = vec!["yard".to_owned()];
        robots[1].1.wanted = vec![AREA.to_owned()];
        rounds(&mut manager, &mut robots, 0..2);
        robots[0].1.stands_in = vec!["yard".to_owned()];
        robots[1].1.stands_in = vec![AREA.to_owned()];
        rounds(&mut manager, &mut robots, 2..5);
        let first = robots.remove(1);
        rounds(&mut manager, &mut robots, 5..12);
        robots.push(one_with_another_floor(8, AREA));
        rounds(&mut manager, &mut robots, 12..20);
        if !is_heard_on {
            robots.pop();
        }
        robots[1].1.wanted = vec![AREA.to_owned()];
        rounds(&mut manager, &mut robots, 20..30);
        assert!(robots[1].0.holds(AREA), "one robot, for all that is known");
        robots[1].1.stands_in = vec![AREA.to_owned()];
        robots[0].1.wanted = vec!["yard".to_owned(), AREA.to_owned()];
        robots.insert(0, first);
        robots[0].1.stands_in.clear();
        robots[0].1.wanted.clear();
        rounds(&mut manager, &mut robots, 30..50);
        assert!(!robots[1].0.holds(AREA), "{is_heard_on}: two are in it");
    }
}

/// Its battery is empty a second after the robot itself was switched on elsewhere.
#[test]
fn one_that_was_refused_alone_and_is_heard_once_beside_a_new_one_is_in_the_way() {
    let (mut manager, mut robots) = on_a_known_floor();
    robots[1] = one_with_another_floor(8, AREA);
    rounds(&mut manager, &mut robots, 0..20);
    let (client, _) = clone_of_the_second(9, "yard");
    robots.push((client.on(floor(3.0)), stands_in("yard")));
    rounds(&mut manager, &mut robots, 20..25);
    assert!(robots[3].0.is_registered());
    robots.remove(1);
    robots[0].1.wanted = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 25..60);
    assert!(!robots[0].0.holds(AREA));
    let told = |alarm: &Alarm| matches!(alarm, Alarm::SilentSecond { areas, .. } if areas == AREA);
    assert!(manager.alarms().any(|alarm| told(&alarm)));
}

/// Found beside the robot, and switched off; then mediator and robot start again.
#[test]
fn one_that_was_refused_alone_and_found_then_is_no_former_process_of_the_robot_after_a_start() {
    let mut stored = Stored::new(1);
    let (mut manager, mut robots) = on_a_known_floor();
    let first = robots.remove(1);
    robots.push(one_with_another_floor(8, AREA));
    rounds(&mut manager, &mut robots, 0..10);
    robots.push(first);
    rounds(&mut manager, &mut robots, 10..40);
    robots.truncate(2);
    manager.entries().for_each(|entry| stored.apply(entry));
    let setup = Setup {
        floor: floor(3.0),
        ..setup()
    };
    let started_ns = NOW_NS + 40 * STEP_NS;
    let mut manager = Manager::new(&setup, &stored, started_ns).expect("valid");
    let (client, _) = clone_of_the_second(9, "yard");
    robots.push((client.on(floor(3.0)), stands_in("yard")));
    robots[0].1.wanted = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 40..120);
    assert!(robots[2].0.is_registered());
    assert!(!robots[0].0.holds(AREA));
}

/// It said where it stands as long as another one spoke for the robot, and then lost its pose.
#[test]
fn one_that_is_taken_in_without_a_pose_is_where_it_said_that_it_is() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots[2].1.wanted.clear();
    robots.push(clone_of_the_second(8, AREA));
    rounds(&mut manager, &mut robots, 0..3);
    robots[3].1 = Situation::default();
    robots.remove(1);
    rounds(&mut manager, &mut robots, 3..30);
    assert!(robots[2].0.is_registered());
    robots[0].1.wanted = vec![AREA.to_owned()];
    rounds(&mut manager, &mut robots, 30..50);
    assert!(!robots[0].0.holds(AREA));
}

/// It is pushed out of one area into another, and is one body.
#[test]
fn one_that_is_refused_alone_is_where_it_says_that_it_is() {
    let (mut manager, mut robots) = on_a_known_floor();
    robots[1] = one_with_another_floor(8, AREA);
    rounds(&mut manager, &mut robots, 0..10);
    robots[1].1 = stands_in("yard");
    robots[0].1.wanted = vec![AREA.to_owned()];
    robots[2].1.wanted = vec!["yard".to_owned()];
    rounds(&mut manager, &mut robots, 10..30);
    assert!(robots[0].0.holds(AREA) && !robots[2].0.holds("yard"));
    let status = manager.status(NOW_NS + 30 * STEP_NS);
    assert_eq!(status.robots[1].second_in, ["yard"]);
}

/// The floor's file is another one since it was taken in, by this mediator or the one before.
#[test]
fn one_that_was_taken_in_and_is_refused_then_is_in_the_way() {
    for restarts in [false, true] {
        let mut stored = Stored::new(1);
        let (mut manager, mut robots) = on_a_known_floor();
        manager.entries().for_each(|entry| stored.apply(entry));
        if restarts {
            let setup = Setup {
                floor: floor(3.0),
                ..setup()
            };
            manager = Manager::new(&setup, &stored, NOW_NS).expect("valid");
        }
        let (client, _) = robots.remove(1);
        robots.push((client.on(floor(4.0)), stands_in(AREA)));
        rounds(&mut manager, &mut robots, 1..20);
        robots[0].1.wanted = vec![AREA.to_owned()];
        rounds(&mut manager, &mut robots, 20..40);
        assert!(!robots[0].0.holds(AREA), "{restarts}");
        robots.pop();
        rounds(&mut manager, &mut robots, 40..80);
        assert!(!robots[0].0.holds(AREA), "{restarts}");
        let absent = manager.absent("amr-2", false, NOW_NS + 80 * STEP_NS);
        assert!(
            matches!(absent, Err(AbsentError::Inside { .. })),
            "{absent:?}"
        );
    }
}

/// Its grant is of the mediator before. Somebody stands in the area now, and somebody else is switched off.
#[test]
fn a_grant_that_was_not_used_is_taken_back_also_while_somebody_is_awaited() {
    for (who, first) in [(1, true), (1, false), (3, true)] {
        let mut stored = Stored::new(1);
        let (mut manager, mut robots) = asked_for();
        robots[2].1.wanted.clear();
        rounds(&mut manager, &mut robots, 0..5);
        assert!(robots[0].0.holds(AREA));
        manager.entries().for_each(|entry| stored.apply(entry));
        robots.pop();
        if who == 3 {
            robots.push(clone_of_the_second(8, AREA));
        } else {
            robots[1].1 = stands_in(AREA);
        }
        if first {
            let last = robots.len() - 1;
            robots.rotate_right(last);
        }
        let mut manager = start(&stored, 51, NOW_NS + 5 * STEP_NS);
        rounds(&mut manager, &mut robots, 5..20);
        let status = manager.status(NOW_NS + 20 * STEP_NS);
        assert_eq!(status.awaited, ["amr-3"]);
        assert!(
            manager.counters().revocations > 0,
            "{who} {first}: {status:?}"
        );
        let own = robots.iter().find(|(client, _)| client.holds(AREA));
        assert!(own.is_none(), "{who} {first}: {status:?}");
    }
}

/// It understands nothing that it is told, and so repeats nothing.
#[test]
fn one_that_is_refused_for_its_version_is_found_as_well() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots[2].1.wanted.clear();
    let (mut clone, situation) = clone_of_the_second(8, AREA);
    for round in 0..30 {
        let now_ns = NOW_NS + round * STEP_NS;
        clone.step(situation.clone(), now_ns, SILENT_AFTER_NS);
        let mut report = clone.report();
        report.version = Some(wire::Version {
            major: VERSION.major + 1,
            minor: 0,
        });
        manager.report(&report, now_ns);
        talk(&mut manager, &mut robots, now_ns);
    }
    let doubled = manager
        .alarms()
        .any(|alarm| matches!(alarm, Alarm::Doubled { .. }));
    assert!(doubled);
    robots[0].1.wanted = vec![AREA.to_owned()];
    for round in 30..50 {
        let status = talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(!robots[0].0.holds(AREA), "{round}: {status:?}");
    }
}

/// Each start of a computer that stands somewhere is another process.
#[test]
fn one_that_was_switched_on_more_often_than_processes_are_told_apart_is_in_the_way() {
    let (mut manager, mut robots) = asked_for();
    robots[0].1.wanted.clear();
    robots[2].1.wanted.clear();
    let mut round = 0;
    let mut pass = |manager: &mut Manager, robots: &mut Robots, rounds| {
        for _ in 0..rounds {
            round += 1;
            talk(manager, robots, NOW_NS + round * STEP_NS);
        }
    };
    for boot_epoch in 11..=19 {
        let area = if boot_epoch < 19 { AREA } else { "yard" };
        robots.push(clone_of_the_second(boot_epoch, area));
        pass(&mut manager, &mut robots, 30);
        robots.pop();
    }
    let doubled = { manager.alarms() }.filter(|alarm| matches!(alarm, Alarm::Doubled { .. }));
    assert_eq!(doubled.count(), 9);
    robots[2].1.wanted = vec!["yard".to_owned()];
    pass(&mut manager, &mut robots, 20);
    assert!(!robots[2].0.holds("yard"));
    let silent = manager
        .alarms()
        .any(|alarm| matches!(&alarm, Alarm::SilentSecond { areas, .. } if areas == "yard"));
    assert!(silent);
}

/// The mediator that has started is not followed by one that it refuses, for a second.
#[test]
fn one_that_was_found_before_the_mediator_started_is_in_the_way() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots: Robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[])).into();
    talk(&mut manager, &mut robots, NOW_NS);
    robots.insert(0, clone_of_the_second(8, AREA));
    for round in 0..30 {
        talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
    }
    manager.entries().for_each(|entry| stored.apply(entry));
    let mut manager = start(&stored, 51, NOW_NS + 30 * STEP_NS);
    robots[1].1.wanted = vec![AREA.to_owned()];
    for round in 30..80 {
        let status = talk(&mut manager, &mut robots, NOW_NS + round * STEP_NS);
        assert!(
            status.awaited.is_empty() && !robots[1].0.holds(AREA),
            "{round}: {status:?}"
        );
    }
}
