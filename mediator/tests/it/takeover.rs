//! A mediator that does not know what robots have been granted.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use contract::client::{Client, Received, Situation};
use contract::floor::{Floor, FloorArea};
use contract::timing::{ENTERS_NO_MORE_NS, LISTENS_FIRST_NS, SILENT_AFTER_NS};
use contract::wire::MediatorReport;
use mediator::journal::{ClosedRecord, Entry, Stored};
use mediator::manager::{
    AbsentError, Alarm, ClearError, Cleared, Manager, RestoreError, StandsBy, Status,
};
use mediator::setup::{AreaSetup, RobotSetup, Setup};

pub const AREA: &str = "gate";
/// Long after managers have started, at 0: no robot may still enter what an earlier one has granted.
pub const NOW_NS: u64 = 10_000_000_000;

/// Two areas for one each, and three robots that start beside them.
pub fn setup() -> Setup {
    let robot = |id: &str| RobotSetup {
        id: id.to_owned(),
        role: "normal".to_owned(),
        priority: 0,
        ages_after: 0,
        starts_in: Vec::new(),
    };
    let areas = [AREA, "yard"].map(|id| AreaSetup {
        id: id.to_owned(),
        capacity: 1,
    });
    Setup {
        site: "hall".to_owned(),
        areas: areas.to_vec(),
        robots: ["amr-1", "amr-2", "amr-3"].map(robot).to_vec(),
        floor: Floor::default(),
        silent_after: Duration::from_nanos(SILENT_AFTER_NS),
    }
}

pub fn start(stored: &Stored, instance: u64, now_ns: u64) -> Manager {
    let manager = Manager::new(&setup(), stored, now_ns).expect("valid");
    manager.speaks_as(instance)
}

/// The area was cleared of this one, and is free.
pub fn cleared_of(body: &str) -> Result<Cleared, ClearError> {
    let of = vec![body.to_owned()];
    Ok(Cleared {
        of,
        ..Cleared::default()
    })
}

fn keep(manager: &mut Manager, stored: &mut Stored) {
    manager.entries().for_each(|entry| stored.apply(entry));
}

pub fn robot(id: &str, wanted: &[&str]) -> (Client, Situation) {
    // Not its first boot, for any journal that knows it.
    let client = Client::new(id, "hall", 7);
    let situation = Situation {
        located: true,
        wanted: wanted.iter().map(|&area| area.to_owned()).collect(),
        ..Situation::default()
    };
    (client, situation)
}

/// All robots and the mediator talk for some rounds.
pub fn talk(manager: &mut Manager, robots: &mut [(Client, Situation)], now_ns: u64) -> Status {
    for _ in 0..4 {
        for (client, situation) in robots.iter_mut() {
            client.step(situation.clone(), now_ns, SILENT_AFTER_NS);
            manager.report(&client.report(), now_ns);
        }
        manager.tick(now_ns);
        while let Some(message) = manager.next_message(now_ns) {
            for (client, _) in robots.iter_mut() {
                client.receive(&message, now_ns);
            }
        }
    }
    manager.status(now_ns)
}

#[test]
fn after_a_first_start_every_robot_is_awaited_or_said_to_be_absent() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[AREA])];
    assert_eq!(talk(&mut manager, &mut robots, NOW_NS).awaited.len(), 2);
    assert!(!robots[0].0.holds(AREA));
    keep(&mut manager, &mut stored);

    // A restart changes nothing of that.
    let mut manager = start(&stored, 51, 0);
    robots.push(robot("amr-2", &[]));
    assert_eq!(talk(&mut manager, &mut robots, NOW_NS).awaited, ["amr-3"]);
    assert!(!robots[0].0.holds(AREA));
    let heard = AbsentError::Heard("amr-1".to_owned());
    assert_eq!(manager.absent("amr-1", false, NOW_NS), Err(heard));
    assert!(matches!(
        manager.absent("amr-9", false, NOW_NS),
        Err(AbsentError::Unknown(_))
    ));
    assert_eq!(manager.absent("amr-3", false, NOW_NS), Ok(Vec::new()));
    assert!(talk(&mut manager, &mut robots, NOW_NS).awaited.is_empty());
    assert!(robots[0].0.holds(AREA));
    keep(&mut manager, &mut stored);

    // Once said, it holds until that robot is heard: for that it has the time that a grant could last which the journal has lost.
    let mut manager = start(&stored, 52, NOW_NS);
    let over_ns = NOW_NS + ENTERS_NO_MORE_NS;
    let before = talk(&mut manager, &mut robots, over_ns - 1);
    assert_eq!(before.awaited, ["amr-3"]);
    assert!(talk(&mut manager, &mut robots, over_ns).awaited.is_empty());
    robots.push(robot("amr-3", &[]));
    assert!(talk(&mut manager, &mut robots, over_ns).awaited.is_empty());
    keep(&mut manager, &mut stored);
    let mut manager = start(&stored, 53, 0);
    manager.tick(NOW_NS);
    assert_eq!(manager.status(NOW_NS).awaited.len(), 3);
}

/// They talk on, so long that whoever was to be asked anew was.
pub fn talks_on(manager: &mut Manager, robots: &mut [(Client, Situation)], now_ns: &mut u64) {
    for _ in 0..14 {
        *now_ns += SILENT_AFTER_NS / 2;
        talk(manager, robots, *now_ns);
    }
}

/// A robot is granted the area, and gives it back when that is closed.
pub fn gives_back_what_is_closed(
    manager: &mut Manager,
    robots: &mut [(Client, Situation)],
    number: usize,
    now_ns: u64,
    what: &str,
) {
    robots[number].1.wanted = vec![AREA.to_owned()];
    talk(manager, robots, now_ns);
    assert!(robots[number].0.holds(AREA), "{what}");
    let by = ClosedRecord::default();
    manager.close(AREA, by, now_ns).expect("a known area");
    let status = talk(manager, robots, now_ns);
    let area = &status.areas[0];
    assert!(area.holders.is_empty(), "{what}: {area:?}");
    manager.open(AREA, now_ns).expect("a known area");
}

/// A journal of before the first robot came back, of which it was said that it is absent; its mediator, and the others.
fn without_the_first() -> (Stored, Manager, Vec<(Client, Situation)>) {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-2", &[]), robot("amr-3", &[])];
    talk(&mut manager, &mut robots, NOW_NS);
    assert_eq!(manager.absent("amr-1", false, NOW_NS), Ok(Vec::new()));
    keep(&mut manager, &mut stored);
    (stored, manager, robots)
}

