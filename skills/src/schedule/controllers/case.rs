//! One state under consideration: what the checks of a controller may ask.

use crate::control::Track;
use crate::map::{LaneGeometry, SemanticMap};
use crate::schedule::error::ScheduleError;
use crate::schedule::graph::Graph;
use crate::schedule::room::wall_in_the_way;
use crate::schedule::setup::SkillSetup;
use coordination::fsm::StateId;
use description::geometry::Footprint;

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
    pub skill: &'a SkillSetup,
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
        Self {
            graph,
            robot,
            state,
            name,
            skill: graph.skill(state),
            own_lane: graph.of(state).lane,
        }
    }

    pub fn map(&self) -> &SemanticMap {
        self.graph.map
    }

    pub fn geometry(&self, lane: usize) -> &LaneGeometry {
        &self.graph.map.lanes()[lane]
    }

    /// The state's lane, which the controller cannot do without.
    pub fn lane(&self) -> Result<usize, ScheduleError> {
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

    pub fn no_lane(&self, wanted: &'static str) -> ScheduleError {
        ScheduleError::NoLane {
            state: self.name.to_owned(),
            wanted,
        }
    }

    pub fn impossible(&self, reason: impl ToString) -> ScheduleError {
        ScheduleError::Manoeuvre {
            state: self.name.to_owned(),
            reason: reason.to_string(),
        }
    }

    /// Beside a lane there must be room between the walls.
    pub fn check_offset(&self, lane: usize, offset_m: f64) -> Result<(), ScheduleError> {
        self.skill.check_finite("offset", offset_m)?;
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
    pub fn check_room(&self, track: &Track) -> Result<(), ScheduleError> {
        let walls = { self.map().walls().iter() }.map(|wall| (wall.id.as_str(), wall.line));
        match wall_in_the_way(track, &self.robot.footprint, walls) {
            None => Ok(()),
            Some(wall) => Err(self.impossible(format!("on its way it would touch wall `{wall}`"))),
        }
    }
}

impl SkillSetup {
    pub(in crate::schedule) fn check_finite(
        &self,
        what: &'static str,
        found: f64,
    ) -> Result<(), ScheduleError> {
        self.check(what, "a number", found, found.is_finite())
    }

    pub(in crate::schedule) fn check_positive(
        &self,
        what: &'static str,
        found: f64,
    ) -> Result<(), ScheduleError> {
        let sound = found.is_finite() && found > 0.0;
        self.check(what, "positive", found, sound)
    }

    pub(in crate::schedule) fn check_not_negative(
        &self,
        what: &'static str,
        found: f64,
    ) -> Result<(), ScheduleError> {
        let sound = found.is_finite() && found >= 0.0;
        self.check(what, "zero or more", found, sound)
    }

    pub(in crate::schedule) fn check(
        &self,
        what: &'static str,
        expected: &'static str,
        found: f64,
        sound: bool,
    ) -> Result<(), ScheduleError> {
        if sound {
            return Ok(());
        }
        Err(ScheduleError::Parameter {
            skill: self.id.clone(),
            what,
            expected,
            found,
        })
    }
}
