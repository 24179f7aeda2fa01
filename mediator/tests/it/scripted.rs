//! Manager and clients step by step: what a fence refuses, what `why` says, what `clear` ends.

use std::sync::Arc;
use std::time::Duration;

use crate::sites::{self, JUNCTION, net, uncoordinated};
use contract::client::{Client, Situation};
use contract::floor::Floor;
use coordination::analysis::Limits;
use mediator::journal::Stored;
use mediator::manager::{Alarm, Manager};
use mediator::nets::{Plan, plans};
use mediator::setup::{AreaSetup, RobotSetup, Setup};

const SECOND_NS: u64 = 1_000_000_000;
/// Long after managers have started, at 0: no robot may still enter what an earlier one has granted.
const NOW_NS: u64 = 10 * SECOND_NS;

fn setup(capacity: u32) -> Setup {
    let robot = |id: &str| RobotSetup {
        id: id.into(),
        role: "normal".into(),
        priority: 0,
        ages_after: 0,
        starts_in: Vec::new(),
    };
    Setup {
        site: "t-junction".into(),
        areas: vec![AreaSetup {
            id: "Cr".into(),
            capacity,
        }],
        robots: ["amr-1", "amr-2", "amr-3"].map(robot).into(),
        floor: Floor::default(),
        silent_after: Duration::from_secs(1),
    }
}

/// The crossing by its net, on a setup of its own.
fn junction(setup: &Setup) -> Vec<Arc<Plan>> {
    let site = sites::site("site.toml", &(uncoordinated("t-junction") + JUNCTION));
    plans(&site, setup, &[net("t-junction")], &Limits::default()).expect("it fits")
}

/// Lets both sides talk until nobody has news.
fn talk(manager: &mut Manager, clients: &mut [(Client, Situation)], now_ns: u64) {
    for _ in 0..8 {
        for (client, situation) in &mut *clients {
            client.step(situation.clone(), now_ns, SECOND_NS);
            manager.report(&client.report(), now_ns);
        }
        while let Some(message) = manager.next_message(now_ns) {
            for (client, _) in &mut *clients {
                client.receive(&message, now_ns);
            }
        }
    }
}

fn assert_any(alarms: &[Alarm], fits: impl Fn(&Alarm) -> bool) {
    assert!(alarms.iter().any(fits), "{alarms:?}");
}

/// The only alarm is that a coordination of the journal is given up, for this reason.
fn assert_not_resumed(manager: &mut Manager, why: &str) {
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(
        matches!(&alarms[..], [alarm @ Alarm::NotResumed { .. }] if alarm.to_string().contains(why)),
        "{alarms:?}"
    );
}

/// A robot of the corridor, somewhere, in some state.
fn driver(id: &str, area: &str, state: &str, wanted: &[&str]) -> (Client, Situation) {
    let situation = Situation {
        located: true,
        stands_in: vec![area.to_owned()],
        wanted: { [&area].into_iter().chain(wanted) }
            .map(|&area| area.to_owned())
            .collect(),
        fsm_state: state.to_owned(),
        ..Situation::default()
    };
    (Client::new(id, "corridor", 5), situation)
}

/// A normal and an emergency robot.
type Pair = [(Client, Situation); 2];

/// The emergency robot behind a normal one, both acquired, the normal one told to drive aside.
fn overtaking() -> (Setup, Vec<Arc<Plan>>, Manager, Pair) {
    let (mut setup, plans) = sites::corridor();
    setup
        .robots
        .iter_mut()
        .for_each(|robot| robot.starts_in.clear());
    let mut manager =
        Manager::with_plans(&setup, plans.clone(), &Stored::new(1), 0).expect("valid");
    assert_eq!(manager.absent("third", false, NOW_NS), Ok(Vec::new()));
    let mut clients = [
        driver("slow", "1", "driving", &[]),
        driver("fast", "7", "driving", &["1"]),
    ]
    .map(|(client, now)| (client.on(setup.floor.clone()), now));
    talk(&mut manager, &mut clients, NOW_NS);
    assert!(clients.iter().all(|own| own.0.is_acquired()));
    let order = clients[0].0.next_order().expect("there is one");
    assert_eq!(order.instruction.event.as_deref(), Some("aside"));
    let order = clients[1].0.next_order().expect("there is one");
    assert_eq!(
        (order.instruction.event, order.instruction.speed_limit_m_s),
        (None, Some(0.2))
    );
    talk(&mut manager, &mut clients, NOW_NS);
    (setup, plans, manager, clients)
}

