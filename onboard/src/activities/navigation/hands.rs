//! Whether somebody drives the robot by hand, and what is wanted.

use description::geometry::Twist2;
use description::robot::Teleop;
use skills::navigator::ByHand;

use crate::realtime::clock::MILLISECOND_NS;
use crate::symbols::values::{Mode, RobotMode, TeleopWish};

/// Whose hands the robot is in.
///
/// The supervisor puts it into the hands of a session, and takes it out of them. After that nothing is driven until the
/// supervisor says that the robot runs: a robot that was let go does not drive on by itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hands {
    on: bool,
    /// What the session wants, and not another one.
    wish: Option<TeleopWish>,
    /// Nobody knows where the robot stands.
    lost: bool,
}

impl Hands {
    pub(super) fn hear(&mut self, mode: &RobotMode, wish: &TeleopWish) {
        let session = mode.teleop;
        if session != 0 {
            self.on = true;
        } else if mode.mode == Mode::Running as u64 {
            self.on = false;
        }
        let own = session != 0 && wish.session == session && wish.open != 0;
        self.wish = own.then_some(*wish);
        self.lost = mode.lost != 0;
    }

    pub(super) fn robot_is_lost(&self) -> bool {
        self.lost
    }

    pub(super) fn are_on(&self) -> bool {
        self.on
    }

    /// What is wanted; to stand, when that was heard too long ago. `None` when nobody drives by hand.
    pub(super) fn wish(&self, teleop: &Teleop, now_ns: u64) -> Option<ByHand> {
        let deadline_ns = u64::from(teleop.deadline_ms) * MILLISECOND_NS;
        let fresh = |wish: &TeleopWish| now_ns.saturating_sub(wish.heard_ns) <= deadline_ns;
        let fresh = self.wish.filter(fresh);
        let limit_m_s = match self.lost {
            // Where navigation takes it to be, it need not be.
            true => teleop.creep_m_s.min(teleop.speed_m_s),
            false => teleop.speed_m_s,
        };
        self.on.then(|| ByHand {
            wish: fresh.map_or(Twist2::default(), |wish| wish.wish),
            limit_m_s,
            creep_m_s: teleop.creep_m_s,
            without_borders: fresh.is_some_and(|wish| wish.without_borders != 0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEADLINE_NS: u64 = 250 * MILLISECOND_NS;

    fn mode(mode: Mode, teleop: u64) -> RobotMode {
        RobotMode {
            mode: mode as u64,
            teleop,
            ..RobotMode::default()
        }
    }

    fn wish(session: u64, open: u64) -> TeleopWish {
        TeleopWish {
            session,
            open,
            heard_ns: 1_000,
            wish: Twist2::new(0.1, 0.2),
            without_borders: 1,
        }
    }

    fn speed_m_s(hands: &Hands, now_ns: u64) -> Option<f64> {
        let by_hand = hands.wish(&Teleop::default(), now_ns)?;
        assert_eq!(by_hand.without_borders, by_hand.wish.v_m_s != 0.0);
        Some(by_hand.wish.v_m_s)
    }

    #[test]
    fn a_wish_is_good_until_its_deadline_and_of_the_session_alone() {
        let mut hands = Hands::default();
        hands.hear(&mode(Mode::Running, 0), &wish(1, 1));
        assert_eq!(speed_m_s(&hands, 1_000), None, "nobody drives by hand");
        hands.hear(&mode(Mode::Teleop, 1), &wish(1, 1));
        assert_eq!(speed_m_s(&hands, 1_000 + DEADLINE_NS), Some(0.1));
        assert_eq!(speed_m_s(&hands, 1_001 + DEADLINE_NS), Some(0.0));
        for (other, why) in [(wish(1, 0), "closed"), (wish(2, 1), "another session")] {
            hands.hear(&mode(Mode::Teleop, 1), &other);
            assert_eq!(speed_m_s(&hands, 1_000), Some(0.0), "{why}");
        }
    }

    #[test]
    fn a_robot_that_was_let_go_stands_until_it_is_sent_on() {
        let mut hands = Hands::default();
        hands.hear(&mode(Mode::Teleop, 1), &wish(1, 1));
        for still in [Mode::Stopped, Mode::Paused, Mode::Ending] {
            hands.hear(&mode(still, 0), &wish(1, 1));
            assert_eq!(speed_m_s(&hands, 1_000), Some(0.0));
        }
        hands.hear(&mode(Mode::Running, 0), &wish(1, 1));
        assert_eq!(speed_m_s(&hands, 1_000), None);
    }
}
