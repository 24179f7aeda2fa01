//! A robot: a body, which no crash moves, and the process in it.

use std::collections::BTreeSet;

use super::floor::Floor;
use crate::random::Random;
use contract::client::{Client, Order, Situation};

/// From when it cannot stop any more until it reaches in, or stands, a robot may take 3.9 s.
const REACHES_IN_MS: u64 = 3_800;

/// Why a robot says something else than where its body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// It does not know where it is, and says so.
    Lost,
    /// Somebody has given it another pose, of a robot in this spot.
    Elsewhere(usize),
}

/// The body.
pub struct Robot {
    pub id: String,
    pub role: &'static str,
    /// It is in the areas of this spot,
    pub spot: usize,
    /// and in those of this one while it crosses the border.
    pub crossing: Option<usize>,
    /// It cannot stop before that border any more.
    committed: Option<usize>,
    /// When the present motion ends.
    pub until_ms: u64,
    /// How long it stays in an area at least.
    pub dwell_ms: u64,
    pub moves: u64,
    /// The spots of its round trip, and where it is on the way.
    route: Vec<usize>,
    leg: usize,
    /// It asks for areas that it does not go to.
    pub dreams: bool,
    /// It breaks the rules: it waits for no grant.
    pub reckless: bool,
    /// Or for no lease.
    pub no_lease: bool,
    /// It takes seconds from when it cannot stop any more until it reaches in.
    pub is_slow: bool,
    /// Now and then something stands before the border for seconds, and then leaves.
    pub is_hindered: bool,
    hindered_until_ms: u64,
    /// It stands outside all areas, and is switched off.
    pub is_away: bool,
    /// What is wrong with its pose, and until when.
    pub mistake: Option<(Mistake, u64)>,
    /// When it did not know last where it is, or was out of reach,
    pub lost_ms: u64,
    /// had no process that takes orders,
    pub deaf_ms: u64,
    /// was elsewhere than others thought,
    pub elsewhere_ms: u64,
    /// and whether its pose was wrong since it last entered an area.
    pub was_mistaken: bool,
    /// From where it came to where it is, and when.
    pub came: (usize, u64),
    /// Into the first one of these places it comes through the second one only.
    pub through: Option<(usize, usize)>,
    /// Such an area, until when, and whether it says that it could not stop before it.
    dream: Option<(usize, u64, bool)>,
    /// Those areas before which it has said so since it has them.
    insists_on: BTreeSet<usize>,
    pub process: Option<Process>,
    /// When the process starts again.
    pub restart_ms: u64,
    pub report_ms: u64,
}

/// What a crash loses.
pub struct Process {
    pub client: Client,
    /// Of its state machine.
    state: &'static str,
    order: Option<Order>,
    /// It does not carry out orders, until it is told to get out of the way.
    stuck: bool,
}

impl Process {
    pub fn new(client: Client) -> Self {
        Self {
            client,
            state: "driving",
            order: None,
            stuck: false,
        }
    }

    /// Takes each order once. A few robots get stuck.
    pub fn obey(&mut self, random: &mut Random, stuck_per_mille: u64) {
        if let Some(was) = self.client.take_up() {
            self.state = match was.fsm_state.as_str() {
                "parked" => "parked",
                "halted" => "halted",
                _ => "driving",
            };
        }
        while let Some(order) = self.client.next_order() {
            let event = order.instruction.event.as_deref().unwrap_or_default();
            if event == "resume" {
                let was = self
                    .order
                    .as_ref()
                    .and_then(|own| own.instruction.event.as_deref());
                // Nobody is released from getting out of the way before it is.
                assert!(
                    was != Some("halt")
                        || self.state != "driving"
                        || self.client.counters().let_go > 0,
                    "released while {}",
                    self.state
                );
                self.state = "driving";
                self.order = None;
                self.stuck = false;
            } else if !event.is_empty() {
                self.stuck = event != "halt" && random.below(1000) < stuck_per_mille;
                self.order = Some(order);
            }
        }
    }

    fn may_be_in(&self, area: &str, no_lease: bool, now_ms: u64) -> bool {
        self.client.may_be_in(area, now_ms * 1_000_000) || no_lease && self.client.holds(area)
    }

    pub fn event(&self) -> &str {
        let order = self.order.as_ref().filter(|_| !self.stuck);
        order
            .and_then(|order| order.instruction.event.as_deref())
            .unwrap_or_default()
    }
}

