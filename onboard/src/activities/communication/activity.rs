//! The activity: its event loop, and what it publishes to everybody.

use std::time::Duration;

use contract::Message;
use contract::timing::LEVEL_PERIOD_NS;
use contract::wire::RobotState;
use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};

use super::credentials::Attention;
use super::hearing::Hearing;
use super::membership::{Membership, MembershipSetup};
use super::network::{Inbox, OpenSession, Session};
use super::settings::Settings;
use super::state::{self, Snapshot};
use crate::activities::news::News;
use crate::activities::port::Port;
use crate::activities::robot_activity::RobotActivity;
use crate::realtime::clock::SECOND_NS;
use crate::realtime::log::{Complaints, LogSender};
use crate::symbols::faults::Fault;
use crate::symbols::wiring::{CommunicationFleetSymbols, CommunicationSymbols};

/// Period of the event loop while there is no news.
pub const PERIOD: Duration = Duration::from_millis(50);
/// Pause between two attempts to open the network.
const RETRY_NS: u64 = SECOND_NS;
/// A session in place of another one that has no link after this time is given up.
const LINKED_WITHIN_NS: u64 = 30 * SECOND_NS;

/// The activity.
pub struct Communication {
    port: Port,
    settings: Settings,
    symbols: CommunicationSymbols,
    log: LogSender,
    news: News,
    membership: Membership,
    open_session: OpenSession,
    session: Option<Box<dyn Session>>,
    /// Takes over when it is linked, or is given up then.
    successor: Option<(Box<dyn Session>, u64)>,
    session_complaints: Complaints,
    hearing: Hearing,
    snapshot: Snapshot,
    /// Nobody knows where the robot is, says the supervisor.
    lost: bool,
    sequence: u64,
    sent: Option<RobotState>,
    sent_ns: u64,
    retry_ns: u64,
    complaints: Complaints,
}

impl Communication {
    /// An activity in state *created*. `news` wakes its thread; `fleet` is given on a managed site.
    #[must_use]
    pub fn new(
        port: Port,
        settings: Settings,
        symbols: (CommunicationSymbols, CommunicationFleetSymbols),
        open_session: OpenSession,
        (log, news): (LogSender, News),
        fleet: Option<MembershipSetup>,
        now_ns: u64,
    ) -> Self {
        let (symbols, fleet_symbols) = symbols;
        Self {
            port,
            settings,
            symbols,
            log,
            news,
            membership: Membership::new(fleet_symbols, fleet, now_ns),
            open_session,
            session: None,
            successor: None,
            session_complaints: Complaints::default(),
            hearing: Hearing::new(now_ns),
            snapshot: Snapshot::default(),
            lost: false,
            sequence: 0,
            sent: None,
            sent_ns: 0,
            retry_ns: 0,
            complaints: Complaints::default(),
        }
    }

    /// One attempt to open the network. Called once before any thread is promoted, so that zenoh's threads inherit no
    /// real-time priority, and again after failures.
    pub fn open_network(&mut self, now_ns: u64) {
        self.retry_ns = now_ns + RETRY_NS;
        match self.open() {
            Ok(session) => {
                self.log
                    .info(format!("fleet network is open, session {}", session.id()));
                self.session = Some(session);
                self.complaints.forget();
                self.port.clear(Fault::FleetNetwork);
            }
            Err(complaint) => {
                self.complaints
                    .say(&self.log, "fleet network cannot be opened", complaint);
                self.port.raise(Fault::FleetNetwork, 0.0);
            }
        }
    }

    fn open(&mut self) -> Result<Box<dyn Session>, String> {
        let inbox = self.membership.mailbox().map(|mailbox| Inbox {
            mailbox,
            news: self.news.clone(),
        });
        (self.open_session)(inbox)
    }

    /// Looks after the session: its certificate, and whether the mediator is heard over it. Another one takes over when it has its
    /// link: the mediator hears the robot all the time.
    fn attend_session(&mut self, now_ns: u64) {
        let complaint = match self.successor.take() {
            Some((successor, _)) if successor.is_linked() => {
                let id = successor.id();
                self.log.info(format!("session {id} takes over"));
                self.session = Some(successor);
                return;
            }
            Some((successor, until_ns)) if now_ns < until_ns => {
                self.successor = Some((successor, until_ns));
                return;
            }
            Some(_) => "another session has no link; the one before goes on".to_owned(),
            None => match self.attention(now_ns) {
                Attention::None => return,
                Attention::Complain(why) => why,
                Attention::Replace(why) => match self.open() {
                    Ok(successor) => {
                        self.log.info(format!("fleet network: {why}"));
                        self.session_complaints.forget();
                        self.successor = Some((successor, now_ns + LINKED_WITHIN_NS));
                        return;
                    }
                    Err(why) => why,
                },
            },
        };
        self.session_complaints
            .say(&self.log, "fleet network", complaint);
    }

