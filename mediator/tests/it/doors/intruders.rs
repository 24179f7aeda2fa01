//! A robot with a certificate of its own tries to hear, to speak for and to command another, and to pass for the mediator.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use contract::wire::{MediatorReport, RobotReport};
use contract::{Message, VERSION, keys};
use zenoh::Wait;
use zenoh::sample::Locality;

use super::hall::{Hall, PREFIX, Robot, robot};
use crate::program::free_endpoint;

/// How long whoever has a link goes on.
const GOES_ON: Duration = Duration::from_secs(3);

/// Counts what a session hears under these keys, while it is kept.
fn listen(session: &zenoh::Session, keys: &str) -> Arc<AtomicU64> {
    let heard = Arc::new(AtomicU64::new(0));
    let count = Arc::clone(&heard);
    session
        .declare_subscriber(keys.to_owned())
        // Without what it says itself.
        .allowed_origin(Locality::Remote)
        .callback(move |_| {
            count.fetch_add(1, Ordering::Relaxed);
        })
        .background()
        .wait()
        .expect("it subscribes");
    heard
}

fn forged_report(id: &str, boot_epoch: u64, sequence: u64) -> Vec<u8> {
    RobotReport {
        version: Some(VERSION.into()),
        robot_id: id.to_owned(),
        site: "rooms".to_owned(),
        boot_epoch,
        sequence,
        ..RobotReport::default()
    }
    .encode_to_vec()
}

fn forged_order(id: &str, sequence: u64) -> Vec<u8> {
    MediatorReport {
        version: Some(VERSION.into()),
        robot_id: id.to_owned(),
        mediator_epoch: 1 << 40,
        boot_epoch: 7,
        session: 99,
        sequence,
        instance: 66,
        ..MediatorReport::default()
    }
    .encode_to_vec()
}

#[test]
fn a_robot_neither_hears_nor_speaks_for_nor_commands_another() {
    attack_as("peer");
}

#[test]
fn nor_does_one_that_is_a_client_of_the_mediator() {
    attack_as("client");
}

fn attack_as(mode: &str) {
    let hall = Hall::open();
    let [victim, thief] = ["amr-0", "amr-1"].map(|id| hall.identity(id));
    let thief = hall.lawless(&thief, mode, &[]);
    let everything = listen(&thief, "**");
    let theirs = listen(&thief, &format!("{PREFIX}/mediator/to/amr-0"));
    let reports = listen(&thief, &format!("{PREFIX}/robots/*/report"));
    let own = listen(&thief, &format!("{PREFIX}/mediator/to/amr-1"));
    let count = |heard: &AtomicU64| heard.load(Ordering::Relaxed);
    let tokens = [
        keys::mediator_alive(PREFIX),
        keys::mediator_instance(PREFIX, 7),
        keys::alive(PREFIX, "amr-0"),
    ];
    let _tokens: Vec<_> = tokens
        .map(|key| {
            let token = thief.liveliness().declare_token(key.expect("a plain name"));
            token.wait().expect("declared")
        })
        .into();
    hall.excuse("amr-1");
    let mut victim = Robot::new(hall.settings_as(&victim), "amr-0");
    let (mut number, mut both_since) = (0, None);
    hall.until("the thief hears, and the victim has its room", || {
        number += 1;
        let put = |key: &str, bytes: Vec<u8>| {
            thief
                .put(format!("{PREFIX}/{key}"), bytes)
                .wait()
                .expect("it sends");
        };
        put("robots/amr-0/report", forged_report("amr-0", 8, number));
        put("robots/amr-0/state", vec![1, 2, 3]);
        put("robots/amr-1/report", forged_report("amr-1", 9, number));
        put("mediator/to/amr-0", forged_order("amr-0", number));
        victim.step();
        if both_since.is_none() && victim.holds() && count(&own) > 0 {
            both_since = Some(Instant::now());
        }
        both_since.is_some_and(|since: Instant| since.elapsed() > GOES_ON)
    });
    // A question as an operator, and a certificate of the victim.
    let asked = [
        keys::question(PREFIX, "anna"),
        keys::certificate(PREFIX, "amr-0"),
    ]
    .map(|key| {
        let get = thief.get(key.expect("a plain name")).payload("\"status\"");
        get.timeout(Duration::from_secs(1)).wait().expect("it asks")
    });
    for replies in asked {
        let answered = replies
            .iter()
            .filter(|reply| reply.result().is_ok())
            .count();
        assert_eq!(answered, 0, "{mode}");
    }
    let log = hall.program.log();
    assert!(!log.contains("another mediator"), "{log}");
    // What was sent to it is all that reached it, by each of its subscriptions that fit.
    assert_eq!(count(&theirs), 0, "{mode}");
    assert_eq!(count(&reports), 0, "{mode}");
    assert!(count(&everything) <= count(&own), "{mode}");

    let mut status = hall.program.status().expect("it answers");
    // It has said nothing while the thief asked.
    hall.until("the victim is heard", || {
        victim.step();
        status = hall.program.status().expect("it answers");
        robot(&status, "amr-0").heard
    });
    assert!(victim.heard > 0 && victim.holds(), "{mode}");
    assert!(!victim.instances.contains(&66), "{mode}: it was commanded");
    let told = robot(&status, "amr-0");
    assert!(!told.is_doubled && told.doubled == 0, "{mode}: {told:?}");
}

#[test]
fn nobody_else_passes_for_the_mediator() {
    let hall = Hall::open();
    let trap = free_endpoint("tls");
    for party in ["amr-1", "anna"] {
        let identity = match party {
            "anna" => {
                let anna = contract::network::Party::Operator("anna".to_owned());
                hall.keys.issue(anna).expect("made")
            }
            robot => hall.identity(robot),
        };
        let thief = hall.lawless(&identity, "peer", &[&trap]);
        let everything = listen(&thief, "**");
        let mut settings = hall.settings_as(&hall.identity("amr-0"));
        settings.connect = vec![trap.clone()];
        let mut victim = Robot::new(settings, "amr-0");
        for number in 0..40 {
            victim.step();
            let key = keys::to_robot(PREFIX, "amr-0").expect("a plain name");
            thief
                .put(key, forged_order("amr-0", number))
                .wait()
                .expect("it sends");
            std::thread::sleep(Duration::from_millis(50));
        }
        assert_eq!(victim.heard, 0, "{party}");
        assert_eq!(everything.load(Ordering::Relaxed), 0, "{party}");
        thief.close().wait().expect("it closes");
    }
}
