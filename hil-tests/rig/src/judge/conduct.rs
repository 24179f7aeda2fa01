//! How one robot drives: everything that is judged of it without the others.

use std::ops::Range;

use sim::world::{Pose, STANDING_M_S, Truth};

use super::borders;
use super::contact::Contact;
use super::lane::Lane;
use super::look::{Look, Robot};
use super::pose::Believed;
use super::stops::{StopError, StopKind, has_stopped};
use super::violations::Violations;
use crate::belief::Belief;
use crate::figures::Figures;
use crate::scenario::{Limits, Scenario, ScriptedFault, ScriptedKind};
use crate::violation::ViolationKind;

/// A robot whose pivot was jammed may be off its path for so long after that: it latches, is reset, and has a few metres to come back on it.
const BACK_ON_PATH_S: f64 = 10.0;
/// What kept a robot from driving until less than this ago may still be why it stands.
const STARTS_NS: u64 = 1_000_000_000;

/// Watches one robot.
#[derive(Debug)]
pub(super) struct Conduct {
    pub(super) robot: Robot,
    /// The truth at the last look.
    pub(super) truth: Option<Truth>,
    limits: Limits,
    start_ns: u64,
    contact: Contact,
    lane: Lane,
    believed: Believed,
    stood_since_ns: Option<u64>,
    /// When it was driven by hand, or could not steer, by the scenario: no matter of its own where that takes it.
    led_astray_ns: Vec<Range<u64>>,
    /// Since when its machine is in its state.
    state_ns: u64,
    /// When something last kept it from driving, as it says.
    kept_ns: Option<u64>,
    /// The last place to stop that came with an event.
    instructed: Option<Pose>,
    figures: Figures,
}

impl Conduct {
    pub(super) fn new(scenario: &Scenario, robot: Robot, start_ns: u64) -> Self {
        let leads_astray = |fault: &&ScriptedFault| {
            let kinds = [ScriptedKind::Teleop, ScriptedKind::JamPivot];
            kinds.contains(&fault.what) && fault.robot.as_ref() == Some(&robot.id)
        };
        let at_ns = |at_s: f64| start_ns + (at_s * 1e9) as u64;
        Self {
            truth: None,
            limits: scenario.limits,
            start_ns,
            contact: Contact::new(scenario, start_ns),
            lane: Lane::default(),
            believed: Believed::new(scenario, &robot, start_ns),
            stood_since_ns: None,
            led_astray_ns: { scenario.faults.iter().filter(leads_astray) }
                .map(|fault| {
                    let jammed = fault.what == ScriptedKind::JamPivot;
                    let back_s = if jammed { BACK_ON_PATH_S } else { 0.0 };
                    at_ns(fault.at_s)..at_ns(fault.until_s() + back_s)
                })
                .collect(),
            state_ns: start_ns,
            kept_ns: None,
            instructed: None,
            figures: Figures {
                min_clearance_m: f64::INFINITY,
                min_border_m: f64::INFINITY,
                ..Figures::default()
            },
            robot,
        }
    }

    pub(super) fn figures(&self) -> &Figures {
        &self.figures
    }

    pub(super) fn max_lateral_error_m(&self) -> f64 {
        self.lane.max_lateral_error_m()
    }

    pub(super) fn take_lateral_error_m(&mut self) -> f64 {
        self.lane.take_lateral_error_m()
    }

    /// The robot was told where to stop.
    pub(super) fn instructed(&mut self, pose: Pose) {
        self.instructed = Some(pose);
    }

    /// Takes in one look; returns the truth at the look before, if there was one.
    pub(super) fn observe(
        &mut self,
        look: &Look<'_>,
        violations: &mut Violations,
    ) -> Option<Truth> {
        let (truth, now_ns) = (look.truth, look.truth.time_ns);
        let before = self.truth.replace(*truth);
        let last_ns = before.map_or(self.start_ns, |before| before.time_ns);
        let elapsed_s = now_ns.saturating_sub(last_ns) as f64 / 1e9;
        let (robot, figures) = (&self.robot, &mut self.figures);
        figures.duration_s = now_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        figures.distance_m = truth.distance_m;
        figures.min_clearance_m = figures.min_clearance_m.min(truth.clearance_m);
        if let Some(area) = robot.site.area_at([truth.pose.x_m, truth.pose.y_m].into())
            && !figures.areas.contains(&area.id)
        {
            figures.areas.insert(area.id.clone());
        }
        if look.belief.is_some_and(Belief::is_held) {
            figures.held_s += elapsed_s;
        }
        self.contact
            .judge(robot, &self.limits, look, figures, violations);
        borders::judge(robot, look, figures, violations);
        self.lane.judge(robot, &self.limits, truth, violations);
        self.measure_speed(truth);
        self.measure_stand(truth);
        if let Some(belief) = look.belief {
            self.follow_states(truth, belief, violations);
            let (robot, figures) = (&self.robot, &mut self.figures);
            self.believed
                .judge(robot, &self.limits, look, belief, figures, violations);
        }
        before
    }

