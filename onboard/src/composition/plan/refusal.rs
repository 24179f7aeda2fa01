//! Why two files make no robot, told with file, line and key.

use config::{Origin, Problem, ProblemKind};
use skills::map::MapError;
use skills::navigator::SetupError;
use skills::schedule::ScheduleError;

use super::contents::Plan;
use super::error::PlanError;
use crate::composition::failure::Failure;

/// The error, at the key that is to blame for it.
pub(super) fn of(plan: &Plan, error: &PlanError) -> Failure {
    Failure::Refused(miette::Report::new(problem(plan, error)))
}

fn problem(plan: &Plan, error: &PlanError) -> Problem {
    let (robot, site) = (&plan.robot.origin, &plan.site.origin);
    let (origin, key, expected): (&Origin, String, &str) = match error {
        PlanError::Machine(_) => (
            site,
            format!("fsm.{}", plan.role),
            "a state machine that can be run",
        ),
        PlanError::Events(_) => (
            site,
            "monitors".to_owned(),
            "fewer events of monitors and machines",
        ),
        PlanError::Navigation(error) => match error {
            SetupError::Map(error) => (site, map_key(error), "a map that robots can drive by"),
            SetupError::Schedule(error) => (
                site,
                schedule_key(plan, error),
                "a manoeuvre that this robot can drive here",
            ),
            SetupError::Start | SetupError::StartState(_) => (
                site,
                format!("robots.{}", plan.robot.identity.id),
                "a start on the map",
            ),
            SetupError::Footprint => (robot, "footprint".to_owned(), "an outline"),
            SetupError::NotPositive { .. } | SetupError::SteeringLag(_) => (
                robot,
                "navigation".to_owned(),
                "gains and limits within their ranges",
            ),
        },
        PlanError::Tubes(_) => (
            robot,
            "tubes".to_owned(),
            "motion tubes that the sensor can judge",
        ),
        PlanError::Geometry(_) | PlanError::Limits(_) => (
            robot,
            "drive".to_owned(),
            "geometry and limits of a drive that can move",
        ),
        PlanError::Lidar(_) => (robot, "lidar".to_owned(), "scans that the line can carry"),
    };
    origin.problem(ProblemKind::Inconsistent, &key, error.to_string(), expected)
}

fn map_key(error: &MapError) -> String {
    match error {
        MapError::Duplicate { kind, id }
        | MapError::NoLength { kind, id }
        | MapError::Unknown { kind, id, .. } => format!("{kind}s.{id}"),
        MapError::NotAcross { lane, .. } => format!("lanes.{lane}.end_wall"),
        MapError::Region { id } | MapError::Limit { id, .. } => format!("areas.{id}"),
        MapError::TooManyAreas { .. } => "areas".to_owned(),
    }
}

fn schedule_key(plan: &Plan, error: &ScheduleError) -> String {
    let state = |name: &str| format!("fsm.{}.states.{name}", plan.role);
    match error {
        ScheduleError::State { state: name, .. }
        | ScheduleError::NoLane { state: name, .. }
        | ScheduleError::Manoeuvre { state: name, .. }
        | ScheduleError::TurnSide { state: name, .. } => state(name),
        ScheduleError::Unknown { kind, id, .. } if *kind == "state" => state(id),
        ScheduleError::Unknown { kind, id, .. } => format!("{kind}s.{id}"),
        ScheduleError::Parameter { skill, what, .. } => {
            let key = format!("skills.{skill}.{}_m", what.replace(' ', "_"));
            if plan.site.origin.is_written(&key) {
                key
            } else {
                format!("skills.{skill}")
            }
        }
        ScheduleError::Monitor { monitor, .. } => format!("monitors.{monitor}.after_s"),
    }
}