/// That it came back, and was granted the gate, was one write.
#[test]
fn a_robot_that_was_absent_in_an_older_journal_is_awaited() {
    let (stored, mut manager, mut robots) = without_the_first();
    robots.push(robot("amr-1", &[AREA]));
    talk(&mut manager, &mut robots, NOW_NS);
    assert!(robots[2].0.holds(AREA));

    let started_ns = NOW_NS + 1;
    let mut manager = start(&stored, 51, started_ns);
    robots[0].1.wanted = vec![AREA.to_owned()];
    // Those that are heard first, and the one that has the gate by its lease only when its link is back.
    for second in 0..4 {
        let now_ns = started_ns + second * SILENT_AFTER_NS;
        talk(&mut manager, &mut robots[..2], now_ns);
        assert!(!robots[0].0.holds(AREA), "{second}");
    }
    let mut status = talk(&mut manager, &mut robots, started_ns + 4 * SILENT_AFTER_NS);
    // The journal does not know its process, and what one before it may have been granted.
    assert_eq!(status.awaited, ["amr-1"]);
    for second in 5..8 {
        let now_ns = started_ns + second * SILENT_AFTER_NS;
        status = talk(&mut manager, &mut robots, now_ns);
        assert!(!robots[0].0.holds(AREA));
    }
    assert_eq!(status.areas[0].holders, [("amr-1".to_owned(), 1)]);
    assert!(status.awaited.is_empty());
}

/// Its journal has lost that it came back as another process, which has lost its pose since, and then its link.
#[test]
fn a_robot_that_was_absent_and_is_heard_without_a_place_is_awaited_also_when_it_is_silent() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-2", &[]), robot("amr-3", &[])];
    robots.push(robot("amr-1", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    robots.pop();
    let absent_ns = NOW_NS + ENTERS_NO_MORE_NS;
    talk(&mut manager, &mut robots, absent_ns);
    assert_eq!(manager.absent("amr-1", false, absent_ns), Ok(Vec::new()));
    keep(&mut manager, &mut stored);

    robots[0].1.wanted = vec![AREA.to_owned()];
    // What it says as a robot of another site says nothing of this floor.
    for heard_at in [Some("hall"), Some("next door"), None] {
        let is_heard = heard_at == Some("hall");
        let mut robots = robots.clone();
        let mut manager = start(&stored, 51, absent_ns);
        let since = |second: u64| absent_ns + second * SILENT_AFTER_NS;
        if let Some(site) = heard_at {
            let mut back = [(Client::new("amr-1", site, 8), Situation::default())];
            talk(&mut manager, &mut back, since(1));
        }
        let mut status = manager.status(since(1));
        for second in 1..8 {
            status = talk(&mut manager, &mut robots, since(second));
        }
        let told = Alarm::NotAwaited {
            robot: "amr-1".to_owned(),
        };
        let alarms: Vec<Alarm> = manager.alarms().collect();
        assert_eq!(alarms.contains(&told), !is_heard, "{alarms:?}");
        assert_eq!(status.awaited.is_empty(), !is_heard, "{status:?}");
        assert_eq!(robots[0].0.holds(AREA), !is_heard);
        if is_heard {
            let said = manager.absent("amr-1", false, since(8));
            assert_eq!(said, Ok(Vec::new()));
            talk(&mut manager, &mut robots, since(8));
            assert!(robots[0].0.holds(AREA));
        }
    }
}

/// Its journal has lost what somebody was granted a moment ago; and one that stands by does not know.
#[test]
fn nobody_says_that_a_robot_is_absent_which_may_enter_by_what_this_mediator_does_not_know() {
    let mut manager = start(&Stored::new(1), 51, NOW_NS);
    let early = manager.absent("amr-1", false, NOW_NS + 1);
    assert!(
        matches!(early, Err(AbsentError::MayEnter { .. })),
        "{early:?}"
    );
    let now_ns = NOW_NS + ENTERS_NO_MORE_NS;
    assert_eq!(manager.absent("amr-1", false, now_ns), Ok(Vec::new()));

    let mut robots = running();
    let mut spare = start(&Stored::new(2), 60, NOW_NS);
    talk(&mut spare, &mut robots, NOW_NS);
    assert!(spare.stands_by());
    let said = spare.absent("amr-1", true, now_ns);
    assert_eq!(said, Err(StandsBy.into()));
    assert_eq!(spare.clear(AREA, true, now_ns), Err(StandsBy.into()));
}

/// It would answer that nobody is let in, while the other one lets robots in.
#[test]
fn one_that_stands_by_closes_and_opens_nothing_and_ends_nothing() {
    let mut robots = running();
    let mut spare = start(&Stored::new(2), 60, NOW_NS);
    talk(&mut spare, &mut robots, NOW_NS);
    assert!(spare.stands_by());
    let closed = spare.close(AREA, ClosedRecord::default(), NOW_NS);
    assert_eq!(closed, Err(StandsBy.into()));
    assert_eq!(spare.open(AREA, NOW_NS), Err(StandsBy.into()));
    assert_eq!(spare.end("overtaking", NOW_NS), Err(StandsBy.into()));
    assert!(!spare.status(NOW_NS).areas[0].closed);
}

/// One robot has the gate, and one has been there; journal 1, at its third start.
fn running() -> Vec<(Client, Situation)> {
    let mut stored = Stored::new(1);
    stored.epoch = 2;
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[AREA])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    assert!(robots[1].0.holds(AREA));
    robots
}

#[test]
fn robots_follow_a_mediator_without_their_journal_and_keep_what_they_have() {
    let mut robots = running();
    let mut stored = Stored::new(2);
    let mut manager = start(&stored, 60, NOW_NS);
    robots[0].1.wanted = vec![AREA.to_owned()];
    // For a second it may be that the other one lives.
    let status = talk(&mut manager, &mut robots, NOW_NS + SILENT_AFTER_NS / 2);
    assert!(status.stands_by && status.epoch == 1);
    let now_ns = NOW_NS + 2 * SILENT_AFTER_NS;
    let absent = robots.pop().expect("the third one");
    let status = talk(&mut manager, &mut robots, now_ns);
    // Of processes that it has not known before it cannot know what those before them were granted.
    assert_eq!((status.epoch, status.awaited.len()), (4, 3));
    let now_ns = now_ns + ENTERS_NO_MORE_NS;
    let status = talk(&mut manager, &mut robots, now_ns);
    assert_eq!((status.epoch, status.stands_by), (4, false));
    let followed = robots
        .iter()
        .all(|(client, _)| client.mediator_epoch() == 4);
    assert!(followed && status.awaited == ["amr-3"], "{status:?}");
    assert_eq!(status.areas[0].holders[0].0, "amr-2");
    let told: Vec<Alarm> = manager.alarms().collect();
    let warned = { told.iter() }.find(|own| matches!(own, Alarm::OlderJournal { found: 3, .. }));
    let text = warned.expect("people are told").to_string();
    assert!(says_what_is_open(&text), "{text}");
    let taken_over = Alarm::TakenOver {
        robot: "amr-2".to_owned(),
        area: AREA.to_owned(),
    };
    // The journal has lost nothing.
    let adopted = { told.iter() }.any(|own| matches!(own, Alarm::Adopted { .. }));
    assert!(told.contains(&taken_over) && !adopted, "{told:?}");
    // It stays with whom it has, also when nobody is awaited any more.
    robots.push(absent);
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(
        status.awaited.is_empty() && !robots[0].0.holds(AREA),
        "{status:?}"
    );
    robots[1].1.wanted.clear();
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[0].0.holds(AREA) && !robots[1].0.holds(AREA));
    // The larger number is in the journal.
    keep(&mut manager, &mut stored);
    assert_eq!(start(&stored, 61, 0).epoch(), 5);
}

