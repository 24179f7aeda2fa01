//! Robots' end of the network: one session for all of them, as zenoh would share one between machines of a hall.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use contract::wire::{MediatorReport, RobotReport};
use contract::{Message, decode, keys};
use onboard::cli::Failure;
use sim::rt::monotonic_ns;
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

/// Sends the reports of robots and hears the mediator's.
pub(super) struct Wire {
    // Before the session, so that they go first.
    publishers: BTreeMap<String, Publisher<'static>>,
    _session: zenoh::Session,
    inbox: Receiver<(u64, MediatorReport)>,
}

impl Wire {
    /// For these robots, under this prefix.
    ///
    /// # Errors
    /// [`Failure`] with what zenoh says.
    pub(super) fn new(
        session: zenoh::Session,
        prefix: &str,
        robots: &[&str],
    ) -> Result<Self, Failure> {
        let (news, inbox) = channel();
        let key = keys::to_all_robots(prefix).map_err(Failure::failed)?;
        { session.declare_subscriber(key) }
            .callback(move |sample| {
                let at_ns = monotonic_ns();
                if let Ok(message) = decode(&sample.payload().to_bytes()) {
                    // After the end nobody listens.
                    let _ = news.send((at_ns, message));
                }
            })
            .background()
            .wait()
            .map_err(Failure::failed)?;
        let mut publishers = BTreeMap::new();
        for robot in robots {
            let key = keys::report(prefix, robot).map_err(Failure::failed)?;
            let publisher = session.declare_publisher(key);
            let publisher = publisher
                .congestion_control(CongestionControl::Drop)
                .express(true)
                .wait();
            publishers.insert((*robot).to_owned(), publisher.map_err(Failure::failed)?);
        }
        Ok(Self {
            publishers,
            _session: session,
            inbox,
        })
    }

    /// Sends it, if its robot is one of these.
    ///
    /// # Errors
    /// [`Failure`] with what zenoh says.
    pub(super) fn send(&self, report: &RobotReport) -> Result<(), Failure> {
        let Some(publisher) = self.publishers.get(&report.robot_id) else {
            return Ok(());
        };
        let sent = publisher.put(report.encode_to_vec()).wait();
        sent.map_err(Failure::failed)
    }

    /// The next message and when it came, on the monotonic clock.
    pub(super) fn receive(&self, patience: Duration) -> Option<(u64, MediatorReport)> {
        self.inbox.recv_timeout(patience).ok()
    }
}
