use std::os::unix::fs::PermissionsExt;

use contract::wire::CertificateRequest;

use super::renewals::Renewals;
use super::*;

fn site() -> (tempfile::TempDir, Keys) {
    let folder = tempfile::tempdir().expect("a folder");
    let keys = Keys::new(folder.path().join("keys"));
    keys.begin("hall", 30.0).expect("it begins");
    (folder, keys)
}

fn robot(id: &str) -> Party {
    Party::Robot(id.to_owned())
}

#[test]
fn an_identity_is_read_as_it_was_made() {
    let (_folder, keys) = site();
    let made = keys.issue(robot("amr-1")).expect("made");
    let read = Identity::parse(&made.to_pem()).expect("read");
    assert_eq!(read, made);
    assert_eq!(read.name().to_string(), "robots/amr-1/1");
    let left_s = read.expires_unix_s() - time::OffsetDateTime::now_utc().unix_timestamp();
    assert!(
        (30 * 86_400 - 60..=30 * 86_400).contains(&left_s),
        "{left_s}"
    );
    let operator = keys
        .issue(Party::Operator("anna".to_owned()))
        .expect("made");
    assert_eq!(operator.name().to_string(), "operators/anna/1");
    assert!(
        !format!("{made:?}").contains("PRIVATE"),
        "a key is no text for logs"
    );
}

#[test]
fn pieces_of_two_identities_make_none() {
    let (_folder, keys) = site();
    let pem = |id| keys.issue(robot(id)).expect("made").to_pem();
    let (one, two) = (pem("amr-1"), pem("amr-2"));
    let (_other_folder, other) = site();
    let stranger = other.issue(robot("amr-1")).expect("made").to_pem();
    let block = |text: &str, number: usize| {
        let parts: Vec<&str> = text.split_inclusive("-----END ").collect();
        // Each block, from its BEGIN to its END line.
        let all: Vec<String> = text
            .split("-----BEGIN ")
            .skip(1)
            .map(|rest| format!("-----BEGIN {rest}"))
            .collect();
        assert_eq!(parts.len(), 4);
        all[number].clone()
    };
    let of = |key: &str, own: &str, root: &str| {
        Identity::parse(&format!(
            "{}{}{}",
            block(key, 0),
            block(own, 1),
            block(root, 2)
        ))
    };
    of(&one, &one, &one).expect("whole");
    let why = of(&two, &one, &one).expect_err("another key");
    assert!(why.contains("not of its key"), "{why}");
    let why = of(&one, &one, &stranger).expect_err("another site");
    assert!(why.contains("not of its authority"), "{why}");
    let why = Identity::parse(&one[..one.len() / 2]).expect_err("cut off");
    assert!(why.contains("PEM blocks"), "{why}");
}

#[test]
fn a_revoked_name_counts_no_more_and_its_next_generation_does() {
    let (_folder, keys) = site();
    let first = keys.issue(robot("amr-1")).expect("made");
    keys.issue(robot("amr-2")).expect("made");
    let again = keys.issue(robot("amr-1")).expect("made");
    assert_eq!(first.name(), again.name(), "both count");
    keys.revoke(&robot("amr-1")).expect("revoked");
    let names = |keys: &Keys| -> Vec<String> {
        let registry = keys.registry().expect("read");
        registry.names().iter().map(ToString::to_string).collect()
    };
    assert_eq!(names(&keys), ["robots/amr-2/1"]);
    keys.revoke(&robot("amr-1")).expect_err("only once");
    keys.revoke(&robot("amr-7")).expect_err("it has none");
    keys.issue(robot("amr-1")).expect("made");
    assert_eq!(names(&keys), ["robots/amr-1/2", "robots/amr-2/1"]);
}

#[test]
fn who_asks_for_certificates_again_and_again_is_refused_also_where_it_asks_for_nothing() {
    let (_folder, keys) = site();
    let identity = keys.issue(robot("amr-1")).expect("made");
    keys.issue(robot("amr-2")).expect("made");
    let mut renewals = Renewals::new(keys.snapshot().expect("read"));
    let mut asks = |robot: &str, pem: &str| {
        let request_pem = pem.to_owned();
        renewals
            .answer(robot, &CertificateRequest { request_pem })
            .refusal
    };
    let early = "expected one request in";
    assert!(!asks("amr-1", "nonsense").starts_with(early));
    let good = identity.request().expect("asked");
    assert!(asks("amr-1", good.pem()).starts_with(early));
    assert!(asks("amr-1", "nonsense").starts_with(early));
    assert!(
        !asks("amr-2", "nonsense").starts_with(early),
        "another robot"
    );
    assert!(renewals.is_news("amr-1") && !renewals.is_news("amr-1"));
    assert!(renewals.is_news("amr-2"));
}

