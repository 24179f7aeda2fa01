//! Half a turn onto a lane that runs the other way.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::{Motion, Start};
use super::pace::{Pace, Progress};
use crate::control::{Arrival, Stopping, manoeuvre};
use crate::map::LaneGeometry;
use crate::schedule::graph::Towards;
use description::geometry::{Pose2, Segment};
use description::keys::KeyError;
use description::site::{ControllerConfig, TurnDirection};
use std::f64::consts::PI;

/// A turn may miss its lane by this distance, metres.
const TOLERANCE_M: f64 = 0.05;

/// From [`Schedule::from_lane`](crate::schedule::Schedule::from_lane) onto
/// [`Schedule::lane`](crate::schedule::Schedule::lane), which runs the other way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UTurn {
    /// To which side.
    pub direction: TurnDirection,
    /// Of `base_link`'s path.
    pub radius_m: f64,
}

impl UTurn {
    pub(super) fn plan(
        case: &Case,
        direction: TurnDirection,
        radius_m: f64,
    ) -> Result<(Self, Lanes), KeyError> {
        let graph = case.graph;
        let incoming = graph.nearest_lane(case.state, Towards::Before, None);
        let outgoing = { case.own_lane.filter(|lane| Some(*lane) != incoming) }
            .or_else(|| graph.nearest_lane(case.state, Towards::After, incoming))
            .ok_or_else(|| case.no_lane("a lane to turn onto"))?;
        case.check_radius(radius_m)?;
        let u_turn = Self {
            direction,
            radius_m,
        };
        if let Some(incoming) = incoming {
            u_turn.check(case, incoming, outgoing)?;
        }
        let lanes = Lanes {
            from_lane: incoming,
            end_lane: incoming,
            ..case.on_lane(Some(outgoing))
        };
        Ok((u_turn, lanes))
    }

    fn check(self, case: &Case, incoming: usize, outgoing: usize) -> Result<(), KeyError> {
        let (incoming, outgoing) = (case.geometry(incoming), case.geometry(outgoing));
        if incoming.line.lateral_m(outgoing.line.a) * self.direction.sign() <= 0.0 {
            return Err(case.impossible(format!(
                "the U-turn turns away from lane `{}`, which lies on the other side of `{}`",
                outgoing.id, incoming.id
            )));
        }
        self.ends_on_lane(case, incoming, outgoing)?;
        // Where it begins is known when the state before ends at a distance from a wall.
        let begins_m = case.graph.just_before(case.state).find_map(|before| {
            match (&case.graph.skill(before).controller, incoming.end) {
                (&ControllerConfig::EndOfLane { distance_m }, Some(wall)) => {
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
        let (direction, radius_m) = (self.direction, self.radius_m);
        let from = Pose2::new(from.x_m, from.y_m, incoming.direction_rad);
        let max_curvature_1_m = case.robot.max_curvature_1_m;
        let (one, other) = (&incoming.line, &outgoing.line);
        let track = manoeuvre::u_turn(direction, radius_m, max_curvature_1_m, one, other, from)
            .map_err(|error| case.impossible(error))?;
        if begins_m.is_some() {
            case.check_room(&track)?;
        }
        Ok(())
    }
}

impl UTurn {
    /// Half a circle from one lane must end on the next one.
    fn ends_on_lane(
        self,
        case: &Case,
        incoming: &LaneGeometry,
        outgoing: &LaneGeometry,
    ) -> Result<(), KeyError> {
        // To the left of the lane that it comes from.
        let offset_m = incoming.line.lateral_m(outgoing.line.a);
        let turned_m = 2.0 * self.radius_m * self.direction.sign();
        if (offset_m - turned_m).abs() <= TOLERANCE_M {
            return Ok(());
        }
        let found = format!(
            "{:?}, which ends {turned_m:.3} m to the left of lane `{}`",
            self.radius_m, incoming.id
        );
        let hand = if offset_m >= 0.0 { "left" } else { "right" };
        let expected = format!(
            "a turn onto lane `{}`, {:.3} m to the {hand}: radius {:.3}",
            outgoing.id,
            offset_m.abs(),
            offset_m.abs() / 2.0
        );
        Err(case.skill_error("radius_m", found, expected))
    }
}

impl Behaviour for UTurn {
    fn motion(&self, start: &Start) -> Motion {
        Motion::onto_lane(start, 0.0, Arrival::TURN, |onto| {
            let at = start.pose.position();
            // Without a lane that it comes from, it comes along a line beside the outgoing one.
            let beside = manoeuvre::beside(onto, onto.lateral_m(at));
            let back = Segment::new(beside.b, beside.a);
            let from = start.from.unwrap_or(&back);
            let (direction, radius_m) = (self.direction, self.radius_m);
            let max_curvature_1_m = start.max_curvature_1_m;
            manoeuvre::u_turn(
                direction,
                radius_m,
                max_curvature_1_m,
                from,
                onto,
                start.pose,
            )
        })
    }

    fn pace(&self, motion: &Motion, _stopping: &mut Stopping, _now: &Progress) -> Pace {
        Pace::until_on_lane(motion)
    }

    fn least_way_m(&self, _turn_rad: Option<f64>) -> f64 {
        PI * self.radius_m
    }
}
