//! The judge of a trial: collisions, borders, speed, pose errors and stops, from the world's truth.

use config::{ControllerConfig, Feature, FsmConfig, SiteConfig};
use sim::world::{Cause, Footprint, Pose, Truth, World};

use super::figures::Figures;
use super::overlap::Overlap;
use super::stops::{StopError, StopKind};
use super::view::{Scenery, normal, walls_in_view};
use crate::belief::Belief;
use crate::one_robot::summary::Violation;

/// Largest error of the pose across a wall that is in view.
const POSE_ERROR_M: f64 = 0.05;
/// Largest error of the heading while any wall is in view.
const HEADING_ERROR_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// A wall counts when it has been in view for so long: a scan, and the corrections it brings, take their time.
const SETTLED_NS: u64 = 1_000_000_000;
/// Older estimates are not compared.
const RECENT_NS: u64 = 200_000_000;
/// The view is looked at this often.
const VIEW_NS: u64 = 100_000_000;
/// Deeper in an area without leave than this is a violation; contact with its border is none.
const BORDER_M: f64 = 0.001;
/// The lidar sees what is no farther to either side.
const IN_VIEW_RAD: f64 = 2.09;
/// A walls direction counts as along a lane within this.
const ALONG: f64 = 0.17;
/// One kind of violation is reported once in a stretch of this.
const STRETCH_NS: u64 = 1_000_000_000;
/// Longer lists say nothing more.
const MOST_VIOLATIONS: usize = 64;
const STANDING_M_S: f64 = 0.02;

/// What a trial asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// What runs into a standing robot is no violation.
    pub may_be_run_into: bool,
    /// Errors of the pose are violations; otherwise they are only told.
    pub pose: bool,
}

/// One look at the robot.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// The world, now.
    pub world: &'a World,
    /// The robot's index in it.
    pub robot: usize,
    /// The truth about it.
    pub truth: &'a Truth,
    /// What it believes.
    pub belief: &'a Belief,
    /// Leave for each area.
    pub granted: &'a [bool],
}

/// Watches one robot.
pub struct Judge {
    robot: String,
    site: SiteConfig,
    fsm: FsmConfig,
    footprint: Footprint,
    lidar: Pose,
    rules: Rules,
    start_ns: u64,
    last_ns: u64,
    collisions: usize,
    // Since when each wall has been in view.
    in_view: Vec<Option<u64>>,
    view_ns: u64,
    stood_since_ns: Option<u64>,
    instructed: Option<Pose>,
    last: Vec<(&'static str, u64)>,
    figures: Figures,
    violations: Vec<Violation>,
}

impl Judge {
    /// A judge of one robot of a site, from `start_ns` on.
    #[must_use]
    pub fn new(
        robot: &config::RobotConfig,
        site: &SiteConfig,
        fsm: &FsmConfig,
        rules: Rules,
        start_ns: u64,
    ) -> Self {
        let (body, mount) = (&robot.footprint, &robot.lidar.mount);
        Self {
            robot: robot.identity.id.clone(),
            site: site.clone(),
            fsm: fsm.clone(),
            footprint: Footprint {
                front_m: body.front_m,
                rear_m: body.rear_m,
                left_m: body.left_m,
                right_m: body.right_m,
            },
            lidar: Pose::new(mount.x_m, mount.y_m, mount.theta_rad),
            rules,
            start_ns,
            last_ns: start_ns,
            collisions: 0,
            in_view: vec![None; site.walls.len()],
            view_ns: 0,
            stood_since_ns: None,
            instructed: None,
            last: Vec::new(),
            figures: Figures {
                min_clearance_m: f64::INFINITY,
                min_border_m: f64::INFINITY,
                ..Figures::default()
            },
            violations: Vec::new(),
        }
    }

    /// What came out so far.
    #[must_use]
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// What was found.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        &self.violations
    }

    /// The robot's outline.
    #[must_use]
    pub fn footprint(&self) -> &Footprint {
        &self.footprint
    }

    /// The robot was told where to stop.
    pub fn instructed(&mut self, pose: Pose) {
        self.instructed = Some(pose);
    }

    /// Takes in one look.
    pub fn observe(&mut self, look: &Look<'_>) {
        let (truth, now_ns) = (look.truth, look.truth.time_ns);
        let elapsed_s = now_ns.saturating_sub(self.last_ns) as f64 / 1e9;
        self.last_ns = now_ns;
        let figures = &mut self.figures;
        figures.duration_s = now_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        figures.distance_m = truth.distance_m;
        figures.min_clearance_m = figures.min_clearance_m.min(truth.clearance_m);
        let at_m = [truth.pose.x_m, truth.pose.y_m];
        if let Some(area) = self.site.area_at(at_m)
            && !figures.areas.contains(&area.id)
        {
            figures.areas.insert(area.id.clone());
        }
        // Stopped for want of room; other reasons (no scan yet) are not of interest.
        if look.belief.verdict == 3 && matches!(look.belief.reason, 1 | 3 | 6) {
            figures.held_s += elapsed_s;
        }
        self.judge_collisions(look);
        self.judge_borders(look);
        self.measure_speed(truth);
        self.judge_stand(truth);
        self.follow_states(look);
        self.judge_pose(look);
    }