/// It names both kinds of areas that the other one kept closed.
fn says_what_is_open(text: &str) -> bool {
    text.contains("people have closed") && text.contains("a second process of a robot")
}

/// The other one lives, and does not hear the robot: an operator has it clear the gate, and it lets in one of those that it hears.
#[test]
fn nobody_has_a_lease_before_all_robots_follow_the_mediator_that_takes_over() {
    let mut robots = running();
    let mut manager = start(&Stored::new(2), 60, NOW_NS);
    let others = [robots.remove(0), robots.remove(1)];
    let mut now_ns = NOW_NS + 2 * SILENT_AFTER_NS;
    talk(&mut manager, &mut robots, now_ns);
    now_ns += ENTERS_NO_MORE_NS;
    let status = talk(&mut manager, &mut robots, now_ns);
    assert_eq!(status.areas[0].holders, [("amr-2".to_owned(), 1)]);
    assert!(robots[0].0.holds(AREA) && !robots[0].0.may_be_in(AREA, now_ns));
    robots.extend(others);
    for (heard, all) in [(2, false), (3, true)] {
        talk(&mut manager, &mut robots[..heard], now_ns);
        now_ns += ENTERS_NO_MORE_NS;
        let status = talk(&mut manager, &mut robots[..heard], now_ns);
        assert_eq!(status.awaited.is_empty(), all, "{status:?}");
        assert_eq!(robots[0].0.may_be_in(AREA, now_ns), all);
    }
}

/// Another mediator may have led them meanwhile, and lead those that are not heard still.
#[test]
fn nobody_has_a_lease_after_a_start_before_all_robots_are_heard() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[]));
    robots[0].1.wanted = vec![AREA.to_owned()];
    talk(&mut manager, &mut robots, NOW_NS);
    let listened_ns = NOW_NS + LISTENS_FIRST_NS;
    talk(&mut manager, &mut robots, listened_ns);
    assert!(robots[0].0.may_be_in(AREA, listened_ns));
    keep(&mut manager, &mut stored);
    let now_ns = listened_ns + 2 * SILENT_AFTER_NS;
    let mut manager = start(&stored, 51, now_ns);
    talk(&mut manager, &mut robots[..2], now_ns);
    assert!(robots[0].0.holds(AREA) && !robots[0].0.may_be_in(AREA, now_ns));
    let why = manager.why("amr-1", now_ns).expect("a robot of the site");
    assert!(
        why.contains("enters nothing") && why.contains("amr-3"),
        "{why}"
    );
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(status.awaited.is_empty(), "{status:?}");
    assert!(robots[0].0.may_be_in(AREA, now_ns));
}

/// It came back to the other one, and is out of reach of this one since.
#[test]
fn absence_that_was_said_before_another_mediator_led_says_nothing() {
    let mut first = start(&Stored::new(1), 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    talk(&mut first, &mut robots, NOW_NS);
    assert_eq!(first.absent("amr-3", false, NOW_NS), Ok(Vec::new()));
    assert!(talk(&mut first, &mut robots, NOW_NS).awaited.is_empty());

    robots.push(robot("amr-3", &[AREA]));
    let mut now_ns = NOW_NS + 2 * SILENT_AFTER_NS;
    let mut second = start(&Stored::new(2), 60, NOW_NS);
    talk(&mut second, &mut robots, now_ns);
    now_ns += ENTERS_NO_MORE_NS;
    talk(&mut second, &mut robots, now_ns);
    assert!(robots[2].0.may_be_in(AREA, now_ns));

    robots.pop();
    robots[0].1.wanted = vec![AREA.to_owned()];
    assert!(talk(&mut first, &mut robots, now_ns).stands_by);
    for _ in 0..4 {
        now_ns += 2 * SILENT_AFTER_NS;
        talk(&mut first, &mut robots, now_ns);
    }
    let status = first.status(now_ns);
    assert!(
        !status.stands_by && status.awaited == ["amr-3"],
        "{status:?}"
    );
    assert!(!robots[0].0.holds(AREA));
}

/// Robots would not follow it, and nobody would know why.
#[test]
fn a_journal_without_a_number_is_refused() {
    let nameless = Manager::new(&setup(), &Stored::new(0), 0);
    assert!(matches!(nameless, Err(RestoreError::Nameless)));
}

#[test]
fn a_mediator_that_has_stood_by_asks_everybody_before_it_goes_on() {
    let mut robots = running();
    // The first mediator's own journal, of long ago.
    let mut stored = Stored {
        epoch: 20,
        ..Stored::new(3)
    };
    let mut manager = start(&stored, 60, NOW_NS);
    assert!(talk(&mut manager, &mut robots, NOW_NS).stands_by);
    let now_ns = NOW_NS + 2 * SILENT_AFTER_NS;
    robots[0].1.wanted = vec![AREA.to_owned()];
    let second = robots.remove(1);
    talk(&mut manager, &mut robots, now_ns);
    let now_ns = now_ns + ENTERS_NO_MORE_NS;
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(
        !status.stands_by && status.awaited == ["amr-2"],
        "{status:?}"
    );
    let mut told = manager
        .alarms()
        .filter(|own| matches!(own, Alarm::GoesOn { .. }));
    let text = told.next().expect("people are told").to_string();
    assert!(says_what_is_open(&text), "{text}");
    drop(told);
    assert!(!robots[0].0.holds(AREA));
    keep(&mut manager, &mut stored);
    assert!(stored.robots["amr-2"].unaccounted);
    robots.push(second);
    assert!(talk(&mut manager, &mut robots, now_ns).awaited.is_empty());
    assert!(!robots[0].0.holds(AREA) && robots[2].0.holds(AREA));
}

#[test]
fn what_a_spare_mediator_has_granted_holds_when_the_first_one_is_back() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[AREA])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    assert!(robots[1].0.holds(AREA));
    // It is carried away, so the next run with it begins after one that was given up.
    let mut now_ns = NOW_NS + ENTERS_NO_MORE_NS;
    manager.tick(now_ns);
    assert_eq!(manager.clear(AREA, false, now_ns), cleared_of("amr-2"));
    keep(&mut manager, &mut stored);

    // All have restarted since, and count their runs from 0.
    for (client, _) in &mut robots {
        *client = Client::new(&client.report().robot_id, "hall", 8);
    }
    talk(&mut start(&Stored::new(2), 60, NOW_NS), &mut robots, now_ns);
    assert!(robots[1].0.holds(AREA));
    robots[0].1.wanted = vec![AREA.to_owned()];
    let mut manager = start(&stored, 51, now_ns);
    now_ns += 2 * SILENT_AFTER_NS;
    talk(&mut manager, &mut robots, now_ns);
    now_ns += ENTERS_NO_MORE_NS;
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(status.awaited.is_empty(), "{status:?}");
    assert_eq!(status.areas[0].holders[0].0, "amr-2");
    assert!(robots[1].0.holds(AREA) && !robots[0].0.holds(AREA));
    assert!(robots.iter().all(|(client, _)| client.mediator_epoch() > 2));
    // What it gives back counts too.
    robots[1].1.wanted.clear();
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[0].0.holds(AREA));
}

