//! All sides of one robot together.

use std::collections::VecDeque;

use super::access::Claims;
use super::control::{Control, Order};
use super::revocation::Revocations;
use super::session::{Received, Session};
use super::situation::{ClientCounters, Situation};
use crate::floor::Floor;
use crate::wire::{self, Factsheet, MediatorReport, RobotReport, TakeUp};

/// A robot that is never registered fires outputs for ever.
const MOST_UNHEARD: usize = 64;

/// One robot's side of its protocols.
#[derive(Clone, Debug)]
pub struct Client {
    session: Session,
    claims: Claims,
    revocations: Revocations,
    control: Option<Control>,
    /// Of a coordination that is gone.
    last_order: Option<Order>,
    /// Outputs before the first registration: the coordination in which the process before was may wait for them.
    unheard: Option<VecDeque<String>>,
    situation: Situation,
    counters: ClientCounters,
}

impl Client {
    /// A robot that has just started. `boot_epoch` is drawn at random at each start.
    #[must_use]
    pub fn new(robot_id: &str, site: &str, boot_epoch: u64) -> Self {
        Self {
            session: Session::new(robot_id, site, boot_epoch),
            claims: Claims::new(),
            revocations: Revocations::new(),
            control: None,
            last_order: None,
            unheard: Some(VecDeque::new()),
            situation: Situation::default(),
            counters: ClientCounters::default(),
        }
    }

    /// The same, on this floor; without one it has no areas.
    #[must_use]
    pub fn on(mut self, floor: Floor) -> Self {
        self.session.floor = floor;
        self
    }

    /// The same, of this kind. Which protocols it knows, the client says.
    #[must_use]
    pub fn of_kind(mut self, factsheet: Factsheet) -> Self {
        self.session.factsheet = Some(factsheet);
        self
    }

    /// The same, for a robot whose state machine nobody else can step: no coordination takes it in.
    #[must_use]
    pub fn without_control(mut self) -> Self {
        self.session.without_control = true;
        self
    }

    /// Takes in a message of the mediator, however late, repeated or out of order it is.
    pub fn receive(&mut self, message: &MediatorReport, now_ns: u64) -> Received {
        let registration = self.session.registration();
        let received = self.session.receive(message, now_ns);
        let registers = match received {
            Received::News => {
                // Another mediator, which has heard of a process before this one, and of this one never: both have to mean the same
                // levels.
                let knows_another = self.session.registration() != registration
                    && self.claims.contradict(&message.access);
                if knows_another {
                    self.forget();
                }
                knows_another
            }
            Received::Registered => {
                // What the mediator knows of this robot holds; there is nothing else yet.
                self.forget();
                let release = { message.take_up.as_ref() }.and_then(|own| own.release.as_ref());
                self.last_order = release.map(Order::release);
                self.counters.let_go += u64::from(release.is_some());
                true
            }
            Received::Stale | Received::Other => {
                self.counters.stale += 1;
                return received;
            }
            Received::Refused => {
                if self.session.identity_taken {
                    // Whatever it had, another process has it.
                    self.forget();
                }
                return received;
            }
            Received::Version => return received,
            Received::Nonsense => {
                self.counters.nonsense += 1;
                return received;
            }
        };
        for grant in &message.access {
            let learned = if registers {
                self.claims.inherit(grant)
            } else {
                self.claims.learn(grant, &mut self.counters)
            };
            self.counters.bad_levels += u64::from(learned.is_err());
        }
        for revocation in &message.revocations {
            let learned = if registers {
                self.revocations.inherit(revocation)
            } else {
                self.revocations.learn(revocation)
            };
            self.counters.bad_levels += u64::from(learned.is_err());
        }
        self.learn_control(message.control.as_ref(), registers);
        for output in self.unheard.take().into_iter().flatten().rev() {
            self.output(&output);
        }
        received
    }

    fn forget(&mut self) {
        self.claims.forget();
        self.revocations.forget();
        self.control = None;
        self.last_order = None;
    }

