//! How often the bus may be brought up again before an operator is needed.

use crate::realtime::clock::SECOND_NS;

/// Most bring-ups in a minute that can be configured.
const MAX_BRING_UPS: usize = 16;

/// Times of the last bring-ups.
#[derive(Debug)]
pub(super) struct BringUpLimit {
    /// 0: none.
    times_ns: [u64; MAX_BRING_UPS],
    per_minute: usize,
}

impl BringUpLimit {
    pub(super) fn new(per_minute: usize) -> Self {
        Self {
            times_ns: [0; MAX_BRING_UPS],
            per_minute: per_minute.clamp(1, MAX_BRING_UPS),
        }
    }

    /// Bring-ups that a minute may have.
    pub(super) fn per_minute(&self) -> usize {
        self.per_minute
    }

    /// Notes a bring-up, unless the last minute has had as many as allowed; returns whether it was noted.
    pub(super) fn note(&mut self, now_ns: u64) -> bool {
        let Some(oldest) = self.times_ns[..self.per_minute].iter_mut().min() else {
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
        self.times_ns = [0; MAX_BRING_UPS];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_has_as_many_as_configured() {
        let mut limit = BringUpLimit::new(2);
        let second = |second: u64| second * SECOND_NS;
        assert!(limit.note(second(1)) && limit.note(second(30)));
        assert!(!limit.note(second(59)));
        assert!(limit.note(second(61)), "the first was a minute ago");
        assert!(!limit.note(second(62)));
        limit.forget();
        assert!(limit.note(second(63)));
    }
}
