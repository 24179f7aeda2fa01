//! Other mediators that are on the network, by their liveliness tokens.

use std::collections::BTreeSet;

/// At most so many are remembered, and told of.
const MEDIATORS: usize = 16;
/// Their coming and going is said so often in one minute: whoever may hold one token may put and take back any number.
const LINES: u32 = 16;
const MINUTE_NS: u64 = 60_000_000_000;

/// Other mediators that are there, and how much was said of them of late.
#[derive(Debug, Default)]
pub(super) struct Mediators {
    there: BTreeSet<u64>,
    since_ns: u64,
    /// Lines of this minute.
    said: u32,
    left_out: u64,
}

impl Mediators {
    /// One has come, or has gone. Returns whether to say so.
    pub(super) fn see(&mut self, instance: u64, is_there: bool, now_ns: u64) -> bool {
        let is_news = if is_there {
            self.there.len() < MEDIATORS && self.there.insert(instance)
        } else {
            self.there.remove(&instance)
        };
        if !is_news {
            return false;
        }
        if self.said == 0 {
            self.since_ns = now_ns;
        }
        if self.said == LINES {
            self.left_out += 1;
            return false;
        }
        self.said += 1;
        true
    }

    /// How often it was not said in a minute that is over, if at all.
    pub(super) fn left_out(&mut self, now_ns: u64) -> Option<u64> {
        if self.said == 0 || now_ns < self.since_ns.saturating_add(MINUTE_NS) {
            return None;
        }
        self.said = 0;
        Some(std::mem::take(&mut self.left_out)).filter(|&count| count > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_that_comes_and_goes_is_told_of_so_often_in_a_minute() {
        let mut mediators = Mediators::default();
        let mut see = |now_ns| {
            let told = [true, false].map(|is_there| mediators.see(7, is_there, now_ns));
            (told, mediators.left_out(now_ns))
        };
        assert_eq!(see(5), ([true, true], None));
        let told = (0..1000)
            .map(|_| see(6).0)
            .filter(|told| told[0] || told[1]);
        assert_eq!(told.count(), LINES as usize / 2 - 1);
        assert_eq!(see(MINUTE_NS + 4), ([false, false], None));
        let left_out = 2 * 1000 + 4 - u64::from(LINES);
        assert_eq!(see(MINUTE_NS + 5), ([false, false], Some(left_out + 2)));
        assert_eq!(see(MINUTE_NS + 6), ([true, true], None));
        // Nothing was left out since.
        assert_eq!(mediators.left_out(3 * MINUTE_NS), None);
    }

    #[test]
    fn more_than_a_few_are_not_told_of() {
        let mut mediators = Mediators::default();
        let told =
            (0..1000).filter(|&instance| mediators.see(instance, true, instance * MINUTE_NS));
        assert_eq!(told.count(), MEDIATORS);
        assert!(!mediators.see(1, true, 0) && mediators.there.len() == MEDIATORS);
    }
}