#[test]
fn a_robot_that_does_not_know_where_it_is_has_not_said_where_it_stands() {
    let mut manager = start(&Stored::new(1), 50, 0);
    let mut robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[AREA]));
    robots[0].1.located = false;
    assert_eq!(talk(&mut manager, &mut robots, NOW_NS).awaited, ["amr-1"]);
    robots[0].1.located = true;
    assert!(talk(&mut manager, &mut robots, NOW_NS).awaited.is_empty());
}

#[test]
fn a_process_that_does_not_speak_for_its_robot_yet_counts_with_where_it_stands() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    assert_eq!(manager.absent("amr-3", false, NOW_NS), Ok(Vec::new()));
    talk(&mut manager, &mut robots, NOW_NS);
    keep(&mut manager, &mut stored);
    let mut manager = start(&stored, 51, 0);
    let (mut client, mut situation) = robot("amr-3", &[]);
    situation.stands_in = vec![AREA.to_owned()];
    client.step(situation, NOW_NS, SILENT_AFTER_NS);
    manager.report(&client.report(), NOW_NS);
    robots[0].1.wanted = vec![AREA.to_owned()];
    let status = talk(&mut manager, &mut robots, NOW_NS);
    assert!(status.awaited == ["amr-3"] && !robots[0].0.holds(AREA));
    assert_eq!(status.areas[0].standing, ["amr-3"]);
    let heard = ClearError::Heard {
        area: AREA.to_owned(),
        robot: "amr-3".to_owned(),
    };
    assert_eq!(manager.clear(AREA, false, NOW_NS), Err(heard));
    // It is heard no more, and is somewhere all the same, until an operator says again that it is not.
    let now_ns = NOW_NS + ENTERS_NO_MORE_NS;
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(status.awaited == ["amr-3"] && !robots[0].0.holds(AREA));
    assert_eq!(
        manager.absent("amr-3", true, now_ns),
        Ok(vec![AREA.to_owned()])
    );
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[0].0.holds(AREA));
}

#[test]
fn a_number_that_no_mediator_can_have_reached_is_no_epoch() {
    let mut manager = start(&Stored::new(2), 60, 0);
    let (mut client, situation) = robot("amr-1", &[]);
    client.step(situation, NOW_NS, SILENT_AFTER_NS);
    let mut report = client.report();
    (report.mediator_instance, report.mediator_epoch) = (9, u64::MAX);
    for sequence in 1..9 {
        report.sequence = sequence;
        manager.report(&report, NOW_NS);
    }
    // It has another mediator, and is asked once.
    assert_eq!(manager.epoch(), 2);
}

