//! One state under consideration: what the checks of a controller may ask.

use crate::control::Track;
use crate::map::{LaneGeometry, SemanticMap};
use crate::perception::FeatureSet;
use crate::schedule::graph::Graph;
use crate::schedule::room::wall_in_the_way;
use coordination::fsm::StateId;
use description::geometry::{Footprint, Point2};
use description::keys::KeyError;
use description::site::{FsmState, SkillConfig};

/// Between the robot's side and a wall that it passes.
const BESIDE_M: f64 = 0.05;

/// What the robot can do, as far as plans depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotLimits {
    /// Fastest.
    pub max_speed_m_s: f64,
    /// Tightest curve.
    pub max_curvature_1_m: f64,
    /// Outline.
    pub footprint: Footprint,
}

/// The lanes and the speed limit of a controller in its state.
#[derive(Clone, Copy, Debug)]
pub(in crate::schedule) struct Lanes {
    pub lane: Option<usize>,
    pub from_lane: Option<usize>,
    pub end_lane: Option<usize>,
    pub speed_limit_m_s: f64,
}

/// A state with its skill, the states around it, and the robot.
pub(in crate::schedule) struct Case<'a> {
    pub graph: &'a Graph<'a>,
    pub robot: &'a RobotLimits,
    pub state: StateId,
    pub name: &'a str,
    pub skill: &'a SkillConfig,
    /// What the skill tracks.
    pub tracks: FeatureSet,
    /// What the skill tracks or searches.
    pub features: FeatureSet,
    /// The lane of the state, if it has one.
    pub own_lane: Option<usize>,
}

impl<'a> Case<'a> {
    pub fn new(
        graph: &'a Graph<'a>,
        robot: &'a RobotLimits,
        state: StateId,
        name: &'a str,
    ) -> Self {
        let skill = graph.skill(state);
        let kind = graph.site.perception_kinds.get(&skill.perception);
        let of = |list: Option<&Vec<_>>| list.into_iter().flatten().collect::<FeatureSet>();
        let tracks = of(kind.map(|kind| &kind.tracks));
        Self {
            graph,
            robot,
            state,
            name,
            skill,
            tracks,
            features: tracks.union(of(kind.map(|kind| &kind.searches))),
            own_lane: graph.of(state).lane,
        }
    }

    /// Whether the point lies on the floor that the state takes.
    pub fn takes(&self, point: Point2) -> bool {
        let fsm = self.graph.site.fsm.get(self.graph.role);
        let state = fsm.and_then(|fsm| fsm.state(self.name));
        let regions = state.into_iter().flat_map(FsmState::areas);
        regions
            .filter_map(|area| self.graph.site.area(area))
            .any(|area| area.region.contains(point))
    }

    pub fn map(&self) -> &SemanticMap {
        self.graph.map
    }

    pub fn geometry(&self, lane: usize) -> &LaneGeometry {
        &self.graph.map.lanes()[lane]
    }

    /// The state's lane, which the controller cannot do without.
    pub fn lane(&self) -> Result<usize, KeyError> {
        self.own_lane.ok_or_else(|| self.no_lane("a lane"))
    }

    /// Nothing but the lane that it drives on.
    pub fn on_lane(&self, lane: Option<usize>) -> Lanes {
        Lanes {
            lane,
            from_lane: None,
            end_lane: lane,
            speed_limit_m_s: self.graph.speed_limit_m_s(self.state),
        }
    }

    pub fn no_lane(&self, wanted: &str) -> KeyError {
        let found = format!(
            "state `{}`, which needs {wanted}, and neither its area nor its neighbours give one",
            self.name
        );
        KeyError::new(self.key(), found, wanted)
    }

    pub fn impossible(&self, reason: impl std::fmt::Display) -> KeyError {
        let found = format!("state `{}`, which cannot be driven: {reason}", self.name);
        KeyError::new(
            self.key(),
            found,
            "a manoeuvre that this robot can drive here",
        )
    }

    fn key(&self) -> String {
        format!("fsm.{}.states.{}", self.graph.role, self.name)
    }

    /// What does not fit in a key of the skill.
    pub fn skill_error(&self, key: &str, found: String, expected: String) -> KeyError {
        KeyError::new(format!("skills.{}.{key}", self.skill.id), found, expected)
    }

    /// The robot must be able to drive the curve.
    pub fn check_radius(&self, radius_m: f64) -> Result<(), KeyError> {
        let tightest_m = 1.0 / self.robot.max_curvature_1_m;
        if radius_m >= tightest_m * (1.0 - 1e-9) {
            return Ok(());
        }
        let expected =
            format!("at least {tightest_m:.3} m, for the robot's `navigation.max_curvature_1_m`");
        Err(self.skill_error("radius_m", format!("{radius_m:?}"), expected))
    }

    /// Beside a lane there must be room between the walls.
    pub fn check_offset(&self, lane: usize, offset_m: f64) -> Result<(), KeyError> {
        let lane = self.geometry(lane);
        let footprint = &self.robot.footprint;
        let middle = (lane.line.a + lane.line.b) * 0.5;
        for (wall, side, half_m) in [
            (lane.left, 1.0, footprint.left_m),
            (lane.right, -1.0, footprint.right_m),
        ] {
            let Some(wall) = wall else { continue };
            let room_m = wall.line.lateral_m(middle).abs() - half_m - side * offset_m;
            if room_m < BESIDE_M {
                let wall = &self.map().walls()[wall.index].id;
                return Err(self.impossible(format!(
                    "{offset_m} m beside lane `{}` it would be {room_m:.2} m from wall `{wall}`, expected {BESIDE_M} m or more",
                    lane.id
                )));
            }
        }
        Ok(())
    }

    /// The footprint must not come to a wall on its way along a track.
    pub fn check_room(&self, track: &Track) -> Result<(), KeyError> {
        let walls = { self.map().walls().iter() }.map(|wall| (wall.id.as_str(), wall.line));
        match wall_in_the_way(track, &self.robot.footprint, walls) {
            None => Ok(()),
            Some(wall) => Err(self.impossible(format!("on its way it would touch wall `{wall}`"))),
        }
    }
}