    /// A violation found elsewhere.
    pub fn report(&mut self, kind: &'static str, at_ns: u64, detail: String) {
        let lasting = self.last.iter_mut().find(|(last, _)| *last == kind);
        let news = match lasting {
            Some((_, last_ns)) => at_ns > std::mem::replace(last_ns, at_ns) + STRETCH_NS,
            None => {
                self.last.push((kind, at_ns));
                true
            }
        };
        if news && self.violations.len() < MOST_VIOLATIONS {
            self.violations.push(Violation {
                kind: kind.to_owned(),
                robot: self.robot.clone(),
                at_s: at_ns.saturating_sub(self.start_ns) as f64 / 1e9,
                detail,
            });
        }
    }

    fn judge_collisions(&mut self, look: &Look<'_>) {
        let all = look.world.collisions(look.robot);
        for collision in &all[self.collisions.min(all.len())..] {
            let (count, allowed) = match collision.cause {
                Cause::DroveInto => (&mut self.figures.drove_into, false),
                Cause::Met => (&mut self.figures.met, false),
                Cause::RunInto => (&mut self.figures.run_into, self.rules.may_be_run_into),
            };
            *count += 1;
            if !allowed {
                let kind = match collision.cause {
                    Cause::DroveInto => "collision",
                    Cause::Met if collision.bearing_rad.abs() > IN_VIEW_RAD => {
                        "collision-met-unseen"
                    }
                    Cause::Met => "collision-met",
                    Cause::RunInto => "collision-run-into",
                };
                let detail = format!(
                    "at x = {:.2} m, y = {:.2} m; the robot moved at {:.2} m/s, the other at {:.2} m/s, {:.0}° to the left",
                    look.truth.pose.x_m,
                    look.truth.pose.y_m,
                    collision.robot_m_s,
                    collision.object_m_s,
                    collision.bearing_rad.to_degrees()
                );
                self.report(kind, collision.time_ns, detail);
            }
        }
        self.collisions = all.len();
    }

    fn judge_borders(&mut self, look: &Look<'_>) {
        if look.granted.iter().all(|granted| *granted) {
            return;
        }
        let floor = self.footprint.at(&look.truth.pose);
        let stands = look.truth.twist.v_m_s.abs() < STANDING_M_S;
        for index in 0..self.site.areas.len() {
            if look.granted.get(index).copied().unwrap_or(true) {
                continue;
            }
            let area = &self.site.areas[index];
            let Overlap {
                depth_m,
                distance_m,
            } = Overlap::of(&floor, &area.region);
            if stands && distance_m < 0.5 {
                self.figures.min_border_m = self.figures.min_border_m.min(distance_m);
            }
            if depth_m > BORDER_M {
                let detail = format!("{depth_m:.3} m inside area {} without leave", area.id);
                self.report("border", look.truth.time_ns, detail);
            }
        }
    }

    /// The limits of a state hold from its first step on, which may be made in the area before: told, not judged.
    fn measure_speed(&mut self, truth: &Truth) {
        let limit_m_s = self
            .site
            .area_at([truth.pose.x_m, truth.pose.y_m])
            .map_or(f64::INFINITY, |area| area.control.speed_limit_m_s);
        let over_m_s = truth.twist.v_m_s.abs() - limit_m_s;
        self.figures.max_over_speed_m_s = self.figures.max_over_speed_m_s.max(over_m_s);
    }

    fn judge_stand(&mut self, truth: &Truth) {
        let moves = truth.twist.v_m_s.abs() > STANDING_M_S;
        if moves {
            self.stood_since_ns = None;
            return;
        }
        let since_ns = *self.stood_since_ns.get_or_insert(truth.time_ns);
        let stood_s = (truth.time_ns - since_ns) as f64 / 1e9;
        self.figures.longest_stand_s = self.figures.longest_stand_s.max(stood_s);
    }

