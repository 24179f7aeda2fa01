//! A robot: its process, and its body, which goes on when the process ends.

use std::collections::HashMap;
use std::sync::{LazyLock, Mutex};

use contract::client::{Client, Situation};
use contract::timing::{ENTERS_WITHIN_NS, SILENT_AFTER_NS};
use contract::wire::RobotReport;

use super::action::{AREAS, ROBOTS};
use super::kept::Kept;
use super::rules::Rule;
use super::world::{SITE, TICK_NS};

/// The clocks of robots in thousandths of the mediator's speed: as slow and as fast as the contract allows.
const RATES: [u64; 3] = [980, 1020, 980];

/// Processes that have just started, by their boot epoch: there are few, and each compiles its protocols.
static STARTED: LazyLock<Mutex<HashMap<u64, Kept<Client>>>> = LazyLock::new(Mutex::default);

#[derive(Clone)]
pub struct Robot {
    pub number: u8,
    pub client: Option<Kept<Client>>,
    pub boots: u8,
    /// A bit for each area that the body reaches into.
    pub body: u8,
    /// The area before which it can no longer stop, and until when it has entered or stands, by its own clock.
    pub committed: Option<(u8, u64)>,
    /// A bit for each area in which it stands, as it has told the mediator that runs.
    pub said_in: u8,
    /// That was a process before this one, which knows nothing of it.
    pub is_unaware: bool,
    pub is_cut: bool,
    /// It has reported since the last tick.
    pub talked: bool,
    /// It wants to go on.
    pub wants: bool,
    /// It has been through both areas, and stays outside.
    pub is_through: bool,
}

impl Robot {
    pub fn new(number: u8) -> Self {
        Self {
            number,
            client: None,
            boots: 0,
            body: 0,
            committed: None,
            said_in: 0,
            is_unaware: false,
            is_cut: false,
            talked: false,
            wants: true,
            is_through: false,
        }
    }

    pub fn id(&self) -> &'static str {
        ROBOTS[usize::from(self.number)]
    }

    /// Its own clock, which has nothing to do with any other.
    pub fn now_ns(&self, tick: u8) -> u64 {
        let number = usize::from(self.number);
        500_000_000_000 * (number as u64 + 1) + u64::from(tick) * TICK_NS * RATES[number] / 1000
    }

    pub fn start(&mut self) {
        self.boots += 1;
        self.is_unaware = self.committed.is_some();
        let boot_epoch = 100 * (u64::from(self.number) + 1) + u64::from(self.boots);
        let mut started = STARTED.lock().expect("no panic");
        let client = { started.entry(boot_epoch) }
            .or_insert_with(|| Kept::new(Client::new(self.id(), SITE, boot_epoch)));
        self.client = Some(client.clone());
    }

    /// The way leads through `a` into `b`, and out.
    pub fn next(&self) -> Option<u8> {
        match self.body {
            0 if !self.is_through => Some(0),
            1 => Some(1),
            _ => None,
        }
    }

    /// The area that the body may leave.
    pub fn behind(&self) -> Option<u8> {
        match self.body {
            2 => Some(2),
            3 => Some(1),
            _ => None,
        }
    }

    pub fn leave(&mut self) {
        self.body &= !self.behind().unwrap_or(0);
        self.is_through |= self.body == 0;
    }

    pub fn may_commit(&self, tick: u8, without: Option<Rule>) -> bool {
        let (Some(client), Some(next), None) = (&self.client, self.next(), self.committed) else {
            return false;
        };
        let (client, area) = (client.get(), AREAS[usize::from(next)]);
        match without {
            _ if !self.wants => false,
            Some(Rule::Grant) => true,
            Some(Rule::Lease) => client.holds(area),
            _ => client.may_be_in(area, self.now_ns(tick)),
        }
    }

    pub fn commit(&mut self, tick: u8, without: Option<Rule>) {
        let longer_ns = if without == Some(Rule::EntersWithin) {
            2 * TICK_NS
        } else {
            0
        };
        let until_ns = self.now_ns(tick) + ENTERS_WITHIN_NS + longer_ns;
        self.committed = self.next().map(|next| (next, until_ns));
        self.is_unaware = false;
    }

    /// Time has passed: what was to be entered and was not, the robot stands before.
    pub fn pass(&mut self, tick: u8) {
        let now_ns = self.now_ns(tick);
        self.committed = self.committed.filter(|&(_, until_ns)| now_ns <= until_ns);
        self.talked = false;
        if self.is_cut {
            self.look(tick);
        }
    }

    /// Bits of the areas in which it stands, where it wants to be, and before which it knows that it can no longer stop: all that its
    /// [`situation`](Self::situation) is made of.
    fn places(&self) -> [u8; 3] {
        let next = self
            .next()
            .filter(|_| self.wants)
            .map_or(0, |area| 1 << area);
        let committed = { self.committed.filter(|_| !self.is_unaware) };
        let committed = committed.map_or(0, |(area, _)| 1 << area);
        [self.body, self.body | next, committed]
    }

    fn situation([stands_in, wanted, committed]: [u8; 3]) -> Situation {
        let named = |bits: u8| -> Vec<String> {
            let areas = AREAS.iter().enumerate();
            areas
                .filter(|(area, _)| bits & 1 << area != 0)
                .map(|(_, id)| (*id).to_owned())
                .collect()
        };
        Situation {
            located: true,
            stands_in: named(stands_in),
            wanted: named(wanted),
            committed: named(committed),
            ..Situation::default()
        }
    }

    /// Its process notices where it is, also when nobody hears it.
    pub fn look(&mut self, tick: u8) {
        let (places, now_ns) = (self.places(), self.now_ns(tick));
        if let Some(client) = &mut self.client {
            client.change_by(("looks", places, now_ns), |client| {
                client.step(Self::situation(places), now_ns, SILENT_AFTER_NS)
            });
        }
    }

    /// The next report of its process.
    pub fn report(&mut self, tick: u8) -> Option<Kept<RobotReport>> {
        let (places, now_ns) = (self.places(), self.now_ns(tick));
        let what = ("reports", places, now_ns);
        let report = self.client.as_mut()?.change_by(what, |client| {
            client.step(Self::situation(places), now_ns, SILENT_AFTER_NS);
            Kept::new(client.report())
        });
        self.talked = true;
        Some(report)
    }

    /// The fence of the grant that it has of an area; 0 without one.
    pub fn fence(&self, area: u8) -> u64 {
        let Some(mut client) = self.client.clone() else {
            return 0;
        };
        client.change_by(("fence", area), |client| {
            let said = client.report().access;
            let own = said
                .iter()
                .find(|access| access.area == AREAS[usize::from(area)]);
            own.map_or(0, |access| access.fence)
        })
    }
}
