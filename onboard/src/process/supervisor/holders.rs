//! Who says of each fault that it lasts.

use description::threads::ActivityKind;

use crate::symbols::faults::{FAULTS, Fault};
use crate::symbols::wiring::ACTIVITIES;

/// Who says something of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Who {
    /// What the supervisor finds itself,
    Supervisor,
    /// and what people tell it, are one.
    Operator,
    /// What an activity reports.
    Activity(ActivityKind),
}

impl Who {
    /// For the log.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Supervisor => "supervisor",
            Self::Operator => "operator",
            Self::Activity(kind) => kind.name(),
        }
    }

    fn bit(self) -> u16 {
        match self {
            Self::Supervisor | Self::Operator => 1,
            Self::Activity(own) => {
                let place = ACTIVITIES.iter().position(|&kind| kind == own);
                2 << place.unwrap_or(ACTIVITIES.len())
            }
        }
    }
}

/// A fault lasts as long as anybody says so: that one of them knows nothing of it, ends it for nobody else.
#[derive(Clone, Copy, Debug)]
pub(super) struct Holders([u16; FAULTS]);

impl Default for Holders {
    fn default() -> Self {
        Self([0; FAULTS])
    }
}

impl Holders {
    /// Whether that is news from this one.
    pub(super) fn raise(&mut self, fault: Fault, who: Who) -> bool {
        let own = &mut self.0[fault as usize];
        let is_news = *own & who.bit() == 0;
        *own |= who.bit();
        is_news
    }

    /// Whether nobody says any more that it lasts.
    pub(super) fn clear(&mut self, fault: Fault, who: Who) -> bool {
        let own = &mut self.0[fault as usize];
        *own &= !who.bit();
        *own == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_lasts_until_the_last_one_who_said_so_takes_it_back() {
        let mut holders = Holders::default();
        let activities = ACTIVITIES.map(Who::Activity);
        let all = || [Who::Supervisor].into_iter().chain(activities);
        for who in all() {
            assert!(holders.raise(Fault::OperatorStop, who));
            assert!(!holders.raise(Fault::OperatorStop, who), "{who:?} again");
        }
        for (number, who) in all().enumerate() {
            let is_last = number == ACTIVITIES.len();
            assert_eq!(holders.clear(Fault::OperatorStop, who), is_last, "{who:?}");
        }
        assert!(holders.raise(Fault::OperatorStop, Who::Supervisor));
        let none = holders.clear(Fault::OperatorStop, activities[0]);
        assert!(!none, "it has never said so");
        assert!(holders.clear(Fault::OperatorStop, Who::Operator));
    }
}
