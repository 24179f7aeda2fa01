//! Finds the lanes of each controller and checks that the robot can do what is asked of it.

use super::compile::RobotLimits;
use super::graph::{Graph, Towards};
use super::room::wall_in_the_way;
use super::{Controller, ControllerSetup, ScheduleError, SkillSetup};
use crate::control::manoeuvre::{self, Fillet};
use crate::control::{EndOfLane, Track, TrackError, TurnDirection};
use crate::map::{LaneGeometry, SemanticMap};
use coordination::fsm::StateId;
use description::geometry::Pose2;

/// Between the robot's side and a wall that it passes.
const BESIDE_M: f64 = 0.05;

/// A controller with its lanes.
pub(super) struct Plan {
    pub(super) controller: Controller,
    pub(super) lane: Option<usize>,
    pub(super) from_lane: Option<usize>,
    pub(super) end_lane: Option<usize>,
    pub(super) speed_limit_m_s: f64,
}

/// Makes plans for the states of a machine.
pub(super) struct Manoeuvres<'a> {
    pub(super) graph: &'a Graph<'a>,
    pub(super) robot: &'a RobotLimits,
}

/// One state under consideration.
pub(super) struct Case<'a> {
    pub(super) state: StateId,
    name: &'a str,
    pub(super) skill: &'a SkillSetup,
    pub(super) lane: Option<usize>,
}

impl Case<'_> {
    pub(super) fn no_lane(&self, wanted: &'static str) -> ScheduleError {
        ScheduleError::NoLane {
            state: self.name.to_owned(),
            wanted,
        }
    }

    pub(super) fn impossible(&self, reason: impl ToString) -> ScheduleError {
        ScheduleError::Manoeuvre {
            state: self.name.to_owned(),
            reason: reason.to_string(),
        }
    }

    pub(super) fn lane(&self) -> Result<usize, ScheduleError> {
        self.lane.ok_or_else(|| self.no_lane("a lane"))
    }
}

