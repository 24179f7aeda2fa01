//! A robot that stands and asks its tubes.

use super::world::{MS, Robot, SMALL, Thing, corridor, urg};
use crate::tubes::{Adapted, MotionTubes, StopRules, TubeSet};
use description::geometry::{MotionCommand, Point2, Pose2, Twist2};
use description::robot::{AdaptPolicy, Horizon, Tubes};

/// Tubes ahead and behind, for a sensor with little noise.
pub(super) fn parameters() -> Tubes {
    Tubes {
        backward_horizons: vec![Horizon {
            horizon_s: 1.5,
            speed_m_s: 0.10,
        }],
        augment_m: 0.045,
        ..Tubes::default()
    }
}

/// Keeps to what is wanted within the band, and stops otherwise.
pub(super) fn without_detours() -> AdaptPolicy {
    AdaptPolicy::default()
}

/// Drives around things that stand, as tightly as navigation does.
pub(super) fn with_detours() -> AdaptPolicy {
    let mut policy = AdaptPolicy::default();
    policy.detour.curvature_1_m = 2.5;
    policy
}

pub(super) const AHEAD: MotionCommand = MotionCommand::new(0.4, 0.0);

/// A robot that stands in a world and looks at it.
pub(super) struct Stand {
    pub robot: Robot,
    pub tubes: MotionTubes,
    pub twist: Twist2,
}

impl Stand {
    pub fn new(policy: AdaptPolicy) -> Self {
        Self::made_of(policy, StopRules::default())
    }

    pub fn with_rules(rules: StopRules) -> Self {
        Self::made_of(with_detours(), rules)
    }

    fn made_of(policy: AdaptPolicy, rules: StopRules) -> Self {
        let (set, _) = TubeSet::generate(&parameters(), &SMALL, &urg()).unwrap();
        Self {
            robot: Robot::new(Pose2::new(3.0, -0.5, 0.0), urg()),
            tubes: MotionTubes::new(set, policy, rules).unwrap(),
            twist: Twist2::default(),
        }
    }

    /// Scans for a time, ten a second; gives the adaptation after each.
    pub fn look(
        &mut self,
        things: &[Thing],
        wanted: MotionCommand,
        duration_s: f64,
    ) -> Vec<Adapted> {
        (0..(duration_s * 10.0).round() as usize)
            .map(|_| {
                self.robot.drive(self.twist, 0.1);
                self.robot.measure(things);
                self.tubes
                    .observe(&self.robot.scan, self.robot.now_ns)
                    .unwrap();
                self.ask(wanted, 0)
            })
            .collect()
    }

    pub fn ask(&mut self, wanted: MotionCommand, later_ms: u64) -> Adapted {
        self.tubes
            .adapt(wanted, self.twist, self.robot.now_ns + later_ms * MS)
    }

    /// In the open corridor, ready to drive, with no way around things.
    pub fn ready() -> Self {
        let mut stand = Self::new(without_detours());
        stand.look(&corridor(), AHEAD, 2.5);
        stand
    }
}

pub(super) fn with_disc(x_m: f64, y_m: f64, radius_m: f64) -> Vec<Thing> {
    let mut things = corridor();
    things.push(Thing::Disc {
        centre: Point2::new(x_m, y_m),
        radius_m,
    });
    things
}