#[test]
fn a_robot_that_was_told_made_up_numbers_in_its_name_hears_it_again() {
    const LATER_NS: u64 = NOW_NS + PERIOD_NS;
    const PERIOD_NS: u64 = 300_000_000;
    let mut manager = start(&Stored::new(1), 60, 0);
    let mut robots = vec![robot("amr-1", &[AREA]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    assert!(robots[0].0.holds(AREA));
    let now = robots[0].1.clone();
    robots[0].0.step(now, LATER_NS, SILENT_AFTER_NS);
    manager.report(&robots[0].0.report(), LATER_NS);
    manager.tick(LATER_NS);
    let heard =
        std::iter::from_fn(|| manager.next_message(LATER_NS)).find(|own| own.robot_id == "amr-1");
    let heard = heard.expect("it is told");
    let made_up = |epoch: u64, sequence: u64| MediatorReport {
        mediator_epoch: epoch,
        sequence,
        ..heard.clone()
    };
    let mut hears = |forged: MediatorReport, later_ns: u64| {
        let now_ns = LATER_NS + later_ns;
        assert_eq!(robots[0].0.receive(&forged, now_ns), Received::News);
        let status = talk(&mut manager, &mut robots, now_ns);
        assert!(status.awaited.is_empty() && robots[0].0.is_registered());
        assert!(!robots[0].0.is_mediator_silent(now_ns, SILENT_AFTER_NS));
        let before = robots[0].0.report().mediator_sequence;
        talk(&mut manager, &mut robots, now_ns + PERIOD_NS);
        assert!(
            robots[0].0.report().mediator_sequence > before,
            "it hears on"
        );
        manager.epoch()
    };
    assert_eq!(hears(made_up(1, 1 << 40), 0), 1);
    assert_eq!(hears(made_up(1000, 7), 2 * PERIOD_NS), 1001);
    // After these it would take no more messages of that epoch.
    const ASKS_AGAIN_NS: u64 = 3_000_000_000;
    for (number, sequence) in (1..).zip([(1 << 62) - 1, 1 << 62]) {
        let forged = made_up(1000 + number, sequence);
        assert_eq!(hears(forged, number * ASKS_AGAIN_NS), 1001 + number);
    }
    assert!(
        manager
            .alarms()
            .any(|alarm| matches!(alarm, Alarm::OlderJournal { .. }))
    );
}

/// Somebody revokes the third robot's certificate, and sees to it: the first one has what it wants.
fn is_seen_to(manager: &mut Manager, robots: &mut [(Client, Situation)], now_ns: u64) {
    let now_ns = now_ns + ENTERS_NO_MORE_NS;
    talk(manager, robots, now_ns);
    assert_eq!(manager.absent("amr-3", false, now_ns), Ok(Vec::new()));
    talk(manager, robots, now_ns);
    assert!(robots[0].0.holds(AREA));
}

/// It says that it has heard this mediator with an epoch that its followers would not believe, and goes on saying so.
#[test]
fn one_robot_that_makes_up_epochs_of_this_mediator_mutes_nobody() {
    const REACHED: u64 = 1 << 21;
    for made_up in [REACHED, (1 << 62) - 2, (1 << 62) - 1] {
        let mut stored = Stored::new(1);
        let mut manager = start(&stored, 60, 0);
        let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
        robots.push(robot("amr-3", &[]));
        talk(&mut manager, &mut robots, NOW_NS);
        let (mut liar, situation) = robots.pop().expect("the third one");
        robots[0].1.wanted = vec![AREA.to_owned()];
        let mut now_ns = NOW_NS;
        for _ in 0..20 {
            now_ns += SILENT_AFTER_NS / 5;
            liar.step(situation.clone(), now_ns, SILENT_AFTER_NS);
            let mut lie = liar.report();
            assert_eq!(lie.mediator_instance, 60);
            lie.mediator_epoch = made_up;
            manager.report(&lie, now_ns);
            let status = talk(&mut manager, &mut robots, now_ns);
            assert_eq!(
                status.awaited,
                ["amr-3"],
                "it may have been granted anything"
            );
            let heard = { robots.iter() }.all(|(client, _)| {
                client.is_registered() && !client.is_mediator_silent(now_ns, SILENT_AFTER_NS)
            });
            assert!(heard, "{made_up}: {status:?}");
        }
        assert_eq!(manager.epoch(), 2, "all were asked once");
        let told = { manager.alarms() }.filter(
            |alarm| matches!(alarm, Alarm::OlderJournal { found, .. } if *found == made_up),
        );
        assert_eq!(told.count(), 1);
        keep(&mut manager, &mut stored);
        assert_eq!(start(&stored, 61, now_ns).epoch(), 3);
        is_seen_to(&mut manager, &mut robots, now_ns);
    }
}

/// Whatever it makes up, by steps or at once: who was out of reach meanwhile follows this mediator all the same.
#[test]
fn epochs_that_are_made_up_step_by_step_do_not_outrun_robots_that_are_out_of_reach() {
    let mut manager = start(&Stored::new(1), 60, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    let away = robots.remove(0);
    let mut now_ns = NOW_NS;
    for _ in 0..10 {
        now_ns += 3 * SILENT_AFTER_NS;
        let (liar, situation) = &mut robots[1];
        liar.step(situation.clone(), now_ns, SILENT_AFTER_NS);
        let mut lie = liar.report();
        lie.mediator_epoch = manager.epoch() + (1 << 19);
        manager.report(&lie, now_ns);
        talk(&mut manager, &mut robots, now_ns);
    }
    robots.push(away);
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[2].0.is_registered());
    assert_eq!(robots[2].0.mediator_epoch(), manager.epoch());
}

#[test]
fn a_robot_that_is_said_to_be_absent_asks_for_nothing_any_more() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[AREA]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    robots[1].1.wanted = vec![AREA.to_owned()];
    assert_eq!(
        talk(&mut manager, &mut robots, NOW_NS).areas[0]
            .waiting
            .len(),
        1
    );
    let second = robots.remove(1);
    let now_ns = NOW_NS + ENTERS_NO_MORE_NS;
    talk(&mut manager, &mut robots, now_ns);
    assert_eq!(manager.absent("amr-2", false, now_ns), Ok(Vec::new()));
    assert!(manager.status(now_ns).areas[0].waiting.is_empty());
    keep(&mut manager, &mut stored);
    assert!(
        start(&stored, 51, now_ns).status(now_ns).areas[0]
            .waiting
            .is_empty()
    );
    // It comes back, asks anew, and has its turn.
    robots.push(second);
    let status = talk(&mut manager, &mut robots, now_ns);
    assert_eq!(status.areas[0].waiting.len(), 1, "{status:?}");
    robots[0].1.wanted.clear();
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[2].0.holds(AREA));
    let alarms: Vec<String> = manager.alarms().map(|alarm| alarm.to_string()).collect();
    assert!(
        !alarms.iter().any(|text| text.contains("ignored")),
        "{alarms:?}"
    );
}

#[test]
fn clearing_an_area_says_nothing_of_a_robot_that_may_be_anywhere() {
    let mut setup = setup();
    setup.robots[2].starts_in = vec!["yard".to_owned()];
    let mut manager = Manager::new(&setup, &Stored::new(1), 0).expect("valid");
    assert_eq!(manager.clear("yard", true, NOW_NS), cleared_of("amr-3"));
    assert!(manager.status(NOW_NS).awaited.contains(&"amr-3".to_owned()));
}

