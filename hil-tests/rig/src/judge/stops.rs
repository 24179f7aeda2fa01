//! How exactly a robot stopped where its skill says: at a wall, at a pose, before an area.

use config::{ControllerConfig, FsmState, SiteConfig, StopPlace};
use sim::world::{Footprint, Pose, Rectangle};

use super::view::segment;

/// Docking: from the wanted distance.
const DOCK_M: f64 = 0.02;
/// A pose, as far as the robot knows where it is: along a corridor nothing tells it.
const POSE_M: f64 = 0.03;
/// Before an area: as near to its border as wanted, and this much farther or nearer.
const BORDER_M: f64 = 0.07;

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

/// How far off it stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopError {
    /// At what.
    pub kind: StopKind,
    /// Positive: too far from it, or, of a pose, the distance.
    pub error_m: f64,
}

impl StopError {
    /// The largest error that is good.
    #[must_use]
    pub fn limit_m(&self) -> f64 {
        match self.kind {
            StopKind::Dock => DOCK_M,
            StopKind::Pose => POSE_M,
            StopKind::Border => BORDER_M,
        }
    }

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
                let area = site.area(&state.area);
                let lane = state
                    .lane
                    .as_ref()
                    .or(area.and_then(|area| area.lane.as_ref()))?;
                let wall = site.wall(site.lane(lane)?.end_wall.as_ref()?)?;
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

/// A region as the world has it.
pub(crate) fn region(rect: &config::Rect) -> Rectangle {
    let [low, high] = [rect.min_m, rect.max_m];
    Rectangle {
        corners_m: [high, [low[0], high[1]], low, [high[0], low[1]]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_rectangles_with_an_inside() {
        let rectangle = region(&config::Rect {
            min_m: [1.0, 2.0],
            max_m: [3.0, 5.0],
        });
        assert!(rectangle.contains([2.0, 3.0]) && !rectangle.contains([0.9, 3.0]));
    }
}