#[test]
fn what_stands_still_gets_out_of_the_way_before_anything_else_moves() {
    let (_, _, mut manager, mut clients) = overtaking();
    let why = manager.why("fast", NOW_NS).expect("it is known");
    assert!(why.contains("lacks a token in `normal-in-5`"), "{why}");
    // Nothing is done about the order, for longer than the site allows.
    let now_ns = NOW_NS + 7 * SECOND_NS;
    for now_ns in [0, 2, 4, 6, 7].map(|second| NOW_NS + second * SECOND_NS) {
        talk(&mut manager, &mut clients, now_ns);
        manager.tick(now_ns);
    }
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert_any(&alarms, |alarm| matches!(alarm, Alarm::Still { .. }));
    assert_any(&alarms, |alarm| matches!(alarm, Alarm::Preempted { .. }));
    talk(&mut manager, &mut clients, now_ns);
    let order = |own: &mut (Client, Situation)| {
        let orders = std::iter::from_fn(|| own.0.next_order());
        orders.last().and_then(|order| order.instruction.event)
    };
    for own in &mut clients {
        assert_eq!(order(own).as_deref(), Some("halt"));
    }
    // One of them has not got there yet: nobody goes on.
    clients[1].1.fsm_state = "halted".into();
    talk(&mut manager, &mut clients, now_ns);
    assert!(
        clients
            .iter_mut()
            .all(|own| own.0.is_acquired() && order(own).is_none())
    );
    clients[0].1.fsm_state = "halted".into();
    talk(&mut manager, &mut clients, now_ns);
    for own in &mut clients {
        assert!(own.0.is_acquired(), "until it has taken the order");
        assert_eq!(order(own).as_deref(), Some("resume"));
    }
    talk(&mut manager, &mut clients, now_ns);
    assert!(clients.iter().all(|own| !own.0.is_acquired()));
    // What stood still does not begin again at once.
    assert!(
        manager
            .status(now_ns)
            .coordinations
            .iter()
            .all(|own| own.over)
    );
}

/// Each run has a number of its own, by which `status` lists it.
#[test]
fn a_robot_that_is_absent_takes_part_in_nothing_though_it_had_no_area() {
    let (_, _, mut manager, mut clients) = overtaking();
    (clients[1].1.stands_in, clients[1].1.wanted) = Default::default();
    talk(&mut manager, &mut clients, NOW_NS);
    let runs = |manager: &Manager, now_ns| {
        let status = manager.status(now_ns);
        status.coordinations.iter().any(|own| !own.over)
    };
    assert!(runs(&manager, NOW_NS));
    let now_ns = NOW_NS + 6 * SECOND_NS;
    talk(&mut manager, &mut clients[..1], now_ns);
    manager.tick(now_ns);
    assert!(runs(&manager, now_ns));
    assert_eq!(manager.absent("fast", false, now_ns), Ok(Vec::new()));
    assert!(!runs(&manager, now_ns));
}

#[test]
fn alarms_name_the_run_that_stands_still() {
    let (_, _, mut manager, mut clients) = overtaking();
    let mut named = Vec::new();
    for now_ns in (0..20).map(|second| NOW_NS + second * SECOND_NS) {
        talk(&mut manager, &mut clients, now_ns);
        manager.tick(now_ns);
        let listed = manager.status(now_ns).coordinations;
        for alarm in manager.alarms() {
            if let Alarm::Still { coordination, .. } = alarm {
                let runs = { listed.iter() }.filter(|own| !own.over);
                assert!(
                    runs.map(|own| format!("{}/{}", own.id, own.number))
                        .any(|name| name == coordination),
                    "{coordination}: {listed:#?}"
                );
                named.push(coordination);
            }
        }
    }
    // First the net, then the robots that do not get out of the way.
    assert_eq!(named, ["overtaking/1", "overtaking/2"]);
}