#[test]
fn a_robot_that_stood_in_an_area_is_cleared_only_when_it_was_taken_away() {
    let mut manager = start(&Stored::new(1), 50, 0);
    let mut robots = vec![robot("amr-1", &[AREA]), robot("amr-2", &["yard"])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    robots[0].1.stands_in = vec![AREA.to_owned()];
    talk(&mut manager, &mut robots, NOW_NS);
    // Both fall silent: one inside, one with a grant that it may still use.
    let heard = |manager: &mut Manager, now_ns| {
        manager.tick(now_ns);
        manager.clear(AREA, true, now_ns)
    };
    let still = NOW_NS + SILENT_AFTER_NS / 2;
    assert!(matches!(
        heard(&mut manager, still),
        Err(ClearError::Heard { .. })
    ));
    let later_ns = NOW_NS + 2 * SILENT_AFTER_NS;
    manager.tick(later_ns);
    let wait = Duration::from_nanos(NOW_NS + ENTERS_NO_MORE_NS - later_ns);
    for (area, id) in [(AREA, "amr-1"), ("yard", "amr-2")] {
        let may_enter = ClearError::MayEnter {
            area: area.to_owned(),
            robot: id.to_owned(),
            wait,
        };
        assert!(
            may_enter.to_string().contains("may still enter it for 3 s"),
            "{may_enter}"
        );
        assert_eq!(manager.clear(area, true, later_ns), Err(may_enter));
    }
    let now_ns = NOW_NS + ENTERS_NO_MORE_NS;
    let inside = ClearError::Inside {
        area: AREA.to_owned(),
        robot: "amr-1".to_owned(),
    };
    assert_eq!(manager.clear(AREA, false, now_ns), Err(inside));
    assert_eq!(manager.clear(AREA, true, now_ns), cleared_of("amr-1"));
    assert_eq!(manager.clear("yard", false, now_ns), cleared_of("amr-2"));
    let status = manager.status(now_ns);
    assert!(
        { status.areas.iter() }.all(|own| own.holders.is_empty() && own.standing.is_empty()),
        "{status:?}"
    );
}

#[test]
fn one_robot_that_lies_about_whom_it_follows_keeps_nobody_else_out() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    keep(&mut manager, &mut stored);
    let mut manager = start(&stored, 51, NOW_NS);
    let (mut liar, situation) = robots.pop().expect("the third one");
    robots[0].1.wanted = vec![AREA.to_owned()];
    let mut now_ns = NOW_NS;
    let epoch = manager.epoch();
    // It says so before anybody else is heard, and goes on saying so.
    for _ in 0..20 {
        now_ns += SILENT_AFTER_NS / 5;
        liar.step(situation.clone(), now_ns, SILENT_AFTER_NS);
        let mut lie = liar.report();
        (lie.mediator_instance, lie.mediator_journal) = (99, 9);
        (lie.mediator_epoch, lie.mediator_heard) = (1 << 40, true);
        manager.report(&lie, now_ns);
        let status = talk(&mut manager, &mut robots, now_ns);
        assert!(!status.stands_by, "{status:?}");
        assert_eq!(status.awaited, ["amr-3"]);
    }
    let follow = { robots.iter() }.all(|(client, _)| client.mediator_epoch() == manager.epoch());
    assert!(follow && manager.epoch() == epoch + 1);
    is_seen_to(&mut manager, &mut robots, now_ns);
}

/// A mediator with which three robots have registered, two of them, and the third one.
fn beside_a_third() -> (Manager, Vec<(Client, Situation)>, (Client, Situation)) {
    let mut manager = start(&Stored::new(1), 50, 0);
    let mut robots = ["amr-1", "amr-2", "amr-3"]
        .map(|id| robot(id, &[]))
        .to_vec();
    talk(&mut manager, &mut robots, NOW_NS);
    let third = robots.pop().expect("there are three");
    (manager, robots, third)
}

/// The other mediator may have granted it anything until it was heard last.
#[test]
fn one_that_follows_another_mediator_is_absent_only_when_it_enters_nothing_any_more() {
    let (mut manager, mut robots, (mut other, situation)) = beside_a_third();
    robots[0].1.wanted = vec![AREA.to_owned()];
    let mut now_ns = NOW_NS;
    for _ in 0..30 {
        now_ns += SILENT_AFTER_NS / 5;
        other.step(situation.clone(), now_ns, SILENT_AFTER_NS);
        let mut report = other.report();
        (report.mediator_instance, report.mediator_journal) = (99, 9);
        report.mediator_heard = true;
        manager.report(&report, now_ns);
        let status = talk(&mut manager, &mut robots, now_ns);
        assert_eq!(
            (status.stands_by, status.awaited),
            (false, vec!["amr-3".to_owned()])
        );
    }
    let silent_ns = now_ns + SILENT_AFTER_NS + 1;
    talk(&mut manager, &mut robots, silent_ns);
    let early = manager.absent("amr-3", false, silent_ns);
    assert!(
        matches!(early, Err(AbsentError::MayEnter { .. })),
        "{early:?}"
    );
    is_seen_to(&mut manager, &mut robots, now_ns);
}

#[test]
fn a_robot_that_goes_on_telling_of_mediators_that_are_gone_has_all_asked_once_in_a_while() {
    let mut manager = start(&Stored::new(1), 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    let epoch = manager.epoch();
    // Between two lies it registers as it should.
    for round in 0..8 {
        let now_ns = NOW_NS + round * SILENT_AFTER_NS / 10;
        let (liar, situation) = &mut robots[2];
        liar.step(situation.clone(), now_ns, SILENT_AFTER_NS);
        let mut lie = liar.report();
        lie.mediator_instance = 100 + round;
        (lie.mediator_epoch, lie.mediator_heard) = (manager.epoch() + 7, false);
        manager.report(&lie, now_ns);
        let status = talk(&mut manager, &mut robots, now_ns);
        // The others are not asked for it again; it is, so that nothing is granted that it may have.
        let awaited: &[&str] = if round == 0 { &[] } else { &["amr-3"] };
        assert_eq!(status.awaited, awaited, "{round}");
    }
    assert_eq!(manager.epoch(), epoch + 8);
    let now_ns = NOW_NS + 3 * SILENT_AFTER_NS;
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(status.awaited.is_empty() && manager.epoch() > epoch + 8);
}

/// It alone is heard, and says in turn that it hears another mediator, and that it does not.
#[test]
fn a_robot_that_has_the_mediator_stand_by_again_and_again_has_all_asked_once_in_a_while() {
    let (mut manager, mut robots, (mut liar, situation)) = beside_a_third();
    let mut now_ns = NOW_NS + 2 * SILENT_AFTER_NS;
    let mut stood_by = 0;
    let epoch = manager.epoch();
    manager.entries().for_each(drop);
    for round in 0..60 {
        now_ns += SILENT_AFTER_NS / 10;
        liar.step(situation.clone(), now_ns, SILENT_AFTER_NS);
        let mut lie = liar.report();
        (lie.mediator_instance, lie.mediator_journal) = (99, 9);
        (lie.mediator_epoch, lie.mediator_heard) = (1 << 40, round % 2 == 0);
        manager.report(&lie, now_ns);
        manager.tick(now_ns);
        stood_by += u32::from(manager.stands_by());
    }
    assert!(stood_by >= 20, "{stood_by}");
    let grown = manager.epoch() - epoch;
    assert!((1..=4).contains(&grown), "{grown} times in 6 s");
    let epochs = { manager.entries() }.filter(|own| matches!(own, Entry::Epoch(_)));
    assert_eq!(epochs.count() as u64, grown);
    // It goes on when robots follow no other any more.
    let now_ns = now_ns + 3 * SILENT_AFTER_NS;
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(
        !status.stands_by && status.awaited == ["amr-3"],
        "{status:?}"
    );
}

#[test]
fn a_robot_that_is_gone_for_good_may_leave_the_site_file() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[AREA]));
    talk(&mut manager, &mut robots, NOW_NS);
    robots[2].1.stands_in = vec![AREA.to_owned()];
    talk(&mut manager, &mut robots, NOW_NS);
    keep(&mut manager, &mut stored);
    let mut without = setup();
    without.robots.pop();
    let restart = |stored: &Stored| Manager::new(&without, stored, NOW_NS);
    // It stands there, for all that is known.
    let error = restart(&stored).expect_err("it is somewhere");
    assert!(
        error.to_string().contains("robot `amr-3`") && error.to_string().contains("absent"),
        "{error}"
    );
    let now_ns = NOW_NS + ENTERS_NO_MORE_NS;
    manager.tick(now_ns);
    let inside = AbsentError::Inside {
        robot: "amr-3".to_owned(),
        areas: AREA.to_owned(),
    };
    assert_eq!(manager.absent("amr-3", false, now_ns), Err(inside));
    assert_eq!(
        manager.absent("amr-3", true, now_ns),
        Ok(vec![AREA.to_owned()])
    );
    keep(&mut manager, &mut stored);
    let mut manager = restart(&stored).expect("it is nowhere");
    robots.pop();
    robots[0].1.wanted = vec![AREA.to_owned()];
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[0].0.holds(AREA));
}

