//! How often something may happen in a minute before an operator is needed.

use crate::realtime::clock::SECOND_NS;

/// Most in a minute that can be asked for.
const MOST: usize = 16;

/// Times of the last.
#[derive(Debug)]
pub(super) struct PerMinute {
    /// 0: none.
    times_ns: [u64; MOST],
    most: usize,
}

impl PerMinute {
    /// A minute may have so many.
    pub(super) fn new(most: usize) -> Self {
        Self {
            times_ns: [0; MOST],
            most: most.clamp(1, MOST),
        }
    }

    /// How many a minute may have.
    pub(super) fn most(&self) -> usize {
        self.most
    }

    /// Notes one, unless the last minute has had as many as allowed; returns whether it was noted.
    pub(super) fn note(&mut self, now_ns: u64) -> bool {
        let Some(oldest) = self.times_ns[..self.most].iter_mut().min() else {
            return true;
        };
        let free = *oldest == 0 || now_ns - *oldest >= 60 * SECOND_NS;
        if free {
            *oldest = now_ns;
        }
        free
    }

    /// Counts anew.
    pub(super) fn forget(&mut self) {
        self.times_ns = [0; MOST];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_has_as_many_as_configured() {
        let mut limit = PerMinute::new(2);
        let second = |second: u64| second * SECOND_NS;
        assert!(limit.note(second(1)) && limit.note(second(30)));
        assert!(!limit.note(second(59)));
        assert!(limit.note(second(61)), "the first was a minute ago");
        assert!(!limit.note(second(62)));
        limit.forget();
        assert!(limit.note(second(63)));
    }
}
