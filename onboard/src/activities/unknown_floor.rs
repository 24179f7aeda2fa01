//! A robot that is to back out over floor that it knows nothing of.
//!
//! Its lidar looks ahead: what is behind, it knows from having driven there. A process that starts anew, after its computer was off
//! or its drive without power, knows nothing, and as long as the robot stands it sees nothing more. It cannot turn on the spot
//! either, and where it is to back out there is something ahead. So it waits for people, who see what is behind it.

use skills::tubes::Reason;

use crate::realtime::clock::SECOND_NS;

/// It may stand so for a moment, on its way; longer, and it says what it needs.
const WAITS_NS: u64 = 3 * SECOND_NS;

/// Notices it, and keeps the robot standing until an operator resets it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UnknownFloor {
    since_ns: Option<u64>,
    waits: bool,
}

impl UnknownFloor {
    /// Whether the robot waits for people, when it does not drive as wanted for this reason.
    pub(super) fn judge(&mut self, reason: Reason, now_ns: u64) -> bool {
        if reason == Reason::UnknownFloor {
            let since_ns = *self.since_ns.get_or_insert(now_ns);
            self.waits |= now_ns.saturating_sub(since_ns) >= WAITS_NS;
        } else {
            self.since_ns = None;
        }
        self.waits
    }

    /// Somebody has said what is behind the robot, and whether that is enough shows with the next scan; or drives by hand, and is
    /// told why it stands.
    pub(super) fn told(&mut self) {
        self.since_ns = None;
    }

    /// It may go on. If it still knows nothing, it waits again at once.
    pub(super) fn reset(&mut self) {
        self.waits = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_waits_for_a_word_and_a_reset_and_a_reset_alone_is_of_no_use() {
        let mut floor = UnknownFloor::default();
        let at = |time_s: f64| (time_s * 1e9) as u64;
        assert!(!floor.judge(Reason::UnknownFloor, at(1.0)));
        assert!(!floor.judge(Reason::None, at(3.9)), "it was for a moment");
        assert!(!floor.judge(Reason::UnknownFloor, at(5.0)));
        assert!(!floor.judge(Reason::UnknownFloor, at(7.9)));
        assert!(floor.judge(Reason::UnknownFloor, at(8.0)));
        floor.reset();
        assert!(floor.judge(Reason::UnknownFloor, at(8.1)));
        // The word is for the next scan, and does not set the robot in motion.
        floor.told();
        assert!(floor.judge(Reason::UnknownFloor, at(8.2)));
        assert!(floor.judge(Reason::Blocked, at(8.3)));
        assert!(floor.judge(Reason::Resuming, at(8.3)));
        floor.reset();
        assert!(!floor.judge(Reason::Resuming, at(8.4)));
        assert!(!floor.judge(Reason::None, at(20.0)));
        for second in 30..40 {
            floor.told();
            let waits = floor.judge(Reason::UnknownFloor, at(f64::from(second)));
            assert!(!waits, "who drives by hand is not called");
        }
    }
}