#[test]
fn an_empty_journal_is_refused_unless_it_is_a_first_start() {
    let folder = crate::program::folder();
    let site = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../config/sites/overtaking.toml"
    );
    // A journal that was refused is no less empty.
    for _ in 0..2 {
        let started = Command::new(env!("CARGO_BIN_EXE_mediator"))
            .args(["run", "--listen", "tcp/127.0.0.1:0", "--site", site])
            .arg("--journal")
            .arg(folder.path().join("journal.redb"))
            .arg("--runtime")
            .arg(folder.path().join("run"))
            .stderr(Stdio::piped())
            .spawn();
        let mut child = started.expect("the program starts");
        let until = Instant::now() + Duration::from_secs(20);
        while child.try_wait().expect("our child").is_none() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(20));
        }
        // If it has ended, there is nobody to kill.
        let _ = child.kill();
        let output = child.wait_with_output().expect("our child");
        let said = String::from_utf8_lossy(&output.stderr);
        let refused = output.status.code() == Some(i32::from(mediator::cli::EXIT_REFUSED));
        assert!(refused && said.contains("--first-start"), "{said}");
    }
}

pub fn floor(max_x_m: f64) -> Floor {
    let area = |id: &str| FloorArea {
        id: id.to_owned(),
        capacity: 1,
        min_m: [0.0, 0.0],
        max_m: [max_x_m, 2.0],
    };
    Floor::new([AREA, "yard"].map(area).to_vec())
}

#[test]
fn a_robot_that_knows_another_floor_is_refused_with_what_differs_until_it_knows_ours() {
    let setup = Setup {
        floor: floor(3.0),
        ..setup()
    };
    let mut manager = Manager::new(&setup, &Stored::new(1), 0).expect("valid");
    for id in ["amr-2", "amr-3"] {
        assert_eq!(manager.absent(id, false, NOW_NS), Ok(Vec::new()));
    }
    let (client, wants) = robot("amr-1", &[AREA]);
    let mut robots = [(client.on(floor(4.0)), wants.clone())];
    talk(&mut manager, &mut robots, NOW_NS);
    let refusal = robots[0].0.refusal().to_owned();
    let named = "area `gate` holds 1 and goes from (0.000, 0.000) to (4.000, 2.000) m by its site file, and holds 1 and goes from (0.000, 0.000) to (3.000, 2.000) m by ours";
    assert!(refusal.contains(named), "{refusal}");
    assert!(!robots[0].0.is_registered() && !robots[0].0.holds(AREA));
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(matches!(&alarms[..], [Alarm::Floor { .. }]), "{alarms:?}");
    let why = |manager: &Manager, id| manager.why(id, NOW_NS).expect("a robot");
    let told = why(&manager, "amr-1");
    assert!(
        told.starts_with("amr-1 reports, and is refused: ") && told.contains(named),
        "{told}"
    );
    assert_eq!(why(&manager, "amr-2"), "amr-2 was never heard of");
    // Somebody gives it the right file: as another process it is welcome.
    let client = Client::new("amr-1", "hall", 8).on(floor(3.0));
    let mut robots = [(client, wants)];
    talk(&mut manager, &mut robots, NOW_NS);
    assert!(robots[0].0.holds(AREA), "{}", robots[0].0.refusal());
}

#[test]
fn a_robot_can_learn_the_floor_from_its_mediator_and_refuses_one_that_lies() {
    let setup = Setup {
        floor: floor(3.0),
        ..setup()
    };
    let mut manager = Manager::new(&setup, &Stored::new(1), 0).expect("valid");
    let (client, wants) = robot("amr-1", &[AREA]);
    let mut client = client.on(floor(4.0));
    let mut told = None;
    for _ in 0..2 {
        client.step(wants.clone(), NOW_NS, SILENT_AFTER_NS);
        manager.report(&client.report(), NOW_NS);
        told = manager.next_message(NOW_NS).or(told);
    }
    let told = told.expect("a refusal");
    assert_eq!(told.session, 0);
    assert_eq!(told.floor_hash, setup.floor.hash());
    assert_eq!(Floor::said(&told.floor), setup.floor);
    let mut client = client.on(Floor::said(&told.floor));
    let mut floors = 0;
    for _ in 0..3 {
        client.step(wants.clone(), NOW_NS, SILENT_AFTER_NS);
        manager.report(&client.report(), NOW_NS);
        while let Some(message) = manager.next_message(NOW_NS) {
            client.receive(&message, NOW_NS);
            floors += usize::from(!message.floor.is_empty());
        }
    }
    assert!(client.is_registered() && floors == 0, "it knows it by now");
    // A mediator that takes it in though it knows another floor is refused by the robot.
    let lies = MediatorReport {
        sequence: 99,
        floor_hash: 7,
        ..told
    };
    let lies = MediatorReport {
        session: client.session(),
        refusal: String::new(),
        ..lies
    };
    assert_eq!(client.receive(&lies, NOW_NS), Received::Refused);
    assert!(client.refusal().contains("knows another floor"));
}