#[test]
fn a_robot_that_was_let_go_before_a_power_loss_is_not_waited_for() {
    let (setup, plans, mut manager, mut clients) = overtaking();
    let mut stored = Stored::new(1);
    { manager.entries() }.for_each(|entry| stored.apply(entry));
    // What ends the coordination is lost with the power, but the robots have heard it.
    manager
        .clear("1", false, NOW_NS + SECOND_NS)
        .expect_err("somebody is in it");
    let later_ns = NOW_NS + 10 * SECOND_NS;
    clients[1].0.step(clients[1].1.clone(), later_ns, SECOND_NS);
    manager.report(&clients[1].0.report(), later_ns);
    manager.tick(later_ns);
    manager
        .clear("1", true, later_ns)
        .expect("that robot is silent");
    while let Some(message) = manager.next_message(later_ns) {
        clients.iter_mut().for_each(|own| {
            own.0.receive(&message, later_ns);
        });
    }
    assert!(clients.iter().all(|own| !own.0.is_acquired()));
    // The mediator before is silent by then.
    let later_ns = later_ns + 2 * SECOND_NS;
    let mut manager = Manager::with_plans(&setup, plans, &stored, later_ns).expect("its own");
    talk(&mut manager, &mut clients, later_ns);
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert_any(&alarms, |alarm| matches!(alarm, Alarm::Forgotten { .. }));
    let status = manager.status(later_ns);
    assert!(
        { status.coordinations.iter() }.all(|own| own.over || own.situation.is_empty()),
        "{status:#?}"
    );
}

fn robot(number: usize, wanted: &[&str]) -> (Client, Situation) {
    let client = Client::new(&format!("amr-{number}"), "t-junction", number as u64);
    let situation = Situation {
        located: true,
        wanted: wanted.iter().map(|&area| area.to_owned()).collect(),
        ..Situation::default()
    };
    (client, situation)
}

/// Nobody waits for the other two.
fn only_first(manager: &mut Manager) {
    for id in ["amr-2", "amr-3"] {
        assert_eq!(manager.absent(id, false, NOW_NS), Ok(Vec::new()));
    }
}

#[test]
fn a_level_with_the_fence_of_another_grant_is_ignored() {
    let mut manager = Manager::new(&setup(1), &Stored::new(1), 0).expect("valid");
    let mut clients = [robot(1, &["Cr"])];
    only_first(&mut manager);
    talk(&mut manager, &mut clients, NOW_NS);
    assert!(clients[0].0.holds("Cr"));
    clients[0].1.stands_in = vec!["Cr".into()];
    clients[0].0.step(clients[0].1.clone(), NOW_NS, SECOND_NS);
    let mut stale = clients[0].0.report();
    stale.stands_in.clear();
    stale.access[0].fence += 7;
    manager.report(&stale, NOW_NS);
    assert_eq!(manager.counters().other_fence, 1);
    assert_eq!(manager.counters().bad, 1, "people are told");
    let held = |manager: &Manager| manager.status(0).areas[0].holders.clone();
    assert_eq!(held(&manager), [("amr-1".to_owned(), 1)]);
    // With its own fence the same level counts.
    manager.report(&clients[0].0.report(), NOW_NS);
    clients[0].1 = Situation {
        located: true,
        ..Situation::default()
    };
    talk(&mut manager, &mut clients, NOW_NS);
    assert!(held(&manager).is_empty());
}

#[test]
fn nobody_is_accused_before_it_has_said_where_it_stands() {
    let mut setup = setup(1);
    for robot in &mut setup.robots {
        robot.starts_in = vec!["Cr".into()];
    }
    let mut manager = Manager::new(&setup, &Stored::new(1), 0).expect("valid");
    let mut clients = [robot(1, &[]), robot(2, &[]), robot(3, &["Cr"])];
    clients.iter_mut().for_each(|own| own.1.located = false);
    talk(&mut manager, &mut clients, NOW_NS);
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(alarms.is_empty(), "{alarms:?}");
    // Nobody goes where they may be.
    clients[2].1.located = true;
    talk(&mut manager, &mut clients, NOW_NS);
    assert!(!clients[2].0.holds("Cr"));
    clients[..2].iter_mut().for_each(|own| own.1.located = true);
    talk(&mut manager, &mut clients, NOW_NS);
    assert!(clients[2].0.holds("Cr"));
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert!(alarms.is_empty(), "{alarms:?}");
    // One that goes in later is.
    clients[0].1.stands_in = vec!["Cr".into()];
    manager.report(
        &{
            clients[0].0.step(clients[0].1.clone(), NOW_NS, SECOND_NS);
            clients[0].0.report()
        },
        0,
    );
    let alarms: Vec<Alarm> = manager.alarms().collect();
    assert_any(&alarms, |alarm| matches!(alarm, Alarm::Intruder { .. }));
}

