//! A robot that stands and asks its tubes.

use super::world::{MS, Robot, SMALL, Thing, corridor, urg};
use crate::tubes::{AdaptPolicy, Adapted, DetourPolicy, MotionTubes, TubeParameters, TubeSet};
use description::geometry::{MotionCommand, Point2, Pose2, Twist2};

/// Keeps to what is wanted within the band, and stops otherwise.
pub(super) fn without_detours() -> AdaptPolicy {
    AdaptPolicy {
        detour: DetourPolicy {
            curvature_1_m: 0.0,
            ..DetourPolicy::default()
        },
        ..AdaptPolicy::default()
    }
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
        let (set, _) = TubeSet::generate(&TubeParameters::default(), &SMALL, &urg()).unwrap();
        Self {
            robot: Robot::new(Pose2::new(3.0, -0.5, 0.0), urg()),
            tubes: MotionTubes::new(set, policy).unwrap(),
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