#[test]
fn a_new_process_does_not_say_where_the_one_before_drives_its_body() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = vec![robot("amr-1", &[]), robot("amr-2", &[])];
    robots.push(robot("amr-3", &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    keep(&mut manager, &mut stored);
    // The journal has lost that the first robot was granted the area, whose process has ended, and whose body drives in.
    let mut manager = start(&stored, 51, NOW_NS);
    robots[0].0 = Client::new("amr-1", "hall", 8);
    robots[1].1.wanted = vec![AREA.to_owned()];
    let taken_in_ns = NOW_NS + 3 * SILENT_AFTER_NS;
    assert_eq!(
        talk(&mut manager, &mut robots, taken_in_ns).awaited,
        ["amr-1"]
    );
    assert!(!robots[1].0.holds(AREA));
    let why = manager.why("amr-2", taken_in_ns).expect("it is known");
    let expected = "nothing is granted until amr-1 has reported where it stands";
    assert!(why.contains(expected), "{why}");
    // What it has said before, it may have said before the body was inside.
    let (client, situation) = &mut robots[0];
    client.step(situation.clone(), taken_in_ns, SILENT_AFTER_NS);
    let late = client.report();
    let now_ns = NOW_NS + ENTERS_NO_MORE_NS + 1;
    manager.report(&late, now_ns);
    assert_eq!(manager.status(now_ns).awaited, ["amr-1"]);
    robots[0].1.stands_in = vec![AREA.to_owned()];
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(status.awaited.is_empty() && !robots[1].0.holds(AREA));
    // It was found there, and is no intruder.
    assert_eq!(status.areas[0].standing, ["amr-1"]);
    assert!(
        !manager
            .alarms()
            .any(|alarm| matches!(alarm, Alarm::Intruder { .. }))
    );
    robots[0].1.stands_in.clear();
    talk(&mut manager, &mut robots, now_ns);
    assert!(robots[1].0.holds(AREA));
}

#[test]
fn a_grant_that_the_journal_has_lost_counts_though_its_robot_is_heard_after_another_start_only() {
    let mut both = setup();
    both.areas[0].capacity = 2;
    let start = |stored: &Stored, instance| {
        let manager = Manager::new(&both, stored, 0).expect("valid");
        manager.speaks_as(instance)
    };
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50);
    let mut robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    keep(&mut manager, &mut stored);
    for (_, situation) in &mut robots[..2] {
        situation.wanted = vec![AREA.to_owned()];
    }
    let status = talk(&mut manager, &mut robots, NOW_NS);
    assert_eq!(status.areas[0].holders.len(), 2);

    // The last writes are lost; the robot with the later grant is heard.
    let mut manager = start(&stored, 51);
    let status = talk(&mut manager, &mut robots[1..], NOW_NS);
    assert_eq!(status.areas[0].holders, [("amr-2".to_owned(), 2)]);
    assert_eq!(status.awaited, ["amr-1"]);
    keep(&mut manager, &mut stored);

    let mut manager = start(&stored, 52);
    let status = talk(&mut manager, &mut robots, NOW_NS);
    assert_eq!(status.areas[0].holders.len(), 2, "{status:?}");
    let alarms: Vec<Alarm> = manager.alarms().collect();
    let adopted = |alarm: &Alarm| matches!(alarm, Alarm::Adopted { robot, .. } if robot == "amr-1");
    assert!(alarms.iter().any(adopted), "{alarms:?}");
    assert!(
        !alarms
            .iter()
            .any(|alarm| matches!(alarm, Alarm::BadReport { .. }))
    );
    // From then on the journal knows of all grants.
    keep(&mut manager, &mut stored);
    assert!(stored.adopted.is_empty() && stored.fences[AREA] == 2);
}

#[test]
fn a_grant_that_the_journal_has_lost_ends_when_its_robot_was_said_to_be_absent() {
    let mut stored = Stored::new(1);
    let mut manager = start(&stored, 50, 0);
    let mut robots = ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[]));
    talk(&mut manager, &mut robots, NOW_NS);
    keep(&mut manager, &mut stored);
    robots[0].1.wanted = vec![AREA.to_owned()];
    talk(&mut manager, &mut robots, NOW_NS);
    assert!(robots[0].0.holds(AREA));

    let mut manager = start(&stored, 51, NOW_NS);
    let now_ns = NOW_NS + ENTERS_NO_MORE_NS;
    assert_eq!(manager.absent("amr-1", false, now_ns), Ok(Vec::new()));
    robots[1].1.wanted = vec![AREA.to_owned()];
    talk(&mut manager, &mut robots[1..], now_ns);
    assert!(robots[1].0.holds(AREA));
    manager.alarms().for_each(drop);

    // It was only out of reach, and would enter as soon as it is heard.
    let status = talk(&mut manager, &mut robots, now_ns);
    assert!(!robots[0].0.holds(AREA) && robots[1].0.holds(AREA));
    assert_eq!(status.areas[0].waiting.len(), 1, "it asks anew");
    let void = Alarm::Void {
        robot: "amr-1".to_owned(),
        area: AREA.to_owned(),
    };
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(alarms.contains(&void), "{alarms:?}");
    assert!(
        !alarms
            .iter()
            .any(|alarm| matches!(alarm, Alarm::BadReport { .. }))
    );
}

/// Its journal has lost that the robot came back, what it was granted since, and that this was asked back.
#[test]
fn a_robot_that_was_asked_more_often_than_the_journal_knows_is_asked_again() {
    // How often it was asked, and whether it heard that its answer had come.
    for (times, hears) in [(1, true), (1, false), (3, true), (3, false)] {
        let (stored, mut manager, mut robots) = without_the_first();
        robots.push(robot("amr-1", &[]));
        for time in 1..=times {
            robots[2].1.wanted = vec![AREA.to_owned()];
            talk(&mut manager, &mut robots, NOW_NS);
            assert!(robots[2].0.holds(AREA));
            let by = ClosedRecord::default();
            manager.close(AREA, by, NOW_NS).expect("a known area");
            robots[2].1.wanted = Vec::new();
            if time == times && !hears {
                manager.tick(NOW_NS);
                while let Some(message) = manager.next_message(NOW_NS) {
                    robots[2].0.receive(&message, NOW_NS);
                }
                let (client, situation) = &mut robots[2];
                client.step(situation.clone(), NOW_NS, SILENT_AFTER_NS);
            } else {
                talk(&mut manager, &mut robots, NOW_NS);
                manager.open(AREA, NOW_NS).expect("a known area");
            }
            assert!(!robots[2].0.holds(AREA));
        }
        let back = robots.pop().expect("the first one");

        let mut manager = start(&stored, 51, NOW_NS);
        let mut now_ns = NOW_NS + ENTERS_NO_MORE_NS;
        assert!(talk(&mut manager, &mut robots, now_ns).awaited.is_empty());
        robots.push(back);
        talks_on(&mut manager, &mut robots, &mut now_ns);
        for _ in 0..2 {
            let what = format!("{times}, {hears}");
            gives_back_what_is_closed(&mut manager, &mut robots, 2, now_ns, &what);
        }
    }
}
