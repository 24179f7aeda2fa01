//! Operators on other computers.

use contract::private;

use crate::program::Program;

use super::PATIENCE;
use super::hall::{Hall, operator, robot};

fn ask(hall: &Hall, identity: &str, command: &[&str]) -> (Option<i32>, String) {
    let connect = ["--connect", &hall.endpoint, "--identity", identity];
    Program::command(&[command, &connect].concat())
}

/// What it is told, at the first try that succeeds.
fn ask_until_told(hall: &Hall, identity: &str, command: &[&str]) -> String {
    let mut told = String::new();
    hall.until(&format!("{command:?} succeeds"), || {
        let (code, text) = ask(hall, identity, command);
        told = text;
        code == Some(0)
    });
    told
}

/// What becomes of an order. Where it had no link in time nobody has heard it, and it is given again.
fn order(hall: &Hall, identity: &str, command: &[&str]) -> (Option<i32>, String) {
    let mut answer = (None, String::new());
    hall.until(&format!("{command:?} has a link"), || {
        answer = ask(hall, identity, command);
        let text = &answer.1;
        !text.contains("no mediator answers") || text.contains("nothing within")
    });
    answer
}

#[test]
fn an_operator_asks_and_orders_from_afar_and_stands_in_the_journal() {
    let mut hall = Hall::open();
    let anna = operator(&hall, "anna").display().to_string();
    let mut amr_0 = hall.robot("amr-0");
    // Once her certificate counts.
    ask_until_told(&hall, &anna, &["status"]);
    hall.until("amr-0 is served", || {
        amr_0.step();
        robot(&hall.program.status().expect("it answers"), "amr-0").heard
    });
    let text = ask_until_told(&hall, &anna, &["status", "--json"]);
    assert!(text.contains("\"amr-1\""), "{text}");
    let text = ask_until_told(&hall, &anna, &["why", "amr-0"]);
    assert!(text.contains("amr-0 waits"), "{text}");

    // Nobody has heard of it: it counts as where the site starts it.
    let clear = ["clear", "room-1"];
    let (code, text) = order(&hall, &anna, &clear);
    assert!(
        code == Some(2) && text.contains("`mediator clear room-1 --taken-away`"),
        "{text}"
    );
    let (code, text) = order(&hall, &anna, &[&clear[..], &["--taken-away"]].concat());
    assert!(code == Some(0) && text.contains("amr-1"), "{text}");
    hall.wait_for_leases();
    let (code, text) = order(&hall, &anna, &["absent", "amr-1"]);
    assert!(code == Some(0) && text.contains("absent"), "{text}");
    let (code, text) = order(&hall, &anna, &["clear", "room-9"]);
    assert!(
        code == Some(2) && text.contains("there is no area"),
        "{text}"
    );
    let run = hall.folder.path().join("run").display().to_string();
    let (code, text) = Program::command(&["clear", "room-2", "--runtime", &run]);
    assert_eq!(code, Some(0), "{text}");

    hall.program.kill();
    hall.program.start();
    hall.program.wait_ready(PATIENCE);
    let (code, text) = Program::command(&["orders", "--runtime", &run]);
    assert_eq!(code, Some(0), "{text}");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 5, "{text}");
    assert!(
        lines[0].contains("clear room-1: refused: ")
            && lines[1].contains("clear room-1 --taken-away: done: "),
        "{text}"
    );
    let lines = &lines[2..];
    assert!(
        lines[0].contains("Z operator anna: absent amr-1: done: "),
        "{text}"
    );
    assert!(
        lines[1].contains("Z operator anna: clear room-9: refused: "),
        "{text}"
    );
    assert!(
        lines[2].contains("Z user ") && lines[2].contains(": clear room-2: done: "),
        "{text}"
    );
}

#[test]
fn no_other_file_lets_anybody_order() {
    let hall = Hall::open();
    let robot = hall.folder.path().join("robot.pem");
    private::replace(&robot, hall.identity("amr-1").to_pem().as_bytes()).expect("written");
    let (code, text) = ask(&hall, &robot.display().to_string(), &["absent", "amr-0"]);
    assert!(
        code == Some(1) && text.contains("expected an operator's"),
        "{text}"
    );

    let elsewhere = Hall::open();
    let stranger = operator(&elsewhere, "eve").display().to_string();
    let anna = operator(&hall, "anna").display().to_string();
    // The stranger waits for a link meanwhile, until it gives up.
    std::thread::scope(|threads| {
        let refused = threads.spawn(|| ask(&hall, &stranger, &["absent", "amr-0"]));
        ask_until_told(&hall, &anna, &["status"]);
        let party = contract::network::Party::Operator("anna".to_owned());
        hall.keys.revoke(&party).expect("revoked");
        hall.until("it counts no more", || {
            ask(&hall, &anna, &["status"]).0 == Some(1)
        });
        let (code, text) = refused.join().expect("it ends");
        assert!(
            code == Some(1) && text.contains("no mediator answers"),
            "{text}"
        );
    });
    let orders = Program::command(&[
        "orders",
        "--runtime",
        &hall.folder.path().join("run").display().to_string(),
    ]);
    assert_eq!(orders, (Some(0), String::new()));

    let missing = hall.folder.path().join("nobody.pem").display().to_string();
    let (code, text) = ask(&hall, &missing, &["status"]);
    assert!(code == Some(2) && text.contains("nobody.pem"), "{text}");
}