    /// What is to be done about the session.
    fn attention(&mut self, now_ns: u64) -> Attention {
        let Some(session) = &mut self.session else {
            return Attention::None;
        };
        let attention = session.attend(now_ns);
        let Some(heard) = self.membership.received() else {
            return attention;
        };
        let is_in_vain = self
            .hearing
            .is_in_vain(heard, || session.is_linked(), now_ns);
        if attention == Attention::None && is_in_vain {
            return Attention::Replace(
                "nothing is heard of the mediator over a link that lives; trying another session",
            );
        }
        attention
    }

    fn retry_network(&mut self, now_ns: u64) {
        if self.session.is_none() && now_ns >= self.retry_ns {
            self.port.step(LifeCycleEvent::Fault); // back to configuring, for the next attempt
        }
    }

    fn publish_state(&mut self, now_ns: u64) {
        let Some(session) = &self.session else {
            return;
        };
        let Settings {
            robot_id,
            role,
            boot_epoch,
            ..
        } = &self.settings;
        let mut state = state::message(&self.snapshot, robot_id, role, *boot_epoch);
        let changed = { self.sent.as_ref() }.is_none_or(|sent| state::is_news(sent, &state));
        if !changed && now_ns < self.sent_ns + LEVEL_PERIOD_NS {
            return;
        }
        self.sequence += 1;
        state.sequence = self.sequence;
        for fault in &mut state.faults {
            fault.age_ms = state::age_ms(&self.snapshot.faults, &fault.name, now_ns);
        }
        let sent = session.send_state(state.encode_to_vec());
        self.judge(sent, "the state");
        self.sent = Some(state);
        self.sent_ns = now_ns;
    }

    fn judge(&mut self, sent: Result<(), String>, what: &str) {
        match sent {
            Ok(()) => {
                self.complaints.forget();
                self.port.clear(Fault::FleetNetwork);
            }
            Err(error) => {
                self.complaints
                    .say(&self.log, &format!("{what} could not be published"), error);
                self.port.raise(Fault::FleetNetwork, 0.0);
            }
        }
    }

    /// Navigation first, then the mediator, then everybody.
    fn speak(&mut self, now_ns: u64) {
        let session = self.session.as_deref();
        let sent = self.membership.speak(session, &self.log, now_ns);
        if sent.is_err() {
            self.judge(sent, "the report to the mediator");
        }
        let troubles = self.membership.troubles(&self.log, now_ns);
        self.port.set(Fault::MediatorSilent, troubles.silent, 0.0);
        self.port.set(Fault::MediatorRefused, troubles.refused, 0.0);
        self.port.set(Fault::IdentityDoubled, troubles.doubled, 0.0);
        self.port
            .set(Fault::SecondMediator, troubles.second_mediator, 0.0);
        self.port.set(Fault::PlaceUnknown, troubles.lost, 0.0);
    }
}

impl Activity for Communication {
    fn name(&self) -> &'static str {
        "communication"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, now_ns: u64) {
        let mode = self.symbols.mode.read().value;
        self.snapshot = Snapshot {
            pose: self.symbols.pose.read(),
            odometry: self.symbols.odometry.read().value,
            navigation: self.symbols.navigation.read().value,
            faults: self.symbols.faults.read().value,
            mode: mode.mode,
            drive: self.symbols.drive.read().value,
            load: self.symbols.load.read().value,
        };
        // By the change alone: navigation may say where it was put before the supervisor says that it is lost no more.
        let was_lost = std::mem::replace(&mut self.lost, mode.lost != 0);
        if self.lost && !was_lost {
            self.membership.lose_place();
        }
        self.membership
            .listen(self.snapshot.odometry.twist.v_m_s, now_ns);
    }

    fn coordinate(&mut self, _now_ns: u64) {
        // Nothing is asked of it.
        while self.port.next_command().is_some() {}
    }

    fn configure(&mut self, now_ns: u64) {
        if self.session.is_none() {
            if now_ns < self.retry_ns {
                return;
            }
            self.open_network(now_ns);
        }
        // A robot without its fleet still drives where nothing needs granting.
        self.port.step(LifeCycleEvent::Configured);
    }

    fn compute(&mut self, now_ns: u64) {
        self.retry_network(now_ns);
        self.attend_session(now_ns);
        self.membership.step(now_ns);
    }

    fn rest(&mut self, now_ns: u64) {
        if self.port.state() == LifeCycleState::Ready {
            self.retry_network(now_ns);
        }
        self.attend_session(now_ns);
        // A paused robot still occupies floor.
        self.membership.step(now_ns);
    }

    fn communicate_out(&mut self, now_ns: u64) {
        if self.port.state() == LifeCycleState::Stopped {
            self.membership.leave(now_ns);
            (self.session, self.successor) = (None, None);
        } else {
            self.speak(now_ns);
        }
        self.publish_state(now_ns);
        self.port.publish(now_ns);
    }
}

impl RobotActivity for Communication {}
