//! The robot as a member of a fleet: what it tells the mediator, and what the mediator's answers let it do.

use std::collections::VecDeque;

use contract::client::{Client, Received, Situation};
use contract::timing::{ENTERS_NO_MORE_NS, LEVEL_PERIOD_NS};
use contract::wire::{MediatorReport, RobotReport, TakeUp};
use description::areas::AreaIndex;
use skills::borders::AreaSet;
use skills::navigator::Instructed;

use super::floor::{Floor, Touch};
use super::needs::Needs;
use super::orders::{Directive, Orders};
use super::origin::Resume;
use super::sense::{Sense, Troubles};
use super::setup::{Began, Setup};
use crate::symbols::values::{FleetState, Line};

/// What is known of where the robot was before its process started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// The mediator has not said.
    Unknown,
    /// Navigation is told to go on.
    Resuming,
    /// Nobody knows: an operator must say where it stands.
    Lost,
    /// Navigation's pose is the robot's.
    Known,
}

/// The robot's side of the mediator, without network, clock or threads.
#[derive(Clone, Debug)]
pub struct Member {
    setup: Setup,
    floor: Floor,
    client: Client,
    orders: Orders,
    directives: VecDeque<Directive>,
    complaints: VecDeque<String>,
    began_ns: u64,
    origin: Origin,
    /// Why its messages are not understood, while they are not.
    other_version: Option<String>,
    /// Since when another process speaks for this identity, while one does.
    taken_ns: Option<u64>,
    /// Since when the mediator does not hear it, though it knows where it is and is registered.
    unheard_since_ns: Option<u64>,
    was_acquired: bool,
    /// Areas that the robot stands in; none while it does not know where it is.
    stands_in: Option<AreaSet>,
    wanted: AreaSet,
    allowed: AreaSet,
    news: bool,
    reported_ns: Option<u64>,
}

impl Member {
    /// A robot that has just started.
    #[must_use]
    pub fn new(setup: Setup, now_ns: u64) -> Self {
        Self {
            floor: Floor::new(&setup),
            client: Client::new(&setup.robot_id, &setup.site, setup.boot_epoch)
                .on(setup.floor.clone())
                .of_kind(setup.factsheet.clone()),
            setup,
            orders: Orders::default(),
            directives: VecDeque::new(),
            complaints: VecDeque::new(),
            began_ns: now_ns,
            origin: Origin::Unknown,
            other_version: None,
            taken_ns: None,
            unheard_since_ns: None,
            was_acquired: false,
            stands_in: None,
            wanted: AreaSet::EMPTY,
            allowed: AreaSet::EMPTY,
            news: true,
            reported_ns: None,
        }
    }

    /// Takes in a message of the mediator.
    pub fn receive(&mut self, message: &MediatorReport, now_ns: u64) {
        let known = (self.client.mediator_epoch(), self.client.session());
        let received = self.client.receive(message, now_ns);
        match received {
            Received::Stale | Received::Other => return,
            Received::Version => {
                let theirs = contract::Version::from(message.version);
                let refused = contract::VERSION.accept(theirs);
                self.other_version = refused.err().map(|error| error.to_string());
                return;
            }
            Received::Nonsense => {
                // Once: there may be any number of them.
                if self.client.counters().nonsense == 1 {
                    self.complain(format!(
                        "a message in the mediator's name has instance {:x}, journal {:x} and epoch {}, which no mediator has: somebody else sends under its key; ignored and counted",
                        message.instance, message.journal, message.mediator_epoch
                    ));
                }
                return;
            }
            Received::Refused => {
                let taken = self.client.is_identity_taken();
                self.taken_ns = taken.then(|| self.taken_ns.unwrap_or(now_ns));
                self.news |= known.0 != self.client.mediator_epoch();
                return;
            }
            Received::Registered | Received::News => {}
        }
        self.other_version = None;
        self.taken_ns = None;
        // The mediator waits for both numbers.
        self.news |= known != (self.client.mediator_epoch(), self.client.session());
        let take_up = self.client.take_up();
        if received == Received::Registered && self.origin == Origin::Unknown {
            self.go_on_from(take_up.as_ref());
        }
    }

    /// A restarted robot resumes where it ended, if the mediator knew it there.
    fn go_on_from(&mut self, take_up: Option<&TakeUp>) {
        match self.setup.resume(take_up) {
            Resume::Here => self.origin = Origin::Known,
            Resume::There { state, why } => {
                self.complain(why);
                self.origin = state.map_or(Origin::Known, |_| Origin::Resuming);
                self.directives.extend(state.map(Directive::Resume));
            }
            Resume::Nowhere { why } => {
                self.complaints.extend(why);
                self.origin = Origin::Lost;
            }
        }
    }

    /// Navigation goes on, by [`Directive::Resume`], or was put somewhere by an operator, and what it says from now on is so.
    pub fn relocated(&mut self) {
        self.origin = Origin::Known;
        self.client.placed_anew();
    }

