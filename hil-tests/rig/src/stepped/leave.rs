//! Stands in for communication on a managed site: tells navigation which areas it may use.

use coordination::symbols::Writer;
use onboard::activities::fleet_link::{CommunicationEnd, NavigationEnd, link};
use onboard::realtime::wake::Wake;
use skills::borders::AreaSet;

/// How often leave is repeated; navigation does not trust leave that is old.
const REPEAT_NS: u64 = 100_000_000;

/// Leave for areas.
pub(super) struct Leave {
    symbol: Writer<AreaSet>,
    link: CommunicationEnd,
    areas: AreaSet,
    /// When it is to be repeated.
    next_ns: u64,
}

impl Leave {
    /// No leave at first; also returns navigation's end of the link.
    pub(super) fn new(symbol: Writer<AreaSet>) -> (Self, NavigationEnd) {
        let (navigation, link) = link(Wake::default());
        let leave = Self {
            symbol,
            link,
            areas: AreaSet::EMPTY,
            next_ns: 0,
        };
        (leave, navigation)
    }

    /// From the next step on.
    pub(super) fn give(&mut self, areas: AreaSet) {
        self.areas = areas;
        self.next_ns = 0;
    }

    /// Repeats it when it is due, and drops what navigation answers.
    pub(super) fn cycle(&mut self, now_ns: u64) {
        while self.link.events.receive().is_some() {}
        if now_ns >= self.next_ns {
            self.next_ns = now_ns + REPEAT_NS;
            self.symbol.write(now_ns, &self.areas);
        }
    }
}