impl Robot {
    pub fn new(
        id: &str,
        role: &'static str,
        route: &[usize],
        leg: usize,
        dwell_ms: u64,
        random: &mut Random,
    ) -> Self {
        Self {
            id: id.to_owned(),
            role,
            spot: route[leg],
            route: route.to_vec(),
            leg,
            crossing: None,
            committed: None,
            until_ms: 0,
            dwell_ms,
            moves: 0,
            dreams: false,
            reckless: false,
            no_lease: false,
            is_slow: false,
            is_hindered: false,
            hindered_until_ms: 0,
            is_away: false,
            mistake: None,
            lost_ms: 0,
            deaf_ms: 0,
            elsewhere_ms: 0,
            was_mistaken: false,
            came: (route[leg], 0),
            through: None,
            dream: None,
            insists_on: BTreeSet::new(),
            process: None,
            restart_ms: random.below(500),
            report_ms: 0,
        }
    }

    fn dream(&mut self, floor: &Floor, now_ms: u64, random: &mut Random) {
        if self
            .dream
            .is_some_and(|(_, until_ms, _)| now_ms >= until_ms)
        {
            self.dream = None;
        } else if self.dreams && self.dream.is_none() && random.below(50) == 0 {
            let area = random.below(floor.limits.len() as u64) as usize;
            let until_ms = now_ms + random.below(3_000);
            self.dream = Some((area, until_ms, random.chance(30)));
        }
    }

    /// Areas that the body reaches into.
    pub fn stands_in(&self, floor: &Floor) -> Vec<usize> {
        let mut areas = Vec::new();
        self.each_area(floor, |area| areas.push(area));
        areas.sort_unstable();
        areas
    }

    /// Each of them, once.
    pub fn each_area(&self, floor: &Floor, mut add: impl FnMut(usize)) {
        let here = &floor.spots[self.spot];
        here.iter().for_each(|&area| add(area));
        let there = self.crossing.map(|spot| &floor.spots[spot]);
        let more = there.into_iter().flatten();
        more.filter(|area| !here.contains(area))
            .for_each(|&area| add(area));
    }

    /// Where its own way leads; from beside the way, back to it.
    fn next(&self) -> usize {
        if self.spot == self.route[self.leg] {
            self.route[(self.leg + 1) % self.route.len()]
        } else {
            let back = self.route[self.leg];
            let through = self.through.filter(|(inner, _)| *inner == back);
            through.map_or(back, |(_, outer)| outer)
        }
    }

    /// The process is gone. A body that could not stop any more rolls over the border.
    pub fn crash(&mut self, now_ms: u64, random: &mut Random) {
        self.process = None;
        self.insists_on.clear();
        self.restart_ms = now_ms + random.below(3_000);
        self.crossing = self.crossing.or(self.committed.take());
        self.until_ms = u64::MAX;
    }

    /// Somebody switches it off and carries it.
    pub fn is_taken_to(&mut self, spot: usize) {
        self.process = None;
        self.is_away = true;
        self.insists_on.clear();
        self.spot = spot;
        (self.crossing, self.committed, self.mistake) = (None, None, None);
        self.was_mistaken = false;
        self.until_ms = u64::MAX;
    }

    /// Where it was carried to it starts again.
    pub fn is_put_back(&mut self, now_ms: u64) {
        if std::mem::take(&mut self.is_away) {
            self.restart_ms = now_ms;
        }
    }

    /// It says that it could not stop before the area, though it neither moves nor goes there; or has kept by this what it has.
    pub fn insists_on(&self, area: usize) -> bool {
        self.insists_on.contains(&area)
    }

    /// For people.
    pub fn describe(&self) -> String {
        let process = self.process.as_ref();
        format!(
            "{} on its way to {}, until {} ms, by order {:?}",
            process.map_or("off", |own| own.state),
            self.next(),
            self.until_ms,
            process.and_then(|own| own.order.as_ref()),
        )
    }

    /// Somebody tells a robot that was wrong where it is.
    pub fn is_found(&mut self, mistake: Option<(Mistake, u64)>) {
        if let (Some((Mistake::Elsewhere(_), _)), Some(process)) = (mistake, &mut self.process) {
            process.client.placed_anew();
        }
    }

    /// It neither moves nor will.
    pub fn stands(&self) -> bool {
        self.crossing.is_none() && self.committed.is_none()
    }

    /// Where the process wants the body next: an area, if it is to go anywhere.
    fn target(&self, floor: &Floor) -> Option<usize> {
        let process = self.process.as_ref()?;
        if process.state == "halted" {
            return None;
        }
        if !process.client.is_acquired() {
            return Some(self.next());
        }
        let target = match process.event() {
            "aside" => floor.lay_by?,
            "back" | "go-1" => floor.first?,
            "go-2" => floor.second?,
            _ => return None,
        };
        (target != self.spot).then_some(target)
    }