    /// Where the robot was is not known any more: an operator must say where it stands.
    pub fn lose_place(&mut self) {
        match self.origin {
            // The mediator has not said what it knows: then that does not count.
            Origin::Unknown => self.setup.began = Began::Lost,
            Origin::Resuming | Origin::Known | Origin::Lost => self.origin = Origin::Lost,
        }
    }

    /// What navigation says to [`Directive::Instruct`].
    pub fn answered(&mut self, answer: Instructed) {
        self.orders.answered(answer);
    }

    /// The robot's machine has fired an output.
    pub fn output(&mut self, output: &str) {
        self.news |= self.client.output(output);
    }

    /// One step: sets the robot's flags by where it is and is going to be.
    pub fn step(&mut self, sense: &Sense, now_ns: u64) {
        let place = sense.place.filter(|_| self.origin == Origin::Known);
        let touches: Vec<Touch> = match &place {
            Some(place) => { self.setup.area_indices() }
                .map(|area| self.floor.touch(area, place))
                .collect(),
            None => vec![Touch::Clear; self.setup.areas.len()],
        };
        let unheard = self.client.is_registered() && place.is_some();
        let unheard = unheard && !self.client.has_lease(now_ns);
        let since_ns = self.unheard_since_ns.unwrap_or(now_ns);
        self.unheard_since_ns = unheard.then_some(since_ns);
        let stood_in = self.stands_in.unwrap_or(AreaSet::ALL);
        let stands_in: AreaSet = { self.setup.area_indices().zip(&touches) }
            .filter(|&(area, &touch)| {
                touch == Touch::Body
                    || touch >= Touch::Near && stood_in.contains(area) && self.holds(area)
            })
            .map(|(area, _)| area)
            .collect();
        let left = self.stands_in.unwrap_or_default().difference(&stands_in);
        self.stands_in = place.map(|_| stands_in);
        let needs = Needs {
            setup: &self.setup,
            floor: &self.floor,
            held: self.areas(Client::holds),
            may_hold: self.areas(Client::may_hold),
            wanted: self.wanted,
        };
        let (wanted, held_back) = match &place {
            Some(place) => needs.wanted(sense, place, &stands_in),
            None => (Vec::new(), AreaSet::EMPTY),
        };
        self.wanted = wanted.iter().copied().collect();
        let committed = place.map_or(AreaSet::EMPTY, |place| {
            // What it has just left lies behind, unless it wants it: then its pose may only have moved.
            let behind = left.difference(&self.wanted);
            needs.committed(&place, sense.speed_m_s).difference(&behind)
        });
        let situation = Situation {
            located: place.is_some(),
            stands_in: self.ids(stands_in.iter()),
            wanted: self.ids(wanted.into_iter()),
            committed: self.ids(committed.iter()),
            pose: sense.pose,
            fsm_state: { sense.state.and_then(|state| self.setup.states.get(state)) }
                .map_or(String::new(), |state| state.name.clone()),
        };
        let silent_after_ns = self.setup.silent_after_ns;
        self.news |= self.client.step(situation, now_ns, silent_after_ns);
        let acquired = self.client.is_acquired();
        // Who looks at an area that a robot without a lease has left sees it empty, however near the robot is, and it stays empty.
        let has_lease = self.client.has_lease(now_ns);
        self.allowed = { self.setup.area_indices().zip(&touches) }
            // A robot that does not know where it is may stand outside the areas that it holds.
            .filter(|&(area, _)| self.origin == Origin::Known && self.may_be_in(area, now_ns))
            .filter(|&(_, &touch)| has_lease || touch == Touch::Body)
            .map(|(area, _)| area)
            .filter(|&area| acquired || stands_in.contains(area) || !held_back.contains(area))
            .collect();
        self.give_orders(sense.state, now_ns);
    }

    fn give_orders(&mut self, state: Option<usize>, now_ns: u64) {
        while let Some(order) = self.client.next_order() {
            self.orders.add(order);
        }
        let acquired = self.client.is_acquired();
        if std::mem::replace(&mut self.was_acquired, acquired) && !acquired {
            let directive = self.orders.released();
            self.directives.extend(directive);
        }
        // Until it is relocated, the state of its machine says nothing.
        if self.origin != Origin::Known {
            return;
        }
        let state = state.and_then(|state| self.setup.states.get(state));
        // One at a time: directives do not pile up while navigation takes none.
        while self.directives.is_empty()
            && let Some(directive) = self.orders.next(state, now_ns)
        {
            self.directives.push_back(directive);
        }
        while let Some(complaint) = self.orders.next_complaint() {
            self.complain(complaint);
        }
    }

    fn may_be_in(&self, area: AreaIndex, now_ns: u64) -> bool {
        let area = self.setup.areas.get(area.place());
        area.is_some_and(|area| self.client.may_be_in(&area.id, now_ns))
    }

