//! One robot against scripted messages.

mod grants;
mod lease;
mod mediators;

use super::*;
use crate::VERSION;
use crate::floor::Floor;
use crate::wire::{
    Access, AccessGrant, Control, ControlFlag, ControlPath, Instruction, Level, MediatorReport,
    RobotReport, TakeUp,
};

const SECOND_NS: u64 = 1_000_000_000;

fn level(run: u32, path: u32, progress: u32) -> Option<Level> {
    Some(Level {
        run,
        path,
        progress,
        after_abort: false,
    })
}

fn message(sequence: u64) -> MediatorReport {
    MediatorReport {
        version: Some(VERSION.into()),
        instance: 60,
        journal: 60,
        mediator_epoch: 1,
        sequence,
        robot_id: "amr-1".into(),
        boot_epoch: 7,
        session: 1,
        floor_hash: Floor::default().hash(),
        ..MediatorReport::default()
    }
}

fn grant(area: &str, progress: u32, fence: u64) -> AccessGrant {
    AccessGrant {
        area: area.into(),
        level: level(0, 0, progress),
        fence,
        waits_for: String::new(),
        ..AccessGrant::default()
    }
}

fn registered() -> Client {
    let mut client = Client::new("amr-1", "corridor", 7);
    assert_eq!(client.receive(&message(1), 0), Received::Registered);
    client
}

fn situation(stands_in: &[&str], wanted: &[&str], committed: &[&str]) -> Situation {
    let names = |list: &[&str]| list.iter().map(|&name| name.to_owned()).collect();
    Situation {
        located: true,
        stands_in: names(stands_in),
        wanted: names(wanted),
        committed: names(committed),
        ..Situation::default()
    }
}

/// Net flags e5, done5 or at once e1, done1.
fn control(path: u32, progress: u32) -> Control {
    let flag = |name: &str, by_mediator: bool, event: &str, on_output: &str| ControlFlag {
        name: name.into(),
        by_mediator,
        instruction: (!event.is_empty()).then(|| Instruction {
            event: event.into(),
            areas: if event == "aside" {
                vec!["5".into()]
            } else {
                Vec::new()
            },
            ..Instruction::default()
        }),
        on_output: on_output.into(),
    };
    let whole = |flags: &[u32]| ControlPath {
        flags: flags.to_vec(),
    };
    Control {
        coordination: 3,
        level: level(0, path, progress),
        net: "overtaking".into(),
        flags: vec![
            flag("acquire", true, "", ""),
            flag("acquired", false, "", ""),
            flag("e5", true, "aside", ""),
            flag("done5", false, "", "parked"),
            flag("e1", true, "back", ""),
            flag("done1", false, "", "in-1"),
            flag("release", true, "resume", ""),
            flag("released", false, "", ""),
        ],
        paths: vec![whole(&[0, 1, 2, 3, 4, 5, 6, 7]), whole(&[0, 1, 4, 5, 6, 7])],
    }
}

fn progress(client: &mut Client) -> Option<(u32, u32)> {
    let level = client.report().control?.level?;
    Some((level.path, level.progress))
}

