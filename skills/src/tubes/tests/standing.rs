//! What becomes of a wish to stand.

use super::stand::{Stand, with_disc};
use crate::tubes::{Reason, Verdict};
use description::geometry::{MotionCommand, Twist2};

#[test]
fn who_wants_to_stand_is_not_blocked() {
    let mut stand = Stand::ready();
    let walled = with_disc(3.6, -0.5, 0.2);
    for adapted in stand.look(&walled, MotionCommand::STOP, 1.0) {
        assert_eq!(
            (adapted.verdict, adapted.reason),
            (Verdict::Free, Reason::None)
        );
        assert_eq!(adapted.command.speed_m_s, 0.0);
    }
    assert_eq!(stand.tubes.counters().blocked_stops, 0);
}

/// As when a hand lets go because of what steps in front: the wheels would take twice the way.
#[test]
fn who_wants_to_stand_and_rolls_into_something_brakes_hard() {
    for (speed_m_s, at_x_m, reason) in [
        (0.4, 3.6, Reason::TooFast),
        (0.4, 5.0, Reason::None),
        (-0.2, 2.5, Reason::TooFast),
        (0.01, 3.6, Reason::None),
    ] {
        let mut stand = Stand::ready();
        stand.look(&with_disc(at_x_m, -0.5, 0.2), MotionCommand::STOP, 0.1);
        stand.twist = Twist2::new(speed_m_s, 0.0);
        let adapted = stand.ask(MotionCommand::STOP, 10);
        assert_eq!(adapted.reason, reason, "{speed_m_s} m/s, {at_x_m} m");
        assert_eq!(
            adapted.verdict == Verdict::Stopped,
            reason == Reason::TooFast
        );
        assert_eq!(adapted.command.speed_m_s, 0.0);
    }
}