    fn holds(&self, area: AreaIndex) -> bool {
        let area = self.setup.areas.get(area.place());
        area.is_some_and(|area| self.client.holds(&area.id))
    }

    fn areas(&self, are: impl Fn(&Client, &str) -> bool) -> AreaSet {
        let all = self.setup.area_indices().zip(&self.setup.areas);
        all.filter(|(_, area)| are(&self.client, &area.id))
            .map(|(area, _)| area)
            .collect()
    }

    fn ids(&self, areas: impl Iterator<Item = AreaIndex>) -> Vec<String> {
        areas
            .filter_map(|area| self.setup.areas.get(area.place()))
            .map(|area| area.id.clone())
            .collect()
    }

    /// Areas that navigation may let the robot be in. Tell navigation before the next report goes out: areas given back in
    /// it may be granted to another robot at once.
    #[must_use]
    pub fn allowed(&self) -> AreaSet {
        self.allowed
    }

    /// The next thing for navigation to do, each given once.
    pub fn next_directive(&mut self) -> Option<Directive> {
        self.directives.pop_front()
    }

    /// Something for people to know, each told once.
    pub fn next_complaint(&mut self) -> Option<String> {
        self.complaints.pop_front()
    }

    fn complain(&mut self, complaint: String) {
        const MOST: usize = 64;
        if self.complaints.len() < MOST {
            self.complaints.push_back(complaint);
        }
    }

    /// Whether a report is due: there is news, or the last one is as old as a level may be.
    #[must_use]
    pub fn is_report_due(&self, now_ns: u64) -> bool {
        let late = |sent_ns: u64| now_ns >= sent_ns.saturating_add(LEVEL_PERIOD_NS);
        self.news || self.reported_ns.is_none_or(late)
    }

    /// The next report to send.
    pub fn report(&mut self, now_ns: u64) -> RobotReport {
        self.news = false;
        self.reported_ns = Some(now_ns);
        self.client.report()
    }

    /// What is wrong at present.
    #[must_use]
    pub fn troubles(&self, now_ns: u64) -> Troubles {
        let silent_after_ns = self.setup.silent_after_ns;
        let refused = !self.refusal().is_empty();
        // After a quick restart, the process before speaks for the robot until it surely enters nothing any more.
        let restarts = { self.taken_ns }
            .is_some_and(|taken_ns| now_ns <= taken_ns.saturating_add(ENTERS_NO_MORE_NS));
        let had_time = now_ns > self.began_ns.saturating_add(silent_after_ns);
        let silent = self.client.is_mediator_silent(now_ns, silent_after_ns);
        // One that does not hear the robot is of no more use to it. A mediator that was followed anew has yet to hear it.
        let deaf = { self.unheard_since_ns }
            .is_some_and(|since_ns| now_ns > since_ns.saturating_add(silent_after_ns));
        let at_fault = had_time && !refused;
        Troubles {
            silent: at_fault && (silent || deaf),
            unheard: at_fault && deaf && !silent,
            refused: refused && !restarts,
            doubled: self.client.is_identity_doubled(),
            second_mediator: self.client.has_second_mediator(now_ns),
            // One that began so has said it.
            lost: self.origin == Origin::Lost && self.setup.began != Began::Lost,
        }
    }

    /// Why the mediator refuses this robot, or the robot this mediator; empty when they agree.
    #[must_use]
    pub fn refusal(&self) -> &str {
        let version = self.other_version.as_deref();
        version.unwrap_or_else(|| self.client.refusal())
    }

    /// How the robot stands with the mediator, for people and other programs; messages are counted elsewhere.
    #[must_use]
    pub fn state(&self, now_ns: u64) -> FleetState {
        let (coordination, net) = { self.client.coordination() }
            .map_or((0, String::new()), |(number, net, flags)| {
                (number, format!("{net}: {flags}"))
            });
        let holds = self.ids(self.setup.area_indices().filter(|&area| self.holds(area)));
        let mut waits: Vec<String> = { self.client.waiting() }
            .map(|(area, why)| match why {
                "" => area.to_owned(),
                why => format!("{area}: {why}"),
            })
            .collect();
        waits.extend(self.orders.first().map(|order| {
            let event = order.instruction.event.as_deref().unwrap_or("-");
            format!(
                "order {}: event {event} does not fit the state yet",
                order.flag
            )
        }));
        let waits = match self.refusal() {
            "" => waits.join("; "),
            refusal => refusal.to_owned(),
        };
        FleetState {
            managed: 1,
            mediator_epoch: self.client.mediator_epoch(),
            session: self.client.session(),
            silent: u64::from(self.troubles(now_ns).silent),
            acquired: u64::from(self.client.is_acquired()),
            coordination,
            net: Line::new(&net),
            holds: Line::new(&holds.join(" ")),
            waits: Line::new(&waits),
            ..FleetState::default()
        }
    }
}