    fn learn_control(&mut self, message: Option<&wire::Control>, registers: bool) {
        let present = self.control.as_ref().map_or(0, |own| own.coordination);
        let learned = match (message, &mut self.control) {
            (None, None) => Ok(()),
            (None, Some(control)) => {
                if let Some(order) = control.let_go() {
                    self.counters.let_go += 1;
                    self.last_order = Some(order);
                }
                self.control = None;
                Ok(())
            }
            (Some(message), Some(control)) if message.coordination == present => {
                control.learn(message)
            }
            (Some(message), _) if message.coordination > present => {
                Control::join(message, registers).map(|control| self.control = Some(control))
            }
            // A smaller one is over.
            (Some(_), _) => Ok(()),
        };
        self.counters.bad_levels += u64::from(learned.is_err());
    }

    /// The robot was given another pose than it had: what it has and does not stand in by that, it gives back.
    pub fn placed_anew(&mut self) {
        self.claims.doubt();
    }

    /// Sets the robot's flags by where it is and wants to be. Returns whether there is news to report.
    pub fn step(&mut self, situation: Situation, now_ns: u64, silent_after_ns: u64) -> bool {
        let mut news = self.situation.stands_in != situation.stands_in
            || self.situation.located != situation.located
            || self.situation.fsm_state != situation.fsm_state;
        news |= self.session.listen(now_ns, silent_after_ns);
        if situation.located && !self.situation.located {
            self.claims.doubt();
        }
        self.situation = situation;
        if !self.session.is_registered() {
            return news;
        }
        if let Some(control) = &mut self.control {
            news |= control.advance();
        }
        if !self.situation.located {
            return news;
        }
        let situation = &self.situation;
        let wanted = wanted(situation, self.control.as_mut(), &self.claims);
        news |= (self.revocations).answer(&mut self.claims, situation, &mut self.counters);
        news |= self.claims.follow(situation, &wanted);
        if !self.session.is_mediator_silent(now_ns, silent_after_ns) {
            news |= self.claims.request(&wanted);
        }
        news
    }

    /// The state machine has fired an output. Returns whether that sets a flag, which is to be reported; what it fires before the
    /// process is registered may set one then.
    pub fn output(&mut self, output: &str) -> bool {
        if let Some(unheard) = &mut self.unheard {
            unheard.truncate(MOST_UNHEARD - 1);
            unheard.push_front(output.to_owned());
        }
        { self.control.as_mut() }.is_some_and(|control| control.output(output))
    }

    /// The next order of the mediator, each handed out once. Take them before [`step`](Self::step): flags that say that an
    /// order was received are set only then.
    pub fn next_order(&mut self) -> Option<Order> {
        let order = self.last_order.take();
        let order = order.or_else(|| self.control.as_mut()?.next_order());
        self.counters.orders += u64::from(order.is_some());
        order
    }

    /// The mediator has the discrete control: the state machine does nothing by itself.
    #[must_use]
    pub fn is_acquired(&self) -> bool {
        self.control.as_ref().is_some_and(Control::is_acquired)
    }

    /// The coordination that the robot takes part in: its number, its net, and the flags set so far, for people.
    #[must_use]
    pub fn coordination(&self) -> Option<(u64, &str, String)> {
        let control = self.control.as_ref()?;
        Some((control.coordination, &control.net, control.describe()))
    }

    /// The next report to send; it counts as sent at the last [step](Self::step). Due on news, and every [`LEVEL_PERIOD_NS`](crate::timing::LEVEL_PERIOD_NS).
    pub fn report(&mut self) -> RobotReport {
        let head = self.session.next_report(self.situation.located);
        let (number, known) = (head.sequence, self.session.known());
        RobotReport {
            stands_in: self.situation.stands_in.clone(),
            located: self.situation.located,
            pose: self.situation.pose,
            fsm_state: self.situation.fsm_state.clone(),
            access: self.claims.report(number, known),
            revocations: self.revocations.report(number, known),
            control: self.control.as_ref().map(Control::report),
            ..head
        }
    }

    /// Whether the robot may be in the area: it was granted it, and stands in it or may enter it, by its lease, since it knows where
    /// it is, and since nobody has asked for it back.
    #[must_use]
    pub fn may_be_in(&self, area: &str, now_ns: u64) -> bool {
        let stands = || { self.situation.stands_in.iter() }.any(|other| other == area);
        // One that is lost, and found again elsewhere, gives back with its next step what it has by where it was thought to be.
        let may_enter = || {
            let located = self.situation.located;
            located && self.has_lease(now_ns) && !self.revocations.asks_for(area)
        };
        self.holds(area) && (stands() || may_enter())
    }

