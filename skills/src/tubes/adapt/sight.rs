//! Whether scans arrive, and have arrived without a gap for long enough.

use super::outcome::{ObserveError, Reason};
use super::stop_rules::StopRules;

/// Tolerance between clock readings of two threads.
const CLOCK_SLACK_NS: u64 = 20_000_000;

/// Times of the scans that were judged.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    timeout_ns: u64,
    good_ns: u64,
    /// Reference and arrival of the newest scan.
    newest: Option<(u64, u64)>,
    /// Since when scans have come without a gap.
    good_since_ns: Option<u64>,
    blind_since_ns: Option<u64>,
    /// Stops because of missing scans.
    pub blind_stops: u64,
}

impl Sight {
    pub fn new(rules: &StopRules) -> Self {
        Self {
            timeout_ns: (rules.scan_timeout_s * 1e9) as u64,
            good_ns: (rules.good_scans_s * 1e9) as u64,
            newest: None,
            good_since_ns: None,
            blind_since_ns: None,
            blind_stops: 0,
        }
    }

    /// The clock was set back: the newest scan is from the future.
    pub fn clock_ran_back(&self, now_ns: u64) -> bool {
        self.newest
            .is_some_and(|(_, arrival_ns)| now_ns.saturating_add(self.timeout_ns) < arrival_ns)
    }

    pub fn check(&self, reference_ns: u64, now_ns: u64) -> Result<(), ObserveError> {
        if let Some((previous_ns, _)) = self.newest
            && reference_ns <= previous_ns
        {
            return Err(ObserveError::NotAfter {
                reference_ns,
                previous_ns,
            });
        }
        if reference_ns.abs_diff(now_ns) > self.timeout_ns {
            return Err(ObserveError::NotOfNow {
                reference_ns,
                now_ns,
            });
        }
        Ok(())
    }

    /// Takes a scan that passed the check; says whether it is the first after a gap.
    pub fn take(&mut self, reference_ns: u64, now_ns: u64) -> bool {
        let begins = !self.is_fresh(now_ns) || self.good_since_ns.is_none();
        if begins {
            self.good_since_ns = Some(now_ns);
        }
        self.newest = Some((reference_ns, now_ns));
        begins
    }

    fn is_fresh(&self, now_ns: u64) -> bool {
        self.newest.is_some_and(|(_, arrival_ns)| {
            now_ns.saturating_sub(arrival_ns) <= self.timeout_ns
                && arrival_ns.saturating_sub(now_ns) <= CLOCK_SLACK_NS
        })
    }

    /// The reason to stop when scans are missing, and since when.
    pub fn look(&mut self, now_ns: u64) -> Option<(Reason, u64)> {
        if !self.is_fresh(now_ns) {
            if self.blind_since_ns.is_none() {
                self.blind_stops += 1;
            }
            self.good_since_ns = None;
            return Some((Reason::NoScan, *self.blind_since_ns.get_or_insert(now_ns)));
        }
        let good_ns = self
            .good_since_ns
            .map_or(0, |since_ns| now_ns.saturating_sub(since_ns));
        if good_ns < self.good_ns {
            let since_ns = *self.blind_since_ns.get_or_insert(now_ns);
            return Some((Reason::AwaitingScans, since_ns));
        }
        self.blind_since_ns = None;
        None
    }

    /// Age of the newest scan; the largest number when there is none.
    pub fn age_ns(&self, now_ns: u64) -> u64 {
        self.newest.map_or(u64::MAX, |(reference_ns, _)| {
            now_ns.saturating_sub(reference_ns)
        })
    }

    pub fn newest_ns(&self) -> Option<u64> {
        self.newest.map(|(reference_ns, _)| reference_ns)
    }

    /// As at the beginning; the count stays.
    pub fn reset(&mut self) {
        self.newest = None;
        self.good_since_ns = None;
        self.blind_since_ns = None;
    }
}
