//! Any controller, bound to a state.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::corridor::Corridor;
use super::creep::CreepBy;
use super::dock::Dock;
use super::end_of_lane;
use super::shift::Shift;
use super::stop::Stop;
use super::stop_at::StopAt;
use super::turn::Turn;
use super::u_turn::UTurn;
use crate::control::EndOfLane;
use description::keys::KeyError;
use description::site::ControllerConfig;

/// A controller bound to a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller {
    /// Keeps on the lane, or beside it.
    Corridor(Corridor),
    /// Up to the end of the lane.
    EndOfLane(EndOfLane),
    /// Onto a lane that runs the other way.
    UTurn(UTurn),
    /// From beside the lane onto it.
    Shift(Shift),
    /// From one lane onto another, at a junction.
    Turn(Turn),
    /// Along the lane to a place on it.
    StopAt(StopAt),
    /// Up to the wall that closes the lane.
    Dock(Dock),
    /// Straight forward or backward.
    Creep(CreepBy),
    /// Stands still.
    Stop,
}

impl Controller {
    /// Binds what a file says to a state: finds its lanes, and checks that the robot can do what is asked of it.
    pub(in crate::schedule) fn plan(case: &Case) -> Result<(Self, Lanes), KeyError> {
        fn bound<C>(
            wrap: fn(C) -> Controller,
            planned: Result<(C, Lanes), KeyError>,
        ) -> Result<(Controller, Lanes), KeyError> {
            planned.map(|(controller, lanes)| (wrap(controller), lanes))
        }
        match &case.skill.controller {
            ControllerConfig::Stop => Ok((Self::Stop, case.on_lane(case.own_lane))),
            &ControllerConfig::Corridor { offset_m } => {
                bound(Self::Corridor, Corridor::plan(case, offset_m))
            }
            &ControllerConfig::EndOfLane { distance_m } => {
                bound(Self::EndOfLane, end_of_lane::plan(case, distance_m))
            }
            &ControllerConfig::UTurn {
                direction,
                radius_m,
            } => bound(Self::UTurn, UTurn::plan(case, direction, radius_m)),
            &ControllerConfig::Shift { offset_m, within_m } => {
                bound(Self::Shift, Shift::plan(case, offset_m, within_m))
            }
            &ControllerConfig::Turn { radius_m } => bound(Self::Turn, Turn::plan(case, radius_m)),
            ControllerConfig::StopAt { place } => bound(Self::StopAt, StopAt::plan(case, place)),
            &ControllerConfig::Dock { distance_m } => {
                bound(Self::Dock, Dock::plan(case, distance_m))
            }
            &ControllerConfig::Creep { distance_m } => {
                bound(Self::Creep, CreepBy::plan(case, distance_m))
            }
        }
    }

    /// What it does while the state lasts.
    pub(crate) fn behaviour(&self) -> &dyn Behaviour {
        match self {
            Self::Corridor(corridor) => corridor,
            Self::EndOfLane(end) => end,
            Self::UTurn(u_turn) => u_turn,
            Self::Shift(shift) => shift,
            Self::Turn(turn) => turn,
            Self::StopAt(place) => place,
            Self::Dock(dock) => dock,
            Self::Creep(creep) => creep,
            Self::Stop => &Stop,
        }
    }
}