#[test]
fn a_certificate_is_renewed_without_its_key_leaving_the_robot() {
    let (_folder, keys) = site();
    let identity = keys.issue(robot("amr-1")).expect("made");
    let snapshot = keys.snapshot().expect("read");
    let request = identity.request().expect("asked");
    assert!(!request.pem().contains("PRIVATE"));
    let answer = snapshot
        .certificate("amr-1", request.pem())
        .expect("signed");
    let renewed = request.answered(&answer).expect("accepted");
    assert_eq!(renewed.name(), identity.name());
    assert_ne!(renewed.to_pem(), identity.to_pem());

    // For another key, of another robot, of another authority: refused by the robot.
    let other = identity.request().expect("asked");
    other.answered(&answer).expect_err("another key");
    keys.issue(robot("amr-2")).expect("made");
    let request = identity.request().expect("asked");
    let snapshot = keys.snapshot().expect("read");
    let theirs = snapshot
        .certificate("amr-2", request.pem())
        .expect("signed");
    let why = request.answered(&theirs).expect_err("another name");
    assert!(why.contains("amr-2"), "{why}");
    let (_other_folder, stranger) = site();
    stranger.issue(robot("amr-1")).expect("made");
    let request = identity.request().expect("asked");
    let forged = { stranger.snapshot().expect("read") }
        .certificate("amr-1", request.pem())
        .expect("signed");
    request.answered(&forged).expect_err("another authority");

    // The mediator refuses what is no request, and whoever was revoked. One who is cut off in a moment gets nothing of use.
    assert!(snapshot.certificate("amr-1", "nonsense").is_err());
    assert!(
        snapshot
            .certificate("amr-7", identity.request().expect("asked").pem())
            .is_err()
    );
    keys.revoke(&robot("amr-1")).expect("revoked");
    keys.issue(robot("amr-1")).expect("made");
    let thief = identity.request().expect("asked");
    let late = snapshot
        .certificate("amr-1", thief.pem())
        .expect("signed, by what was known");
    assert_eq!(thief.answered(&late).expect("whole").name().generation, 1);
}

#[test]
fn what_cannot_be_is_refused_by_a_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let keys = Keys::new(folder.path().join("keys"));
    for days in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let why = keys.begin("hall", days).expect_err("days");
        assert!(why.contains("days") && !keys.exist(), "{why}");
    }
    let why = keys.issue(robot("amr-1")).expect_err("no authority");
    assert!(why.contains("keys"), "{why}");
    keys.begin("hall", 30.0).expect("it begins");
    let why = keys.begin("hall", 30.0).expect_err("twice");
    assert!(why.contains("already"), "{why}");
    for name in ["", "a b", "a/b", "*", &"x".repeat(60)] {
        let why = keys.issue(robot(name)).expect_err(name);
        assert!(why.contains("expected letters"), "{why}");
    }
    keys.issue(Party::Mediator).expect_err("it makes its own");
    let list = keys.folder().join(files::REGISTRY);
    std::fs::write(&list, "days = 0.0\n").expect("written");
    let why = keys.issue(robot("amr-1")).expect_err("days");
    assert!(
        why.contains("identities.toml") && why.contains("days"),
        "{why}"
    );
    std::fs::write(&list, "days = 1.0\nrobot = 3\n").expect("written");
    let why = keys.registry().expect_err("an unknown key");
    assert!(
        why.contains("identities.toml") && why.contains("robot"),
        "{why}"
    );
}

#[test]
fn only_their_owner_reads_the_files() {
    let (_folder, keys) = site();
    keys.issue(robot("amr-1")).expect("made");
    let mode = |path: &Path| std::fs::metadata(path).expect("there").permissions().mode() & 0o777;
    assert_eq!(mode(keys.folder()), 0o700);
    for file in std::fs::read_dir(keys.folder()).expect("read") {
        let path = file.expect("a file").path();
        assert_eq!(mode(&path), 0o600, "{}", path.display());
    }
}
