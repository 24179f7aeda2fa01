//! From when on each robot's lease runs: when it sent the newest report whose echo has reached it (the contract's "The lease").
//!
//! Known only where it is known which messages arrive, on the simulated clock.

use std::collections::{BTreeMap, VecDeque};

/// More reports of one robot are not under way at once.
const MOST_SENT: usize = 1024;

/// The leases of all robots.
#[derive(Clone, Debug, Default)]
pub(super) struct Leases(BTreeMap<String, Lease>);

#[derive(Clone, Debug, Default)]
struct Lease {
    /// Reports that were sent lately: boot, sequence, when.
    sent: VecDeque<(u64, u64, u64)>,
    from_ns: Option<u64>,
}

impl Leases {
    /// The robot sends a report.
    pub(super) fn sent(&mut self, robot: &str, boot: u64, sequence: u64, at_ns: u64) {
        let own = self.0.entry(robot.to_owned()).or_default();
        if own.sent.len() == MOST_SENT {
            own.sent.pop_front();
        }
        own.sent.push_back((boot, sequence, at_ns));
    }

    /// An answer that echoes a report has reached the robot.
    pub(super) fn echoed(&mut self, robot: &str, boot: u64, sequence: u64) {
        let Some(own) = self.0.get_mut(robot) else {
            return;
        };
        let is_it = |sent: &&(u64, u64, u64)| (sent.0, sent.1) == (boot, sequence);
        // The newest ones are the likely ones.
        let sent_ns = { own.sent.iter().rev() }.find(is_it).map(|sent| sent.2);
        own.from_ns = own.from_ns.max(sent_ns);
    }

    /// When the robot's lease has begun last; none: no echo has reached it.
    pub(super) fn began_ns(&self, robot: &str) -> Option<u64> {
        self.0.get(robot)?.from_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lease_runs_from_when_the_newest_echoed_report_was_sent() {
        let mut leases = Leases::default();
        leases.echoed("amr-1", 7, 1);
        assert_eq!(leases.began_ns("amr-1"), None);
        for sequence in 1..=5 {
            leases.sent("amr-1", 7, sequence, 100 * sequence);
        }
        leases.echoed("amr-1", 7, 3);
        assert_eq!(leases.began_ns("amr-1"), Some(300));
        // One that comes late, one of another boot, and one that nobody has sent.
        for (boot, sequence) in [(7, 2), (8, 5), (7, 9)] {
            leases.echoed("amr-1", boot, sequence);
            assert_eq!(leases.began_ns("amr-1"), Some(300));
        }
        leases.echoed("amr-1", 7, 5);
        assert_eq!(leases.began_ns("amr-1"), Some(500));
        assert_eq!(leases.began_ns("amr-2"), None);
    }
}