#[test]
fn an_acquired_robot_follows_orders_and_asks_for_nothing_else() {
    let mut client = registered();
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    let mut told = message(2);
    told.access = vec![grant("1", 2, 1)];
    told.control = Some(control(0, 1));
    client.receive(&told, 0);
    assert!(client.is_acquired());
    // `acquired` waits for no output; area 2 is not asked for.
    assert!(client.step(situation(&["1"], &["1", "2"], &[]), 0, SECOND_NS));
    let report = client.report();
    assert!(report.access.iter().all(|access| access.area != "2"));
    assert_eq!(progress(&mut client), Some((0, 2)));

    let mut told = message(3);
    told.control = Some(control(0, 3));
    client.receive(&told, 0);
    let order = client.next_order().expect("there is one");
    assert_eq!(
        (order.flag.as_str(), order.instruction.event.as_deref()),
        ("e5", Some("aside"))
    );
    assert!(!order.repeated);
    assert_eq!(client.next_order(), None, "each once");
    client.step(situation(&["1"], &["1", "2"], &[]), 0, SECOND_NS);
    let report = client.report();
    assert!(report.access.iter().any(|access| access.area == "5"));
    // Other outputs set no flag.
    assert!(!client.output("in-1"));
    assert!(client.output("parked") && !client.output("parked"));
    assert_eq!(progress(&mut client), Some((0, 4)));

    let mut told = message(4);
    told.control = Some(control(0, 5));
    client.receive(&told, 0);
    assert!(client.output("in-1"));
    let mut told = message(5);
    told.control = Some(control(0, 7));
    client.receive(&told, 0);
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    assert!(
        client.is_acquired(),
        "as long as it has not taken the order"
    );
    let orders = [client.next_order(), client.next_order()];
    let events = orders.map(|order| order.and_then(|order| order.instruction.event));
    assert_eq!(events, [Some("back".into()), Some("resume".into())]);
    client.step(situation(&["1"], &["1", "2"], &[]), 0, SECOND_NS);
    assert!(!client.is_acquired(), "released at once");
    assert_eq!(progress(&mut client), Some((0, 8)));
    client.receive(&message(6), 0);
    assert_eq!(progress(&mut client), None);
    assert_eq!(client.counters().let_go, 0);
}

/// It may have been wrong about where it is.
#[test]
fn an_ordered_area_is_kept_until_the_order_is_answered() {
    let mut client = registered();
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    for (sequence, progress) in [(2, 1), (3, 3)] {
        let mut told = message(sequence);
        told.access = vec![grant("1", 2, 1)];
        told.control = Some(control(0, progress));
        client.receive(&told, 0);
        while client.next_order().is_some() {}
        client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    }
    let mut told = message(4);
    told.access = vec![grant("5", 2, 4)];
    told.control = Some(control(0, 3));
    client.receive(&told, 0);
    let run = |client: &Client| {
        let access = client.clone().report().access;
        let level = access
            .iter()
            .find(|own| own.area == "5")
            .and_then(|own| own.level);
        level.map(|level| level.progress)
    };
    for (stands_in, expected) in [(&["1"][..], 2), (&["1", "5"], 3), (&["1"], 3), (&["1"], 3)] {
        client.step(situation(stands_in, &["1"], &[]), 0, SECOND_NS);
        assert_eq!(run(&client), Some(expected), "{stands_in:?}");
    }
    assert!(client.output("parked"));
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    assert_eq!(run(&client), Some(4), "it has left it");
}

#[test]
fn the_mediator_chooses_the_path() {
    let mut client = registered();
    let mut told = message(2);
    told.control = Some(control(0, 1));
    client.receive(&told, 0);
    client.step(situation(&["5"], &["5"], &[]), 0, SECOND_NS);
    let mut told = message(3);
    told.control = Some(control(1, 3));
    client.receive(&told, 0);
    assert_eq!(
        client.next_order().map(|order| order.flag),
        Some("e1".into())
    );
    assert!(client.output("in-1"));
    assert_eq!(progress(&mut client), Some((1, 4)));
}

#[test]
fn a_robot_that_restarts_gets_its_last_order_again() {
    let mut client = Client::new("amr-1", "corridor", 7);
    let mut told = message(1);
    told.control = Some(control(0, 3));
    assert_eq!(client.receive(&told, 0), Received::Registered);
    let order = client.next_order().expect("there is one");
    assert!(order.repeated && order.flag == "e5");
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    assert!(
        client
            .report()
            .access
            .iter()
            .any(|access| access.area == "5")
    );
    assert!(client.output("parked"));
}

