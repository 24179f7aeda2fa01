//! How exactly a robot stopped where its skill says: at a wall, at a pose, before an area.

use config::SiteConfig;
use description::site::{ControllerConfig, FsmConfig, FsmState, MonitorKind, StopPlace};
use sim::world::{Footprint, Pose};

use crate::lanes::lane_of;
use crate::shapes::{region, segment};

/// What a robot stopped at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopKind {
    /// A wall.
    Dock,
    /// A pose.
    Pose,
    /// The border of an area.
    Border,
}

/// Whether a robot that went from one state of its machine to another had stopped where the first one's skill stops it. It says so
/// by the event of a finished manoeuvre. Whoever else sends it on takes it for stopped because it `stands`, which is no stop where
/// something `kept` it from driving; and a robot that has strayed from its lane, or starts anew, did not stop there.
pub(super) fn has_stopped(
    site: &SiteConfig,
    fsm: &FsmConfig,
    from: &str,
    to: &str,
    (stands, kept): (bool, bool),
) -> bool {
    let between = { fsm.transitions.iter() }.filter(|one| one.from == from && one.to == to);
    let mut events = between.map(|one| site.monitor(&one.on).map(|monitor| &monitor.kind));
    events.any(|kind| match kind {
        Some(MonitorKind::ManoeuvreDone) => true,
        Some(MonitorKind::Deviation { .. }) => false,
        _ => stands && !kept,
    })
}

/// How far off it stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopError {
    /// At what.
    pub kind: StopKind,
    /// Of a wall or a border, positive when too far from it; of a pose, the distance.
    pub error_m: f64,
}

impl StopError {
    /// Where the robot stands at the end of a state against where the state's skill should have stopped it; `None`
    /// for skills that do not stop anywhere in particular. `instructed` is the pose that came with the state's event.
    #[must_use]
    pub fn of(
        site: &SiteConfig,
        state: &FsmState,
        instructed: Option<&Pose>,
        footprint: &Footprint,
        pose: &Pose,
    ) -> Option<Self> {
        let at_pose = |x_m: f64, y_m: f64| Self {
            kind: StopKind::Pose,
            error_m: (pose.x_m - x_m).hypot(pose.y_m - y_m),
        };
        let floor = footprint.at(pose);
        match &site.skill(&state.skill)?.controller {
            ControllerConfig::Dock { distance_m } => {
                let wall = site.wall(lane_of(site, state)?.end_wall.as_ref()?)?;
                let gap_m = floor.distance_to_segment_m(&segment(wall));
                Some(Self {
                    kind: StopKind::Dock,
                    error_m: gap_m - distance_m,
                })
            }
            ControllerConfig::StopAt {
                place: StopPlace::Pose(wanted),
            } => Some(at_pose(wanted.x_m, wanted.y_m)),
            ControllerConfig::StopAt {
                place: StopPlace::Instructed,
            } => instructed.map(|wanted| at_pose(wanted.x_m, wanted.y_m)),
            ControllerConfig::StopAt {
                place: StopPlace::BeforeArea { area, margin_m },
            } => Some(Self {
                kind: StopKind::Border,
                error_m: floor.distance_to_rectangle_m(&region(&site.area(area)?.region))
                    - margin_m,
            }),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn who_is_sent_on_while_it_is_kept_from_driving_has_not_stopped() {
        let scenario = testing::scenario("course");
        let fsm = &scenario.robots[0].fsm;
        let stopped = |from, to, kept| has_stopped(&scenario.site, fsm, from, to, (true, kept));
        // By its operator's "go".
        assert!(stopped("stop-6", "drive-6", false));
        assert!(!stopped("stop-6", "drive-6", true), "its bus may be lost");
        let on_its_way = has_stopped(&scenario.site, fsm, "stop-6", "drive-6", (false, false));
        assert!(!on_its_way, "it was sent on before");
        // It says itself that it is done.
        assert!(stopped("park-5", "rest-5", true));
        assert!(!stopped("park-5", "halt-5", false), "it strayed");
        assert!(!stopped("stop-6", "beside-1", false), "it starts anew");
    }
}
