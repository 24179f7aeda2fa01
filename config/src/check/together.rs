//! What only the robot's and the site's file together can tell.

use crate::check::room;
use crate::diagnostic::{ConfigError, Problem, ProblemKind};
use crate::hint;
use crate::loaded::RobotConfig;
use crate::loaded::SiteConfig;
use description::geometry::Segment;
use description::site::{ControllerConfig, FsmConfig, SiteRobot};

/// Checks what only the robot's and the site's file together can tell: that the site
/// knows the robot, and that this robot can drive this site.
///
/// # Errors
/// Everything that does not fit, at once.
pub fn check_together(robot: &RobotConfig, site: &SiteConfig) -> Result<(), ConfigError> {
    let mut problems = Vec::new();
    let id = robot.identity.id.as_str();
    match site.robots.get(id) {
        None => problems.push(stranger(robot, site)),
        Some(entry) => {
            start_is_free(robot, site, entry, &mut problems);
            if let Some(fsm) = site.fsm.get(&entry.role) {
                skills(robot, site, fsm, &mut problems);
                room::check(robot, site, &entry.role, fsm, &mut problems);
                room::to_turn(robot, site, fsm, &mut problems);
            }
        }
    }
    if problems.is_empty() {
        Ok(())
    } else {
        Err(ConfigError::new(problems, 0))
    }
}

fn stranger(robot: &RobotConfig, site: &SiteConfig) -> Problem {
    let known: Vec<&str> = site.robots.keys().map(String::as_str).collect();
    let id = robot.identity.id.as_str();
    let problem = robot.origin.problem(
        ProblemKind::UnknownReference,
        "identity.id",
        format!("robot `{id}`, which {} does not have", site.origin.file()),
        format!("a robot with a section [robots.{id}] in the site file"),
    );
    match hint::for_name(id, &known) {
        Some(advice) => problem.with_hint(advice),
        None => problem,
    }
}

fn start_is_free(
    robot: &RobotConfig,
    site: &SiteConfig,
    entry: &SiteRobot,
    problems: &mut Vec<Problem>,
) {
    let corners = robot
        .footprint
        .corners()
        .map(|corner| entry.start.transform(corner));
    for wall in &site.walls {
        let crosses = (0..4)
            .any(|index| Segment::new(corners[index], corners[(index + 1) % 4]).meets(&wall.line));
        let inside = robot
            .footprint
            .contains(entry.start.inverse_transform(wall.line.a));
        if crosses || inside {
            problems.push(site.origin.problem(
                ProblemKind::Inconsistent,
                &format!("robots.{}.start", robot.identity.id),
                format!("a start with the body in wall `{}`", wall.id),
                "a start with the whole footprint free",
            ));
        }
    }
}

fn skills(robot: &RobotConfig, site: &SiteConfig, fsm: &FsmConfig, problems: &mut Vec<Problem>) {
    let used = site
        .skills
        .iter()
        .filter(|skill| fsm.states.iter().any(|s| s.skill == skill.id));
    for skill in used {
        match skill.controller {
            ControllerConfig::EndOfLane { distance_m } => {
                let sees_m = robot.lidar.mount.x_m + robot.lidar.range_max_m;
                if distance_m > sees_m {
                    problems.push(site.origin.problem(
                        ProblemKind::Inconsistent,
                        &format!("skills.{}.distance_m", skill.id),
                        format!("{distance_m:?}"),
                        format!("at most {sees_m:.3} m, as far as the lidar sees"),
                    ));
                }
            }
            ControllerConfig::UTurn { radius_m, .. } | ControllerConfig::Turn { radius_m } => {
                tubes_turn_so(robot, site, &skill.id, radius_m, problems);
            }
            ControllerConfig::Corridor { .. }
            | ControllerConfig::Shift { .. }
            | ControllerConfig::StopAt { .. }
            | ControllerConfig::Dock { .. }
            | ControllerConfig::Creep { .. }
            | ControllerConfig::Stop => {}
        }
    }
}

fn tubes_turn_so(
    robot: &RobotConfig,
    site: &SiteConfig,
    skill: &str,
    radius_m: f64,
    problems: &mut Vec<Problem>,
) {
    let rows = robot.tubes.horizons.iter();
    let slowest_m_s = rows.map(|row| row.speed_m_s).fold(f64::INFINITY, f64::min);
    let tightest_m = slowest_m_s / robot.tubes.omega_max_rad_s;
    if radius_m < tightest_m {
        problems.push(site.origin.problem(
            ProblemKind::Inconsistent,
            &format!("skills.{skill}.radius_m"),
            format!("{radius_m:?}"),
            format!("at least {tightest_m:.3} m, for the robot's `tubes.omega_max_rad_s`"),
        ));
    }
}