/// Its machine went on where it was, and was quicker.
#[test]
fn what_a_robot_does_before_it_is_registered_again_is_an_answer_to_its_last_order() {
    let mut client = Client::new("amr-1", "corridor", 7);
    assert!(!client.output("parked"), "to whom?");
    let mut told = message(1);
    told.control = Some(control(0, 3));
    assert_eq!(client.receive(&told, 0), Received::Registered);
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    let said = client.report().control.expect("it has joined");
    assert_eq!(said.level.expect("it has one").progress, 4);
}

#[test]
fn a_robot_that_is_let_go_carries_out_the_release() {
    let mut client = registered();
    let mut told = message(2);
    told.control = Some(control(0, 1));
    client.receive(&told, 0);
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    client.receive(&message(3), 0);
    assert!(!client.is_acquired());
    assert_eq!(
        client
            .next_order()
            .and_then(|order| order.instruction.event),
        Some("resume".into())
    );
    assert_eq!(client.counters().let_go, 1);
    // The past does not take it back.
    client.receive(&told, 0);
    assert!(!client.is_acquired());
}

#[test]
fn a_larger_number_replaces_and_a_broken_one_is_counted() {
    let mut client = registered();
    let mut told = message(2);
    told.control = Some(control(0, 3));
    // It knows of no `acquired` of its own.
    client.receive(&told, 0);
    assert_eq!(
        (client.counters().bad_levels, client.is_acquired()),
        (1, false)
    );
    let mut told = message(3);
    told.control = Some(control(0, 1));
    client.receive(&told, 0);
    let mut told = message(4);
    told.control = Some(Control {
        coordination: 4,
        ..control(0, 1)
    });
    client.receive(&told, 0);
    assert_eq!(client.coordination().map(|own| own.0), Some(4));
    let mut told = message(5);
    let mut broken = control(0, 1);
    broken.coordination = 5;
    broken.paths[1].flags.push(99);
    told.control = Some(broken);
    client.receive(&told, 0);
    assert_eq!(client.coordination().map(|own| own.0), Some(4));
    assert_eq!(client.counters().bad_levels, 2);
}

#[test]
fn a_robot_that_had_restarted_when_it_was_let_go_is_released_when_it_registers() {
    let mut client = Client::new("amr-1", "corridor", 7);
    let mut told = message(1);
    told.take_up = Some(TakeUp {
        fsm_state: "halted".into(),
        release: Some(Instruction {
            event: "resume".into(),
            ..Instruction::default()
        }),
        ..TakeUp::default()
    });
    client.receive(&told, 0);
    let order = client.next_order().expect("there is one");
    assert_eq!(order.instruction.event.as_deref(), Some("resume"));
    // Once: it is told where it was until it has said where it is.
    told.sequence = 2;
    client.receive(&told, 0);
    assert_eq!(client.next_order(), None);
}

#[test]
fn a_robot_whose_identity_another_process_has_holds_nothing_and_asks_on() {
    let mut client = registered();
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    let mut told = message(2);
    told.access = vec![grant("1", 2, 1)];
    told.identity_doubled = true;
    client.receive(&told, 0);
    assert!(client.holds("1") && client.is_identity_doubled());
    let refused = MediatorReport {
        session: 0,
        refusal: "another process".into(),
        identity_taken: true,
        ..message(3)
    };
    assert_eq!(client.receive(&refused, 0), Received::Refused);
    assert!(!client.holds("1") && client.is_identity_taken());
    client.step(situation(&["1"], &["1"], &[]), 0, SECOND_NS);
    let report = client.report();
    assert!(report.session == 0 && report.access.is_empty());
    assert_eq!(client.receive(&message(4), 0), Received::Registered);
    assert!(!client.is_identity_taken() && client.refusal().is_empty());
}

#[test]
fn a_factsheet_names_the_protocols_that_the_robot_knows() {
    let client = || Client::new("amr-1", "corridor", 7).of_kind(crate::wire::Factsheet::default());
    let protocols = |mut client: Client| client.report().factsheet.map(|own| own.protocols);
    assert_eq!(protocols(client()), Some(vec![1, 2]));
    assert_eq!(protocols(client().without_control()), Some(vec![1]));
}
