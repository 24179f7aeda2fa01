//! A robot without wheels: where it may go, it is.

use contract::client::{Client, Situation};
use contract::floor::Floor;
use contract::wire::{Control, Level, MediatorReport, RobotReport};

/// The site's name.
pub(super) const SITE: &str = "round";
/// A robot hears nothing for so long: then it is alone.
const SILENT_NS: u64 = 1_000_000_000;
/// The areas that the fast one drives through, in order.
const ROUND: [&str; 6] = ["7", "1", "2", "3", "4", "6"];
/// Where it has driven a lap.
const LAP_AT: &str = ROUND[0];
/// What each order is about: its event, where it leads, and what the state machine outputs there.
const ORDERS: [(&str, &str, &str); 4] = [
    ("go-1", "1", "in-1"),
    ("go-2", "2", "in-2"),
    ("aside", "5", "parked"),
    ("back", "1", "back-in-1"),
];

/// One of the two.
pub(super) struct Robot {
    client: Client,
    /// Goes round by itself.
    goes_round: bool,
    at: &'static str,
    /// By an order, or by itself.
    to: Option<&'static str>,
    output: &'static str,
    /// How often it was where it began.
    pub(super) laps: u64,
    /// When it last reported, on the monotonic clock.
    pub(super) reported_ns: Option<u64>,
    /// What flags mean, as the last message said.
    pub(super) control: Option<Control>,
}

impl Robot {
    pub(super) fn new(id: &str, at: &'static str, boot_epoch: u64, goes_round: bool) -> Self {
        Self {
            client: Client::new(id, SITE, boot_epoch),
            goes_round,
            at,
            to: None,
            output: "",
            laps: 0,
            reported_ns: None,
            control: None,
        }
    }

    /// It hears the mediator, of which it also learns its floor.
    pub(super) fn hear(&mut self, message: &MediatorReport, now_ns: u64) {
        self.control.clone_from(&message.control);
        if !message.floor.is_empty() && !self.client.is_registered() {
            self.client = self.client.clone().on(Floor::said(&message.floor));
        }
        self.client.receive(message, now_ns);
    }

    /// Follows orders, or its round; says whether there is news.
    pub(super) fn step(&mut self, now_ns: u64) -> bool {
        let mut news = false;
        while let Some(order) = self.client.next_order() {
            let event = order.instruction.event.unwrap_or_default();
            if let Some((_, to, output)) = ORDERS.iter().find(|own| own.0 == event) {
                (self.to, self.output) = (Some(*to), *output);
            }
        }
        if self.to.is_none() && self.goes_round && !self.client.is_acquired() {
            let place = ROUND.iter().position(|area| *area == self.at);
            self.to = place.map(|place| ROUND[(place + 1) % ROUND.len()]);
        }
        if let Some(to) = self.to
            && self.client.is_registered()
            && self.client.holds(to)
            && self.client.holds(self.at)
        {
            self.laps += u64::from(to == LAP_AT);
            (self.at, self.to) = (to, None);
            // It must be seen to be there before its machine says so.
            news |= self.client.step(self.situation(), now_ns, SILENT_NS);
            news |= self.client.output(std::mem::take(&mut self.output));
        }
        news | self.client.step(self.situation(), now_ns, SILENT_NS)
    }

    /// What it has to say.
    pub(super) fn report(&mut self) -> RobotReport {
        self.client.report()
    }

    fn situation(&self) -> Situation {
        let wanted = [Some(self.at), self.to].into_iter().flatten();
        Situation {
            located: self.client.is_registered(),
            stands_in: vec![self.at.to_owned()],
            wanted: wanted.map(str::to_owned).collect(),
            committed: Vec::new(),
            pose: None,
            fsm_state: format!("in-{}", self.at),
        }
    }
}

/// The names of the flags that a level says are set.
pub(super) fn flags(meaning: &Control, level: Option<&Level>) -> Vec<String> {
    let Some(level) = level else {
        return Vec::new();
    };
    let all: Vec<u32> = (0..meaning.flags.len() as u32).collect();
    let path = meaning.paths.get(level.path as usize);
    let path = path.map_or(&all, |path| &path.flags);
    let set = path.iter().take(level.progress as usize);
    let names = set.filter_map(|&flag| meaning.flags.get(flag as usize));
    names.map(|flag| flag.name.clone()).collect()
}