    /// Measured, not judged: a state's limit holds from its first step, which may be made in the area before.
    fn measure_speed(&mut self, truth: &Truth) {
        let limit_m_s = self
            .robot
            .site
            .area_at([truth.pose.x_m, truth.pose.y_m].into())
            .map_or(f64::INFINITY, |area| area.control.speed_limit_m_s);
        let over_m_s = truth.twist.v_m_s.abs() - limit_m_s;
        self.figures.max_over_speed_m_s = self.figures.max_over_speed_m_s.max(over_m_s);
    }

    fn measure_stand(&mut self, truth: &Truth) {
        if truth.twist.v_m_s.abs() > STANDING_M_S {
            self.stood_since_ns = None;
            return;
        }
        let since_ns = *self.stood_since_ns.get_or_insert(truth.time_ns);
        let stood_s = (truth.time_ns - since_ns) as f64 / 1e9;
        self.figures.longest_stand_s = self.figures.longest_stand_s.max(stood_s);
    }

    /// Keeps track of the machine's states; at the end of one that stops somewhere, judges where.
    fn follow_states(&mut self, truth: &Truth, belief: &Belief, violations: &mut Violations) {
        let kept = { self.kept_ns }.is_some_and(|kept_ns| truth.time_ns < kept_ns + STARTS_NS);
        if belief.kept {
            self.kept_ns = Some(truth.time_ns);
        }
        let figures = &mut self.figures;
        if belief.state.is_empty() || figures.states.last() == Some(&belief.state) {
            return;
        }
        let since_ns = std::mem::replace(&mut self.state_ns, truth.time_ns);
        let mut led_astray_ns = self.led_astray_ns.iter();
        let led_astray =
            led_astray_ns.any(|when| when.start < truth.time_ns && when.end > since_ns);
        let robot = &self.robot;
        let how = (truth.twist.v_m_s.abs() < STANDING_M_S, kept);
        let before = { figures.states.last() }
            .filter(|_| !led_astray)
            .filter(|name| has_stopped(&robot.site, &robot.fsm, name, &belief.state, how))
            .and_then(|name| robot.fsm.state(name));
        let stop_at = |pose: &Pose| {
            let instructed = self.instructed.as_ref();
            StopError::of(&robot.site, before?, instructed, &robot.footprint, pose)
        };
        let (stop, believed) = (stop_at(&truth.pose), stop_at(&belief.pose));
        figures.states.push(belief.state.clone());
        figures.skills.insert(belief.skill.clone());
        let Some((stop, believed)) = stop.zip(believed) else {
            return;
        };
        let limits = &self.limits;
        let (list, kind, judged, most_m) = match stop.kind {
            StopKind::Dock => (
                &mut figures.dock_errors_m,
                ViolationKind::Docking,
                stop,
                limits.dock_error_m,
            ),
            StopKind::Pose => {
                let most_m = limits.pose_stop_error_m;
                (
                    &mut figures.pose_stop_errors_m,
                    ViolationKind::StopPose,
                    believed,
                    most_m,
                )
            }
            StopKind::Border => {
                let most_m = limits.border_stop_error_m;
                (
                    &mut figures.border_stop_errors_m,
                    ViolationKind::StopBorder,
                    stop,
                    most_m,
                )
            }
        };
        list.push(stop.error_m);
        if let Some(most_m) = most_m.filter(|most_m| judged.error_m.abs() > *most_m) {
            let detail = format!(
                "stopped {:.3} m off, expected at most {most_m} m",
                judged.error_m
            );
            violations.report(kind, &robot.name, truth.time_ns, detail);
        }
    }
}
