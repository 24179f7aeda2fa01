//! What a robot believes of its pose, against the truth.

use std::ops::Range;

use description::geometry::wrap_angle;
use description::site::{ControllerConfig, Feature};
use sim::world::{STANDING_M_S, Truth};

use super::look::{Look, Robot, is_carried, place};
use super::view::{Scenery, normal, walls_in_view};
use super::violations::Violations;
use crate::belief::Belief;
use crate::figures::Figures;
use crate::lanes::lane_of;
use crate::scenario::{Limits, Scenario, ScriptedFault};
use crate::violation::ViolationKind;

/// After a fault that misleads it a robot needs this time to correct what it believes by the walls that it sees.
const CORRECTED_S: f64 = 2.0;

/// A wall counts when it has been in view this long: a scan, and the corrections it brings, take their time.
const SETTLED_NS: u64 = 1_000_000_000;
/// Older estimates are not compared.
const RECENT_NS: u64 = 200_000_000;
/// How often to compute which walls are in view.
const VIEW_NS: u64 = 100_000_000;
/// A wall runs along a lane when the cosine between its normal and the lane is less than this.
const ALONG: f64 = 0.17;

/// Watches the belief of one robot.
#[derive(Debug)]
pub(super) struct Believed {
    /// Since when each wall has been in view.
    in_view: Vec<Option<u64>>,
    view_ns: u64,
    /// It has driven by what it believes. A program that has just begun may have to be told first where it stands.
    drives: bool,
    /// At the last look.
    was: Option<Truth>,
    /// When faults of the scenario mislead it.
    misled_ns: Vec<Range<u64>>,
}

impl Believed {
    /// Of a robot of a scenario that begins at this time.
    pub(super) fn new(scenario: &Scenario, robot: &Robot, start_ns: u64) -> Self {
        let misleads =
            |fault: &&ScriptedFault| fault.robot.as_ref() == Some(&robot.id) && fault.misleads();
        let at_ns = |at_s: f64| start_ns + (at_s * 1e9) as u64;
        let misled =
            |fault: &ScriptedFault| at_ns(fault.at_s)..at_ns(fault.until_s() + CORRECTED_S);
        Self {
            in_view: vec![None; robot.site.walls.len()],
            view_ns: 0,
            drives: false,
            was: None,
            misled_ns: { scenario.faults.iter().filter(misleads) }
                .map(misled)
                .collect(),
        }
    }

    pub(super) fn judge(
        &mut self,
        robot: &Robot,
        limits: &Limits,
        look: &Look<'_>,
        belief: &Belief,
        figures: &mut Figures,
        violations: &mut Violations,
    ) {
        let now_ns = look.truth.time_ns;
        // The world remembers poses only this long; the estimate of a running robot is younger.
        let recent = now_ns.saturating_sub(belief.stamp_ns) < RECENT_NS;
        let Some(true_pose) = (belief.stamp_ns > 0 && recent)
            .then(|| look.world.pose_at(look.robot, belief.stamp_ns))
            .flatten()
        else {
            self.drives = false;
            return;
        };
        let was = self.was.replace(*look.truth);
        if was.is_some_and(|was| is_carried(&was, look.truth)) {
            self.drives = false;
        }
        self.drives |= look.truth.twist.v_m_s.abs() > STANDING_M_S;
        if now_ns >= self.view_ns + VIEW_NS {
            self.view_ns = now_ns;
            self.look_around(robot, look, &belief.state);
        }
        let mut misled = self.misled_ns.iter();
        // One that says that it does not know stands.
        if !self.drives || belief.uncertain || misled.any(|when| when.contains(&now_ns)) {
            return;
        }
        let error_m = [
            belief.pose.x_m - true_pose.x_m,
            belief.pose.y_m - true_pose.y_m,
        ];
        let heading_rad = wrap_angle(belief.pose.theta_rad - true_pose.theta_rad);
        figures.max_position_error_m = figures
            .max_position_error_m
            .max(error_m[0].hypot(error_m[1]));
        let settled =
            |since: &Option<u64>| since.is_some_and(|since_ns| now_ns >= since_ns + SETTLED_NS);
        let walls: Vec<usize> = (0..self.in_view.len())
            .filter(|&index| settled(&self.in_view[index]))
            .collect();
        if walls.is_empty() {
            return;
        }
        figures.max_heading_error_rad = figures.max_heading_error_rad.max(heading_rad.abs());
        let mut worst: Option<(f64, usize)> = None;
        for index in walls {
            let [nx, ny] = normal(&robot.site.walls[index]);
            let across_m = (error_m[0] * nx + error_m[1] * ny).abs();
            if worst.is_none_or(|(most_m, _)| across_m > most_m) {
                worst = Some((across_m, index));
            }
        }
        let Some((across_m, index)) = worst else {
            return;
        };
        figures.max_pose_error_m = figures.max_pose_error_m.max(across_m);
        let at = place(&true_pose);
        if let Some(most_m) = limits.pose_error_m.filter(|most_m| across_m > *most_m) {
            let wall = &robot.site.walls[index].id;
            let detail = format!(
                "{across_m:.3} m across wall {wall}, which is in view, {at}, expected at most {most_m} m"
            );
            violations.report(ViolationKind::Pose, &robot.name, now_ns, detail);
        }
        let degrees = heading_rad.to_degrees();
        if let Some(most) = limits
            .heading_error_deg
            .filter(|most| degrees.abs() > *most)
        {
            let detail = format!("{degrees:.2}° off {at}, expected at most {most}°");
            violations.report(ViolationKind::Heading, &robot.name, now_ns, detail);
        }
    }

    /// Notes which walls the lidar sees and the running skill's perception uses.
    fn look_around(&mut self, robot: &Robot, look: &Look<'_>, state: &str) {
        let scenery = Scenery::of(look.world, look.robot);
        let lidar = look.truth.pose.compose(&robot.lidar);
        let view = walls_in_view(&robot.site, &scenery, &lidar);
        for (index, seen) in view.into_iter().enumerate() {
            let used = seen && is_used(robot, index, state);
            let since = &mut self.in_view[index];
            *since = used.then(|| since.unwrap_or(look.truth.time_ns));
        }
    }
}

/// Whether what runs in a state corrects the pose by a wall.
fn is_used(robot: &Robot, wall: usize, state: &str) -> bool {
    let Some(state) = robot.fsm.state(state) else {
        return false;
    };
    let skill = robot.site.skill(&state.skill);
    let tracks = skill
        .and_then(|skill| robot.site.perception_kinds.get(&skill.perception))
        .map_or(&[][..], |kind| &kind.tracks);
    if tracks.contains(&Feature::Walls) {
        return true;
    }
    let turns = skill.is_some_and(|skill| {
        matches!(
            skill.controller,
            ControllerConfig::UTurn { .. } | ControllerConfig::Turn { .. }
        )
    });
    let Some(lane) = lane_of(&robot.site, state).filter(|_| !turns) else {
        return false;
    };
    let wall = &robot.site.walls[wall];
    let is_end = lane.end_wall.as_ref() == Some(&wall.id);
    let along = wall.line.unit().cross(lane.line.unit()).abs() < ALONG;
    (along && tracks.contains(&Feature::Corridor)) || (is_end && tracks.contains(&Feature::LaneEnd))
}