impl Manoeuvres<'_> {
    pub(super) fn plan(&self, state: StateId, name: &str) -> Result<Plan, ScheduleError> {
        let skill = self.graph.skill(state);
        let case = Case {
            state,
            name,
            skill,
            lane: self.graph.of(state).lane,
        };
        match skill.controller {
            ControllerSetup::Stop => Ok(self.on_lane(&case, Controller::Stop, case.lane)),
            ControllerSetup::Corridor { offset_m } => self.corridor(&case, offset_m),
            ControllerSetup::EndOfLane {
                distance_m,
                exit_speed_m_s,
            } => self.end_of_lane(&case, distance_m, exit_speed_m_s),
            ControllerSetup::UTurn {
                direction,
                radius_m,
            } => self.u_turn(&case, direction, radius_m),
            ControllerSetup::Shift { offset_m, within_m } => self.shift(&case, offset_m, within_m),
            ControllerSetup::Turn { radius_m } => self.turn(&case, radius_m),
            ControllerSetup::StopAt { ref target } => self.stop_at(&case, target),
            ControllerSetup::Dock { distance_m } => self.dock(&case, distance_m),
            ControllerSetup::Creep { distance_m } => self.creep(&case, distance_m),
        }
    }

    pub(super) fn map(&self) -> &SemanticMap {
        self.graph.map
    }

    pub(super) fn lane(&self, index: usize) -> &LaneGeometry {
        &self.graph.map.lanes()[index]
    }

    pub(super) fn on_lane(&self, case: &Case, controller: Controller, lane: Option<usize>) -> Plan {
        Plan {
            controller,
            lane,
            from_lane: None,
            end_lane: lane,
            speed_limit_m_s: self.graph.speed_limit_m_s(case.state),
        }
    }

    fn corridor(&self, case: &Case, offset_m: f64) -> Result<Plan, ScheduleError> {
        let lane = case.lane()?;
        self.check_offset(case, lane, offset_m)?;
        Ok(self.on_lane(case, Controller::Corridor { offset_m }, Some(lane)))
    }

    /// Beside a lane there must be room between the walls.
    pub(super) fn check_offset(
        &self,
        case: &Case,
        lane: usize,
        offset_m: f64,
    ) -> Result<(), ScheduleError> {
        finite(case.skill, "offset", offset_m)?;
        let lane = self.lane(lane);
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
                return Err(case.impossible(format!(
                    "{offset_m} m beside lane `{}` it would be {room_m:.2} m from wall `{wall}`, expected {BESIDE_M} m or more",
                    lane.id
                )));
            }
        }
        Ok(())
    }

    fn end_of_lane(
        &self,
        case: &Case,
        distance_m: f64,
        exit_speed_m_s: Option<f64>,
    ) -> Result<Plan, ScheduleError> {
        positive(case.skill, "distance", distance_m)?;
        let lane = case.lane()?;
        if self.lane(lane).end.is_none() {
            return Err(case.no_lane("a lane that a wall closes"));
        }
        let exit_speed_m_s =
            exit_speed_m_s.unwrap_or_else(|| self.graph.exit_speed_m_s(case.state));
        let sound = exit_speed_m_s.is_finite() && exit_speed_m_s >= 0.0;
        parameter(
            case.skill,
            "exit speed",
            "zero or more",
            exit_speed_m_s,
            sound,
        )?;
        let controller = Controller::EndOfLane(EndOfLane {
            distance_m,
            exit_speed_m_s,
        });
        Ok(self.on_lane(case, controller, Some(lane)))
    }

    fn u_turn(
        &self,
        case: &Case,
        direction: TurnDirection,
        radius_m: f64,
    ) -> Result<Plan, ScheduleError> {
        positive(case.skill, "radius", radius_m)?;
        let incoming = self.graph.nearest_lane(case.state, Towards::Before, None);
        let outgoing = case
            .lane
            .filter(|lane| Some(*lane) != incoming)
            .or_else(|| {
                self.graph
                    .nearest_lane(case.state, Towards::After, incoming)
            })
            .ok_or_else(|| case.no_lane("a lane to turn onto"))?;
        manoeuvre::check_radius(radius_m, self.robot.max_curvature_1_m)
            .map_err(|error| case.impossible(error))?;
        if let Some(incoming) = incoming {
            self.check_u_turn(case, direction, radius_m, incoming, outgoing)?;
        }
        let controller = Controller::UTurn {
            direction,
            radius_m,
        };
        Ok(Plan {
            from_lane: incoming,
            end_lane: incoming,
            ..self.on_lane(case, controller, Some(outgoing))
        })
    }

    fn check_u_turn(
        &self,
        case: &Case,
        direction: TurnDirection,
        radius_m: f64,
        incoming: usize,
        outgoing: usize,
    ) -> Result<(), ScheduleError> {
        let (incoming, outgoing) = (self.lane(incoming), self.lane(outgoing));
        if incoming.line.lateral_m(outgoing.line.a) * direction.sign() <= 0.0 {
            return Err(ScheduleError::TurnSide {
                state: case.name.to_owned(),
                incoming: incoming.id.clone(),
                outgoing: outgoing.id.clone(),
            });
        }
        // Where it begins is known when the state before ends at a distance from a wall.
        let begins_m = self.graph.just_before(case.state).find_map(|before| {
            match (&self.graph.skill(before).controller, incoming.end) {
                (&ControllerSetup::EndOfLane { distance_m, .. }, Some(wall)) => {
                    let wall_m = wall
                        .line
                        .ray_range_m(incoming.line.a, incoming.direction_rad)?;
                    Some(wall_m - distance_m)
                }
                _ => None,
            }
        });
        let from = incoming.line.a
            + incoming.line.unit() * begins_m.unwrap_or_else(|| incoming.line.length_m());
        let track = manoeuvre::u_turn(direction, radius_m, &incoming.line, &outgoing.line, from)
            .map_err(|error| case.impossible(error))?;
        if begins_m.is_some() {
            self.check_room(case, &track)?;
        }
        Ok(())
    }

    fn check_room(&self, case: &Case, track: &Track) -> Result<(), ScheduleError> {
        let walls = self
            .map()
            .walls()
            .iter()
            .map(|wall| (wall.id.as_str(), wall.line));
        match wall_in_the_way(track, &self.robot.footprint, walls) {
            None => Ok(()),
            Some(wall) => Err(case.impossible(format!("on its way it would touch wall `{wall}`"))),
        }
    }

    fn shift(&self, case: &Case, offset_m: f64, within_m: f64) -> Result<Plan, ScheduleError> {
        positive(case.skill, "length", within_m)?;
        let lane = case.lane()?;
        self.check_offset(case, lane, offset_m)?;
        for before in self.graph.just_before(case.state) {
            let Some(from) = self.graph.of(before).lane else {
                continue;
            };
            let before_m = match self.graph.skill(before).controller {
                ControllerSetup::Corridor { offset_m }
                | ControllerSetup::Shift { offset_m, .. } => offset_m,
                _ => 0.0,
            };
            let (from, to) = (&self.lane(from).line, &self.lane(lane).line);
            let aside_m = to.lateral_m(from.a) + before_m - offset_m;
            manoeuvre::check_beside(from, to)
                .and_then(|()| {
                    manoeuvre::check_shift(aside_m, within_m, self.robot.max_curvature_1_m)
                })
                .map_err(|error| case.impossible(error))?;
        }
        let controller = Controller::Shift { offset_m, within_m };
        Ok(self.on_lane(case, controller, Some(lane)))
    }

    fn turn(&self, case: &Case, radius_m: f64) -> Result<Plan, ScheduleError> {
        positive(case.skill, "radius", radius_m)?;
        let to = case.lane()?;
        let from = self
            .graph
            .nearest_lane(case.state, Towards::Before, Some(to))
            .ok_or_else(|| case.no_lane("a lane to turn from"))?;
        let max_curvature_1_m = self.robot.max_curvature_1_m;
        let (incoming, outgoing) = (&self.lane(from).line, &self.lane(to).line);
        let check = || -> Result<Track, TrackError> {
            manoeuvre::check_radius(radius_m, max_curvature_1_m)?;
            if let Some(fillet) = Fillet::between(incoming, outgoing, radius_m)? {
                fillet.check(outgoing, radius_m)?;
            }
            let start = Pose2::new(incoming.a.x_m, incoming.a.y_m, incoming.direction_rad());
            manoeuvre::turn(radius_m, max_curvature_1_m, incoming, outgoing, start)
        };
        let track = check().map_err(|error| case.impossible(error))?;
        if track.max_curvature_1_m() > 1e-3 {
            self.check_room(case, &track)?;
        }
        Ok(Plan {
            from_lane: Some(from),
            ..self.on_lane(case, Controller::Turn { radius_m }, Some(to))
        })
    }
}

pub(super) fn finite(
    skill: &SkillSetup,
    what: &'static str,
    found: f64,
) -> Result<(), ScheduleError> {
    parameter(skill, what, "a number", found, found.is_finite())
}

pub(super) fn positive(
    skill: &SkillSetup,
    what: &'static str,
    found: f64,
) -> Result<(), ScheduleError> {
    let sound = found.is_finite() && found > 0.0;
    parameter(skill, what, "positive", found, sound)
}

pub(super) fn parameter(
    skill: &SkillSetup,
    what: &'static str,
    expected: &'static str,
    found: f64,
    sound: bool,
) -> Result<(), ScheduleError> {
    if sound {
        return Ok(());
    }
    Err(ScheduleError::Parameter {
        skill: skill.id.clone(),
        what,
        expected,
        found,
    })
}