#[test]
fn a_net_decides_although_there_is_room_and_why_explains_it() {
    let setup = setup(3);
    let plans = junction(&setup);
    let mut manager = Manager::with_plans(&setup, plans, &Stored::new(1), 0).expect("valid");
    let mut clients = [robot(1, &["Cr"]), robot(2, &["Cr"]), robot(3, &[])];
    talk(&mut manager, &mut clients, NOW_NS);
    let holds =
        |clients: &[(Client, Situation)]| clients.iter().filter(|own| own.0.holds("Cr")).count();
    assert_eq!(holds(&clients), 1);
    let waits = if clients[0].0.holds("Cr") {
        "amr-2"
    } else {
        "amr-1"
    };
    let why = manager.why(waits, NOW_NS + SECOND_NS).expect("it is known");
    assert!(
        why.contains("of net t-junction lacks a token in `free`")
            && why.contains("nobody is on the crossing or may come"),
        "{why}"
    );
    // When it is given back, the other gets it.
    let first = clients
        .iter()
        .position(|own| own.0.holds("Cr"))
        .expect("one");
    clients[first].1.wanted.clear();
    talk(&mut manager, &mut clients, NOW_NS);
    assert!(!clients[first].0.holds("Cr"));
    assert_eq!(holds(&clients), 1);
    let status = manager.status(0);
    assert_eq!(status.coordinations.len(), 1);
    assert!(status.coordinations[0].fired >= 4, "{status:#?}");
}

#[test]
fn a_net_goes_on_where_the_journal_left_it() {
    let setup = setup(3);
    let plans = junction(&setup);
    let mut stored = Stored::new(1);
    let mut manager = Manager::with_plans(&setup, plans.clone(), &stored, 0).expect("valid");
    let mut clients = [robot(1, &["Cr"]), robot(2, &["Cr"]), robot(3, &["Cr"])];
    talk(&mut manager, &mut clients, NOW_NS);
    { manager.entries() }.for_each(|entry| stored.apply(entry));
    let before = manager.status(0).coordinations[0].marking.clone();
    let mut manager = Manager::with_plans(&setup, plans.clone(), &stored, 0).expect("its own");
    assert_eq!(manager.status(0).coordinations[0].marking, before);
    talk(&mut manager, &mut clients, NOW_NS);
    assert_eq!(clients.iter().filter(|own| own.0.holds("Cr")).count(), 1);

    // A net that has changed since is given up, and says so.
    for record in stored.coordinations.values_mut() {
        record.marking.push("elsewhere".into());
    }
    let mut manager = Manager::with_plans(&setup, plans, &stored, 0).expect("still starts");
    assert_not_resumed(&mut manager, "no place `elsewhere` any more");
}

/// The net would let a second robot in, beside the one that the protocols have let in.
#[test]
fn a_journal_that_the_net_cannot_have_written_is_given_up() {
    let setup = setup(3);
    let plans = junction(&setup);
    let mut stored = Stored::new(1);
    let mut manager = Manager::with_plans(&setup, plans.clone(), &stored, 0).expect("valid");
    only_first(&mut manager);
    talk(&mut manager, &mut [robot(1, &["Cr"])], NOW_NS);
    { manager.entries() }.for_each(|entry| stored.apply(entry));
    for record in stored.coordinations.values_mut() {
        assert_ne!(record.marking, ["free"]);
        record.marking = vec!["free".into()];
    }
    let mut manager = Manager::with_plans(&setup, plans, &stored, 0).expect("still starts");
    assert_not_resumed(&mut manager, "never comes to where it is to begin");
}

#[test]
fn nonsense_about_coordinations_is_named_and_does_no_harm() {
    let setup = setup(3);
    let plans = junction(&setup);
    let mut manager = Manager::with_plans(&setup, plans, &Stored::new(1), 0).expect("valid");
    let mut clients = [robot(1, &["Cr"])];
    only_first(&mut manager);
    talk(&mut manager, &mut clients, NOW_NS);
    for number in [7, u64::MAX] {
        let mut report = clients[0].0.report();
        report.control = Some(contract::wire::Control {
            coordination: number,
            ..contract::wire::Control::default()
        });
        manager.report(&report, NOW_NS);
    }
    let alarms: Vec<String> = manager.alarms().map(|alarm| alarm.to_string()).collect();
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    assert!(
        alarms[0].contains("no coordination has number 18446744073709551615"),
        "{alarms:?}"
    );
    talk(&mut manager, &mut clients, NOW_NS);
    assert!(clients[0].0.holds("Cr"));
}
