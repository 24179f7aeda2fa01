//! Certificates end, and are renewed before.

use std::time::{Duration, Instant};

use contract::wire::{CertificateAnswer, CertificateRequest};
use contract::{Message, decode, keys};
use zenoh::Wait;
use zenoh::handlers::FifoChannelHandler;
use zenoh::query::Reply;

use super::hall::{Hall, PREFIX, Robot};

const DAY_S: f64 = 86_400.0;
/// After that a question counts as lost.
const PATIENCE: Duration = Duration::from_secs(10);

fn renew(robot: &Robot, request: &str) -> Option<CertificateAnswer> {
    answer(&ask(robot, "amr-0", request))
}

fn ask(robot: &Robot, id: &str, request: &str) -> FifoChannelHandler<Reply> {
    let message = CertificateRequest {
        request_pem: request.to_owned(),
    };
    let key = keys::certificate(PREFIX, id).expect("a plain name");
    let get = robot.session.get(key).payload(message.encode_to_vec());
    get.timeout(PATIENCE).wait().expect("it asks")
}

fn answer(replies: &FifoChannelHandler<Reply>) -> Option<CertificateAnswer> {
    let reply = replies.recv().ok()?.into_result().ok()?;
    decode(&reply.payload().to_bytes()).ok()
}

#[test]
fn a_robot_gets_its_next_certificate_from_the_mediator() {
    let hall = Hall::open();
    let identity = hall.identity("amr-0");
    let mut amr_0 = Robot::new(hall.settings_as(&identity), "amr-0");
    hall.until_served("it is served", &mut amr_0);
    let request = identity.request().expect("made");
    let mut given = CertificateAnswer::default();
    // The mediator may open its network anew meanwhile: there is a new certificate. A robot asks again then.
    hall.until("it is answered", || {
        given = renew(&amr_0, request.pem()).unwrap_or_default();
        !given.certificate_pem.is_empty()
    });
    assert_eq!(given.refusal, "");
    assert_eq!(given.renew_after_s, 15 * 86_400);
    let next = request.answered(&given.certificate_pem).expect("it fits");

    hall.until("whoever asks twice in a second is refused", || {
        let soon = renew(&amr_0, identity.request().expect("made").pem());
        soon.is_some_and(|soon| soon.refusal.contains("one request in"))
    });
    let another = identity.request().expect("made");
    let other = ask(&amr_0, "amr-1", another.pem());
    // By then the one before it could have been answered, too.
    hall.until("it is answered for itself", || {
        renew(&amr_0, another.pem()).is_some()
    });
    assert_eq!(answer(&other), None, "of another robot");

    drop(amr_0);
    let mut amr_0 = Robot::new(hall.settings_as(&next), "amr-0");
    hall.until_served("the next one is served", &mut amr_0);
}

/// zenoh 1.10.2 loses such a link all the time where it reads and writes on two threads: see `contract::network`.
#[test]
fn a_link_on_which_both_talk_at_the_same_time_stays() {
    let hall = Hall::open();
    let identity = hall.identity("amr-0");
    let mut amr_0 = Robot::new(hall.settings_as(&identity), "amr-0");
    hall.until_served("it is served", &mut amr_0);
    let request = identity.request().expect("made");
    let mut unanswered = 0;
    for _ in 0..100 {
        amr_0.step();
        let asked: Vec<_> = (0..100)
            .map(|_| ask(&amr_0, "amr-0", request.pem()))
            .collect();
        let lost = asked.iter().filter(|replies| answer(replies).is_none());
        unanswered += usize::from(lost.count() > 0);
    }
    // The network opens anew once for the new certificate.
    assert!(unanswered <= 1, "{unanswered} of 100");
}

#[test]
fn a_certificate_that_has_ended_is_of_no_use() {
    // The mediator's own is made anew after half of that, each time.
    let lasts = Duration::from_secs(6);
    let hall = Hall::with_certificates_for(lasts.as_secs_f64() / DAY_S);
    let mut amr_0 = served(&hall, "it is served", lasts);
    std::thread::sleep(lasts);
    let mut last = amr_0.heard;
    hall.until("it hears nothing any more", || {
        for _ in 0..20 {
            amr_0.step();
            std::thread::sleep(Duration::from_millis(50));
        }
        std::mem::replace(&mut last, amr_0.heard) == amr_0.heard
    });
    served(&hall, "another file is of use", lasts);
}

/// A robot that has been served: with its next certificate where one was half over before that.
fn served(hall: &Hall, what: &str, lasts: Duration) -> Robot {
    let (mut issued, mut amr_0) = (Instant::now(), hall.robot("amr-0"));
    hall.until(what, || {
        if issued.elapsed() > lasts / 2 {
            (issued, amr_0) = (Instant::now(), hall.robot("amr-0"));
        }
        amr_0.step();
        amr_0.heard > 0
    });
    amr_0
}