    /// Keeps track of the machine's states; at the end of one that stops somewhere, judges where.
    fn follow_states(&mut self, look: &Look<'_>) {
        let belief = look.belief;
        if belief.state.is_empty() || self.figures.states.last() == Some(&belief.state) {
            return;
        }
        let before = self
            .figures
            .states
            .last()
            .and_then(|name| self.fsm.state(name));
        let stop_at = |pose: &Pose| {
            let instructed = self.instructed.as_ref();
            StopError::of(&self.site, before?, instructed, &self.footprint, pose)
        };
        let (stop, believed) = (stop_at(&look.truth.pose), stop_at(&belief.pose));
        self.figures.states.push(belief.state.clone());
        self.figures.skills.insert(belief.skill.clone());
        let Some((stop, believed)) = stop.zip(believed) else {
            return;
        };
        let (list, kind, judged) = match stop.kind {
            StopKind::Dock => (&mut self.figures.dock_errors_m, "docking", stop),
            StopKind::Pose => (&mut self.figures.pose_stop_errors_m, "stop-pose", believed),
            StopKind::Border => (&mut self.figures.border_stop_errors_m, "stop-border", stop),
        };
        list.push(stop.error_m);
        if judged.error_m.abs() > judged.limit_m() {
            let detail = format!(
                "stopped {:.3} m off, expected at most {} m",
                judged.error_m,
                judged.limit_m()
            );
            self.report(kind, look.truth.time_ns, detail);
        }
    }

    fn judge_pose(&mut self, look: &Look<'_>) {
        let (belief, now_ns) = (look.belief, look.truth.time_ns);
        // Farther back the world does not know where the robot was; no running robot's estimate is so old.
        let recent = now_ns.saturating_sub(belief.stamp_ns) < RECENT_NS;
        let Some(true_pose) = (belief.stamp_ns > 0 && recent)
            .then(|| look.world.pose_at(look.robot, belief.stamp_ns))
            .flatten()
        else {
            return;
        };
        if now_ns >= self.view_ns + VIEW_NS {
            self.view_ns = now_ns;
            self.look_around(look);
        }
        let error_m = [
            belief.pose.x_m - true_pose.x_m,
            belief.pose.y_m - true_pose.y_m,
        ];
        let heading_rad = wrap(belief.pose.theta_rad - true_pose.theta_rad);
        let figures = &mut self.figures;
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
            let [nx, ny] = normal(&self.site.walls[index]);
            let across_m = (error_m[0] * nx + error_m[1] * ny).abs();
            if worst.is_none_or(|(most_m, _)| across_m > most_m) {
                worst = Some((across_m, index));
            }
        }
        let Some((across_m, index)) = worst else {
            return;
        };
        figures.max_pose_error_m = figures.max_pose_error_m.max(across_m);
        if !self.rules.pose {
            return;
        }
        let at = format!("at x = {:.2} m, y = {:.2} m", true_pose.x_m, true_pose.y_m);
        if across_m > POSE_ERROR_M {
            let wall = &self.site.walls[index].id;
            let detail = format!(
                "{across_m:.3} m across wall {wall}, which is in view, {at}, expected at most {POSE_ERROR_M} m"
            );
            self.report("pose", now_ns, detail);
        }
        if heading_rad.abs() > HEADING_ERROR_RAD {
            let degrees = heading_rad.to_degrees();
            let detail = format!("{degrees:.2}° off {at}, expected at most 2°");
            self.report("heading", now_ns, detail);
        }
    }

    /// Which walls the lidar sees and the running skill's perception uses.
    fn look_around(&mut self, look: &Look<'_>) {
        let scenery = Scenery::of(look.world, look.robot);
        let lidar = look.truth.pose.compose(&self.lidar);
        let view = walls_in_view(&self.site, &scenery, &lidar);
        for (index, seen) in view.into_iter().enumerate() {
            let used = seen && self.is_used(index, &look.belief.state);
            let since = &mut self.in_view[index];
            *since = used.then(|| since.unwrap_or(look.truth.time_ns));
        }
    }

    /// Whether what runs in a state corrects the pose by a wall.
    fn is_used(&self, wall: usize, state: &str) -> bool {
        let Some(state) = self.fsm.state(state) else {
            return false;
        };
        let skill = self.site.skill(&state.skill);
        let tracks = skill
            .and_then(|skill| self.site.perception_kinds.get(&skill.perception))
            .map_or(&[][..], |kind| &kind.tracks);
        if tracks.contains(&Feature::Walls) {
            return true;
        }
        let area = self.site.area(&state.area);
        let lane = state
            .lane
            .as_ref()
            .or(area.and_then(|area| area.lane.as_ref()));
        let turns = skill.is_some_and(|skill| {
            matches!(
                skill.controller,
                ControllerConfig::UTurn { .. } | ControllerConfig::Turn { .. }
            )
        });
        let Some(lane) = lane
            .and_then(|lane| self.site.lane(lane))
            .filter(|_| !turns)
        else {
            return false;
        };
        let is_end = lane.end_wall.as_ref() == Some(&self.site.walls[wall].id);
        let [nx, ny] = normal(&self.site.walls[wall]);
        let [dx, dy] = [0, 1].map(|axis| lane.to_m[axis] - lane.from_m[axis]);
        let along = ((nx * dx + ny * dy) / dx.hypot(dy)).abs() < ALONG;
        (along && tracks.contains(&Feature::Corridor))
            || (is_end && tracks.contains(&Feature::LaneEnd))
    }
}

fn wrap(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    (angle_rad + turn / 2.0).rem_euclid(turn) - turn / 2.0
}
