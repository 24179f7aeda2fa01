//! Whether a session hears the mediator.
//!
//! A mediator that closes its session while a robot connects may leave it a link that lives, and carries nothing (zenoh 1.10): the
//! network sees no reason to connect again.

use crate::realtime::clock::SECOND_NS;

/// Nothing is heard for so long before another session is tried.
const PATIENCE_NS: u64 = 10 * SECOND_NS;
/// Each one in vain makes it twice as long, up to this.
const LONGEST_PATIENCE_NS: u64 = 16 * PATIENCE_NS;

/// What a robot has heard of its mediator, and since when no more.
#[derive(Clone, Debug)]
pub(super) struct Hearing {
    /// Messages so far.
    heard: u64,
    since_ns: u64,
    patience_ns: u64,
}

impl Hearing {
    pub(super) fn new(now_ns: u64) -> Self {
        Self {
            heard: 0,
            since_ns: now_ns,
            patience_ns: PATIENCE_NS,
        }
    }

    /// Whether another session should be tried; `heard`: messages so far. A network without a link looks for one by itself.
    pub(super) fn is_in_vain(
        &mut self,
        heard: u64,
        is_linked: impl FnOnce() -> bool,
        now_ns: u64,
    ) -> bool {
        if heard != self.heard {
            *self = Self {
                heard,
                ..Self::new(now_ns)
            };
        }
        if now_ns.saturating_sub(self.since_ns) < self.patience_ns {
            return false;
        }
        self.since_ns = now_ns;
        let is_linked = is_linked();
        if is_linked {
            self.patience_ns = (2 * self.patience_ns).min(LONGEST_PATIENCE_NS);
        }
        is_linked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_over_which_nothing_is_heard_is_given_up_less_and_less_often() {
        let mut hearing = Hearing::new(0);
        let mut tried_s = Vec::new();
        for now_s in 0..700 {
            if hearing.is_in_vain(0, || true, now_s * SECOND_NS) {
                tried_s.push(now_s);
            }
        }
        assert_eq!(tried_s, [10, 30, 70, 150, 310, 470, 630]);
        assert!(!hearing.is_in_vain(1, || true, 900 * SECOND_NS), "heard");
        assert!(!hearing.is_in_vain(1, || true, 909 * SECOND_NS));
        assert!(hearing.is_in_vain(1, || true, 910 * SECOND_NS));
    }

    #[test]
    fn without_a_link_the_network_goes_on_looking_for_one() {
        let mut hearing = Hearing::new(0);
        for now_s in 0..100 {
            assert!(!hearing.is_in_vain(0, || false, now_s * SECOND_NS));
        }
        assert!(
            !hearing.is_in_vain(0, || true, 99 * SECOND_NS),
            "a new link"
        );
        assert!(hearing.is_in_vain(0, || true, 100 * SECOND_NS));
    }
}
