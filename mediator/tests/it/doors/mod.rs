//! Who gets in, and what those can do who do: the real program behind mutual TLS, and robots that break every rule.

mod hall;
mod idle;
mod intruders;
mod mediators;
mod operators;
mod renewals;

use std::os::unix::fs::PermissionsExt;
use std::time::Duration;

use contract::network::{Identity, NetworkSettings, Party};

use crate::program::{Program, folder};
use hall::{Hall, Robot, operator, robot};

/// Longer than any answer takes on a machine that has other things to do.
const PATIENCE: Duration = Duration::from_secs(20);

#[test]
fn robots_with_certificates_are_served() {
    let mut hall = Hall::open();
    let mut amr_0 = hall.robot("amr-0");
    let mut amr_1 = hall.robot("amr-1");
    hall.until("both hold their rooms", || {
        amr_0.step();
        amr_1.step();
        amr_0.holds() && amr_1.holds()
    });
    // A restart changes nothing, but for another certificate of the mediator.
    hall.program.kill();
    hall.program.start();
    hall.program.wait_ready(PATIENCE);
    let epoch = amr_0.epoch();
    hall.until("it is heard again", || {
        amr_0.step();
        amr_0.epoch() > epoch && amr_0.holds()
    });
}

#[test]
fn an_open_network_takes_a_word() {
    let folder = folder();
    let program = Program::new(folder.path(), &hall::site(), Vec::new());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let site = program.site_file().display().to_string();
    let (journal, run, keys) = (path("journal.redb"), path("run"), path("keys"));
    let refused = |more: &[&str]| {
        let mut arguments = vec![
            "run",
            "--first-start",
            "--site",
            &site,
            "--journal",
            &journal,
            "--runtime",
            &run,
        ];
        arguments.extend(more);
        let (code, text) = Program::command(&arguments);
        assert_eq!(code, Some(2), "{more:?}: {text}");
        text
    };
    for open in ["tcp/0.0.0.0:0", "tcp/[::]:0", "tcp/192.0.2.1:0"] {
        let text = refused(&["--listen", open]);
        assert!(text.contains(open) && text.contains("--insecure"), "{text}");
    }
    let text = refused(&["--listen", "tcp/127.0.0.1:0", "--scouting"]);
    assert!(text.contains("scouting"), "{text}");
    let text = refused(&["--listen", "tls/127.0.0.1:0", "--keys", &keys]);
    assert!(text.contains("mediator keys site"), "{text}");
    let (code, text) = Program::command(&["keys", "site", "--site", &site, "--keys", &keys]);
    assert_eq!(code, Some(0), "{text}");
    let text = refused(&["--listen", "tcp/127.0.0.1:0", "--keys", &keys]);
    assert!(text.contains("tls/"), "{text}");
}

#[test]
fn the_next_file_of_an_operator_takes_the_place_of_the_last_one_only_when_it_is_told_to() {
    let folder = folder();
    let program = Program::new(folder.path(), &hall::site(), Vec::new());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (site, keys, out) = (
        program.site_file().display().to_string(),
        path("keys"),
        path(""),
    );
    let make = |arguments: &[&str]| {
        let place = ["--site", &site, "--keys", &keys];
        Program::command(&[&["keys"], arguments, &place[..]].concat())
    };
    assert_eq!(make(&["site"]).0, Some(0));
    let file = || std::fs::read_to_string(folder.path().join("anna.pem")).expect("it is there");
    let operator = ["operator", "anna", "--out", &out];
    assert_eq!(make(&operator).0, Some(0));
    let first = file();
    let (code, text) = make(&operator);
    assert!(
        code == Some(2) && text.contains("--replace"),
        "{code:?} {text}"
    );
    assert_eq!(file(), first);
    let (code, text) = make(&[&operator[..], &["--replace"]].concat());
    assert_eq!(code, Some(0), "{text}");
    let next = file();
    assert_ne!(next, first);
    assert!(Identity::parse(&next).is_ok());
    let mode = folder.path().join("anna.pem").metadata();
    assert_eq!(
        mode.expect("it is there").permissions().mode() & 0o777,
        0o600
    );
    assert!(!folder.path().join("anna.pem.new").exists());
}

#[test]
fn a_mediator_that_is_told_to_be_open_says_so() {
    let folder = folder();
    let mut program = Program::new(folder.path(), &hall::site(), Vec::new());
    program.add(&["--insecure"]);
    program.start();
    program.wait_ready(PATIENCE);
    let log = program.log();
    assert!(log.contains("--insecure: no certificates"), "{log}");
}

#[test]
fn whoever_is_revoked_is_cut_off_and_let_in_again_with_another_file() {
    let hall = Hall::open();
    let (mut amr_0, mut amr_1) = (hall.robot("amr-0"), hall.robot("amr-1"));
    hall.until("both hold their rooms", || {
        amr_0.step();
        amr_1.step();
        amr_0.holds() && amr_1.holds()
    });
    hall.keys
        .revoke(&Party::Robot("amr-0".to_owned()))
        .expect("revoked");
    hall.until("amr-0 is silent, amr-1 is heard", || {
        amr_0.step();
        amr_1.step();
        let status = hall.program.status().expect("it answers");
        !robot(&status, "amr-0").heard && robot(&status, "amr-1").heard
    });
    let last = amr_0.heard;
    let mut again = hall.robot("amr-0");
    hall.until("its next file lets it in", || {
        amr_0.step();
        amr_1.step();
        again.step();
        again.heard > 0
    });
    assert_eq!(amr_0.heard, last, "the old one hears nothing");
}

#[test]
fn nobody_gets_in_without_a_certificate_of_the_site() {
    let hall = Hall::open();
    let elsewhere = Hall::open();
    let mut stranger = Robot::new(hall.settings_as(&elsewhere.identity("amr-0")), "amr-0");
    let plain = NetworkSettings {
        connect: vec![hall.endpoint.replace("tls/", "tcp/")],
        ..NetworkSettings::default()
    };
    let mut plain = Robot::new(plain, "amr-1");
    for _ in 0..30 {
        stranger.step();
        plain.step();
        std::thread::sleep(Duration::from_millis(100));
    }
    assert_eq!((stranger.heard, plain.heard), (0, 0));
    assert!(!stranger.is_linked() && !plain.is_linked());
    let status = hall.program.status().expect("it answers");
    for id in ["amr-0", "amr-1"] {
        assert!(!robot(&status, id).reports, "{id}");
    }
    // Its own file does.
    let mut amr_0 = hall.robot("amr-0");
    hall.until_served("amr-0 is served", &mut amr_0);
    let _ = operator(&hall, "anna");
}