    /// Whether the robot may newly enter what it was granted: the mediator says that it has a report which was sent within
    /// [`LEASE_NS`](crate::timing::LEASE_NS), the process was registered [`LISTENS_FIRST_NS`](crate::timing::LISTENS_FIRST_NS) ago, and no
    /// other mediator is heard that grants.
    #[must_use]
    pub fn has_lease(&self, now_ns: u64) -> bool {
        self.session.has_lease(now_ns)
    }

    /// Whether the area was granted to the robot, and was neither given back nor taken away.
    #[must_use]
    pub fn holds(&self, area: &str) -> bool {
        self.claims.holds(area)
    }

    /// The same, or it was granted before the robot restarted, or was thought to be elsewhere: what it may be in of these already it keeps, as
    /// [`Situation::committed`]; what it is surely not in it gives back.
    #[must_use]
    pub fn may_hold(&self, area: &str) -> bool {
        self.claims.may_hold(area)
    }

    /// Areas that the robot waits for, each with the reason that the mediator gives.
    pub fn waiting(&self) -> impl Iterator<Item = (&str, &str)> {
        self.claims.waiting()
    }

    /// Epoch of the mediator's run that spoke last; 0 before it spoke.
    #[must_use]
    pub fn mediator_epoch(&self) -> u64 {
        self.session.mediator_epoch
    }

    /// The registration; 0 without one.
    #[must_use]
    pub fn session(&self) -> u64 {
        self.session.number
    }

    /// The mediator knows this boot of the robot.
    #[must_use]
    pub fn is_registered(&self) -> bool {
        self.session.is_registered()
    }

    /// Nothing was heard of the mediator for longer than `silent_after_ns`.
    #[must_use]
    pub fn is_mediator_silent(&self, now_ns: u64, silent_after_ns: u64) -> bool {
        self.session.is_mediator_silent(now_ns, silent_after_ns)
    }

    /// Why the mediator does not want this robot; empty when it does.
    #[must_use]
    pub fn refusal(&self) -> &str {
        &self.session.refusal
    }

    /// Another mediator than the one that the robot follows speaks to it; it is ignored.
    #[must_use]
    pub fn has_second_mediator(&self, now_ns: u64) -> bool {
        self.session.has_second_mediator(now_ns)
    }

    /// It is that another process speaks for this robot's identity: as after a quick restart, until the process before has been
    /// silent for a while; or because two robots have one identity.
    #[must_use]
    pub fn is_identity_taken(&self) -> bool {
        self.session.identity_taken
    }

    /// Another process reports with this robot's identity, and is refused.
    #[must_use]
    pub fn is_identity_doubled(&self) -> bool {
        self.session.identity_doubled
    }

    /// The role that the mediator knows for this robot.
    #[must_use]
    pub fn role(&self) -> &str {
        &self.session.role
    }

    /// Where this robot was and in which state, if it has restarted. Given once.
    pub fn take_up(&mut self) -> Option<TakeUp> {
        self.session.take_up.take()
    }

    /// Counts since the start.
    #[must_use]
    pub fn counters(&self) -> ClientCounters {
        self.counters
    }
}

/// What to ask for and to keep. Others decide about a robot that is acquired.
fn wanted<'a>(
    situation: &'a Situation,
    control: Option<&'a mut Control>,
    claims: &Claims,
) -> Vec<&'a str> {
    let own = situation.wanted.iter().chain(&situation.committed);
    let mut wanted = Vec::new();
    let mut want = |area: &'a String| {
        if !wanted.contains(&area.as_str()) {
            wanted.push(area.as_str());
        }
    };
    match control {
        Some(control) if control.is_acquired() => {
            // An area that was entered and left is not asked for again.
            let left: Vec<String> = { control.areas().iter() }
                .filter(|area| claims.is_entered(area) && !situation.stands_in.contains(area))
                .cloned()
                .collect();
            left.iter().for_each(|area| control.left(area));
            own.filter(|area| situation.needs(area)).for_each(&mut want);
            control.areas().iter().for_each(want);
        }
        _ => own.for_each(want),
    }
    wanted
}