    /// Moves as long as the process wants; only areas that it holds are entered.
    pub fn drive(&mut self, floor: &Floor, now_ms: u64, random: &mut Random) {
        if self.process.is_none() || self.until_ms == u64::MAX || now_ms < self.until_ms {
            return;
        }
        if let Some(next) = self.crossing.take() {
            let on_its_way = next == self.next();
            if on_its_way && self.spot == self.route[self.leg] {
                self.leg = (self.leg + 1) % self.route.len();
            }
            // Out of where it should not have been.
            let left = |area| !floor.spots[next].contains(area);
            self.was_mistaken &= !floor.spots[self.spot].iter().all(left);
            self.came = (self.spot, now_ms);
            self.spot = next;
            if self.spot != self.route[self.leg]
                && let Some(leg) = self.route.iter().position(|&spot| spot == next)
            {
                // Sent to another place of its way than it was going to.
                self.leg = leg;
            }
            self.moves += 1;
            self.until_ms = now_ms + self.dwell_ms + random.below(self.dwell_ms);
        } else if let Some(next) = self.committed.take() {
            self.crossing = Some(next);
            self.until_ms = now_ms + 50 + random.below(200);
        } else if now_ms < self.hindered_until_ms {
            // It goes on wanting.
        } else if self.mistake.is_some() {
            // Whoever is lost stands; one that was given a wrong pose is not sent on before somebody has looked.
        } else if let Some(next) = self.target(floor)
            && let Some(process) = &self.process
            && process.client.is_registered()
            && (self.reckless || { floor.spots[next].iter() }
                .all(|&area| process.may_be_in(floor.name(area), self.no_lease, now_ms)))
        {
            if self.is_hindered && random.chance(20) {
                self.hindered_until_ms = now_ms + 5_000 + random.below(5_000);
                return;
            }
            self.committed = Some(next);
            let longest_ms = if self.is_slow { REACHES_IN_MS } else { 100 };
            self.until_ms = now_ms + random.below(longest_ms);
        }
    }

    /// Steps the state machine and the client. Returns whether there is news to report.
    pub fn step(
        &mut self,
        floor: &Floor,
        now_ms: u64,
        silent_ns: u64,
        random: &mut Random,
    ) -> bool {
        self.dream(floor, now_ms, random);
        let (spot, crossing, next) = (self.spot, self.crossing, self.next());
        let mut stands_in = self.stands_in(floor);
        let mistake = self.mistake.map(|(mistake, _)| mistake);
        let is_lost = mistake == Some(Mistake::Lost);
        if is_lost {
            self.lost_ms = now_ms;
        }
        if self.was_mistaken || self.is_away {
            self.elsewhere_ms = now_ms;
        }
        match mistake {
            Some(Mistake::Lost) => stands_in.clear(),
            Some(Mistake::Elsewhere(spot)) => stands_in.clone_from(&floor.spots[spot]),
            None => {}
        }
        let process = self.process.as_mut();
        if !process
            .as_ref()
            .is_some_and(|own| own.client.is_registered())
        {
            self.deaf_ms = now_ms;
        }
        let Some(process) = process else {
            return false;
        };
        let arrived = crossing.is_none();
        let at_first = Some(spot) == floor.first;
        let mut news = false;
        if process.client.is_acquired() {
            let (state, output) = match process.event() {
                "aside" if arrived && Some(spot) == floor.lay_by => ("parked", "parked"),
                "back" if arrived && at_first => ("driving", "back-in-1"),
                "go-1" if arrived && at_first => ("driving", "in-1"),
                "go-2" if arrived && Some(spot) == floor.second => ("driving", "in-2"),
                "halt" if arrived && process.state != "parked" => ("halted", ""),
                _ => (process.state, ""),
            };
            process.state = state;
            news |= process.client.output(output);
        } else if process.state == "halted" {
            // Only an order lets it drive on.
        } else {
            process.state = if Some(spot) == floor.lay_by && arrived {
                "parked"
            } else {
                "driving"
            };
            process.order = None;
        }
        let names = |areas: &[usize]| {
            areas
                .iter()
                .map(|&area| floor.name(area).to_owned())
                .collect()
        };
        let mut wanted = stands_in.clone();
        // Just early enough to pass without stopping; or all the time, where it has left a part of it.
        let comes_back = floor.spots[next]
            .iter()
            .any(|area| stands_in.contains(area));
        let is_time = now_ms + 200 >= self.until_ms || comes_back;
        if arrived && mistake.is_none() && is_time {
            wanted.extend(&floor.spots[next]);
        }
        let committed = { self.committed.into_iter() }.flat_map(|spot| &floor.spots[spot]);
        let mut committed: Vec<usize> = committed.copied().collect();
        let client = &process.client;
        self.insists_on
            .retain(|&area| client.holds(floor.name(area)));
        if let Some((area, _, insists)) = self.dream {
            wanted.push(area);
            if insists {
                committed.push(area);
                self.insists_on.insert(area);
            }
        }
        let situation = Situation {
            located: process.client.is_registered() && !is_lost,
            stands_in: names(&stands_in),
            wanted: names(&wanted),
            committed: names(&committed),
            pose: None,
            fsm_state: process.state.to_owned(),
        };
        news | process
            .client
            .step(situation, now_ms * 1_000_000, silent_ns)
    }
}
