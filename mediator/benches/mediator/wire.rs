//! Robots' end of the network: one session for all of them, as zenoh would share one between machines of a hall.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use contract::wire::{MediatorReport, RobotReport};
use contract::{Message, decode, keys};
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

const PREFIX: &str = "fleet";

pub struct Wire {
    // Before the session, so that they go first.
    publishers: BTreeMap<String, Publisher<'static>>,
    _session: zenoh::Session,
    inbox: Receiver<(Instant, MediatorReport)>,
}

impl Wire {
    pub fn new(session: zenoh::Session, robots: impl Iterator<Item = String>) -> Self {
        let (news, inbox) = channel();
        session
            .declare_subscriber(keys::to_all_robots(PREFIX).expect("a plain name"))
            .callback(move |sample| {
                let at = Instant::now();
                let message = decode(&sample.payload().to_bytes()).expect("a message");
                // After the end nobody listens.
                let _ = news.send((at, message));
            })
            .background()
            .wait()
            .expect("it subscribes");
        let publishers = robots.map(|robot| {
            let key = keys::report(PREFIX, &robot).expect("a plain name");
            let publisher = session.declare_publisher(key);
            let publisher = publisher
                .congestion_control(CongestionControl::Drop)
                .express(true)
                .wait();
            (robot, publisher.expect("it publishes"))
        });
        Self {
            publishers: publishers.collect(),
            _session: session,
            inbox,
        }
    }

    pub fn send(&self, report: &RobotReport) {
        let sent = self.publishers[&report.robot_id]
            .put(report.encode_to_vec())
            .wait();
        sent.expect("the session is open");
    }

    /// The next message and when it came.
    pub fn receive(&self, patience: Duration) -> Option<(Instant, MediatorReport)> {
        self.inbox.recv_timeout(patience).ok()
    }
}
