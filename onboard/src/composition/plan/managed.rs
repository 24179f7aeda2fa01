//! What areas that a mediator manages ask of a robot's file: it stops before their borders, and leaves its lane's path for nobody.

use std::time::Duration;

use contract::timing::ENTERS_WITHIN_NS;
use description::keys::{KeyError, KeyErrors};
use description::threads::ActivityKind;
use skills::control::REACTION_S;

use super::budget::{Budget, longest_pause, ms};
use super::contents::Plan;
use crate::fleet::LEAVE_AGE_NS;

/// Whether the robot keeps to areas, where they are managed.
///
/// # Errors
/// The keys with which it might not.
pub fn check(plan: &Plan) -> Result<(), KeyErrors> {
    if !plan.site.areas_managed {
        return Ok(());
    }
    let found = [
        enters_too_late(plan),
        obeys_too_late(plan),
        goes_around(plan),
    ];
    let errors: Vec<KeyError> = found.into_iter().flatten().collect();
    KeyErrors::any(errors)
}

/// A robot that must not enter an area any more stands before it, or has entered, within the time that
/// the mediator counts on, even if communication hangs.
fn enters_too_late(plan: &Plan) -> Option<KeyError> {
    let robot = &plan.robot;
    let speed_m_s = robot.drive.limits.max_speed_m_s;
    let deceleration_m_s2 = robot.navigation.deceleration_m_s2;
    let within = Duration::from_nanos(ENTERS_WITHIN_NS);
    let late = [
        longest_pause(&robot.threads, ActivityKind::Communication).1,
        Duration::from_nanos(LEAVE_AGE_NS),
        longest_pause(&robot.threads, ActivityKind::Navigation).1,
        Budget::of(plan).longest_delay(),
    ];
    let late: Duration = late.iter().sum();
    let left_s = within.saturating_sub(late).as_secs_f64();
    (speed_m_s > deceleration_m_s2 * left_s).then(|| {
        KeyError::new(
            "navigation.deceleration_m_s2",
            format!("{deceleration_m_s2}"),
            format!(
                "at least {:.2}, so that a robot that has lost its mediator stands within {} from {speed_m_s} m/s, {} of which threads may be late",
                (speed_m_s / left_s * 100.0).ceil() / 100.0,
                ms(within),
                ms(late)
            ),
        )
    })
}

/// How fast it may be before a border is reckoned with a delay from a command to the wheels.
fn obeys_too_late(plan: &Plan) -> Option<KeyError> {
    let kinds = [
        ActivityKind::Navigation,
        ActivityKind::Control,
        ActivityKind::Drive,
    ];
    let pauses = kinds.map(|kind| longest_pause(&plan.robot.threads, kind).1);
    let pauses: Duration = pauses.iter().sum();
    let planned = Duration::from_secs_f64(REACTION_S);
    let found_ms = plan.robot.drive.lag_ms;
    let most = planned.saturating_sub(pauses);
    (Duration::from_millis(u64::from(found_ms)) > most).then(|| {
        KeyError::new(
            "drive.lag_ms",
            found_ms.to_string(),
            format!(
                "at most {}, since borders are approached with {} from a command to the wheels, {} of which threads take",
                ms(most),
                ms(planned),
                ms(pauses)
            ),
        )
    })
}

/// Borders are kept by the path that the robot is on; around things it would leave that.
fn goes_around(plan: &Plan) -> Option<KeyError> {
    let found_1_m = plan.robot.tubes.adapt.detour.curvature_1_m;
    (found_1_m > 0.0).then(|| {
        KeyError::new(
            "tubes.detour_curvature_1_m",
            found_1_m.to_string(),
            "0 where a mediator manages the areas: their borders are kept by the lane's path, which a detour leaves".to_owned(),
        )
    })
}
