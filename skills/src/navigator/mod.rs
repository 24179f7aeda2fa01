//! Navigation as one step: pose, perception, monitors, the robot's machine, and its controller.
//!
//! [`Navigator::step`] does, in this order: moves the pose and all estimates with odometry; looks at a new scan, with what
//! the present schedule perceives; evaluates the controller and the monitors; steps the machine with what was posted and
//! what fired, which may exchange the schedule; and commands a motion under the schedule in force then.
//!
//! Without a scan it goes on by odometry, and the covariance grows until the pose is uncertain. Then, and when motion is
//! not allowed, the command keeps its curve with speed 0.
//!
//! Real time: [`Navigator::step`] and [`Navigator::post`] do not allocate, lock or panic; [`Navigator::new`] does
//! allocate.

mod output;
mod setup;

pub use output::{EventList, MAX_EVENTS, NavigationCounters, NavigationInput, NavigationOutput};
pub use setup::{NavigationGains, NavigatorSetup, SetupError};

use crate::control::{ControlGains, ControlOutput, Corridor, PathError, UTurn};
use crate::geometry::{MotionCommand, Point2, Pose2, Segment, wrap_angle};
use crate::localisation::PoseFilter;
use crate::map::{LaneGeometry, LaneWall, SemanticMap};
use crate::monitors::Situation;
use crate::perception::corridor::CorridorTracker;
use crate::perception::lane_end::LaneEndTracker;
use crate::perception::line::LineFitter;
use crate::schedule::{Controller, Schedule, compile};
use coordination::event::EventId;
use coordination::fsm::{Machine, StateId};
use std::f64::consts::FRAC_PI_2;

/// A scan taken farther away than this from where odometry is now is of no use.
const SCAN_REACH_M: f64 = 1.0;
/// A corridor that was lost is looked for with at least this uncertainty.
const RESTART_STD_M: f64 = 0.15;
const RESTART_STD_RAD: f64 = 0.10;
/// A lane end known worse than this is taken from the map instead.
const LANE_END_STD_M: f64 = 0.15;

/// The navigation of one robot.
#[derive(Clone, Debug)]
pub struct Navigator {
    map: SemanticMap,
    machine: Machine,
    schedules: Vec<Schedule>,
    skill_names: Vec<String>,
    control: ControlGains,
    pose: PoseFilter,
    fitter: LineFitter,
    points: Vec<Point2>,
    corridor: CorridorTracker,
    lane_end: LaneEndTracker,
    u_turn: Option<UTurn>,
    posted: EventList,
    last_step_ns: u64,
    last_scan_ns: u64,
    counters: NavigationCounters,
}

impl Navigator {
    /// Checks the setup and starts in its start state.
    pub fn new(setup: NavigatorSetup) -> Result<Self, SetupError> {
        setup.gains.validate()?;
        let max_speed_m_s = setup.max_speed_m_s;
        if !(max_speed_m_s.is_finite() && max_speed_m_s > 0.0) {
            let what = "maximum speed";
            let found = max_speed_m_s;
            return Err(SetupError::NotPositive { what, found });
        }
        if !setup.start.is_finite() {
            return Err(SetupError::Start);
        }
        let map = SemanticMap::new(&setup.map)?;
        let mut machine = setup.machine;
        let schedules = compile(
            &map,
            &machine,
            &setup.states,
            &setup.skills,
            &setup.monitors,
            max_speed_m_s,
        )?;
        if let Some(name) = &setup.start_state {
            let state = machine
                .state_id(name)
                .ok_or_else(|| SetupError::StartState(name.clone()))?;
            machine.restart_in(state);
        }
        let gains = setup.gains;
        let mut navigator = Self {
            map,
            machine,
            schedules,
            skill_names: setup.skills.into_iter().map(|skill| skill.id).collect(),
            control: gains.control(),
            pose: PoseFilter::new(
                gains.pose(),
                setup.start,
                gains.start_std_m,
                gains.start_std_rad,
            ),
            fitter: LineFitter::new(setup.beams, gains.perception()),
            points: Vec::with_capacity(setup.beams),
            corridor: CorridorTracker::new(gains.perception()),
            lane_end: LaneEndTracker::new(gains.perception()),
            u_turn: None,
            posted: EventList::default(),
            last_step_ns: 0,
            last_scan_ns: 0,
            counters: NavigationCounters::default(),
        };
        navigator.activate(None);
        Ok(navigator)
    }

    /// The machine, for names.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The map, for names.
    #[must_use]
    pub fn map(&self) -> &SemanticMap {
        &self.map
    }

    /// The name of a skill by its index.
    #[must_use]
    pub fn skill_name(&self, skill: usize) -> &str {
        self.skill_names.get(skill).map_or("?", String::as_str)
    }

    /// What runs in a state.
    #[must_use]
    pub fn schedule(&self, state: StateId) -> Option<&Schedule> {
        self.schedules.get(state.index())
    }

    /// Gives the machine an event from elsewhere with the next step; `false`: too many wait, the event is counted as lost.
    pub fn post(&mut self, event: EventId) -> bool {
        let taken = self.posted.push(event);
        self.counters.events_lost += u64::from(!taken);
        taken
    }

    /// Puts the robot somewhere else in the map, as an operator does. A pose that is not finite is refused.
    pub fn relocate(&mut self, pose: Pose2, std_m: f64, std_rad: f64) -> bool {
        if !(pose.is_finite() && std_m > 0.0 && std_rad > 0.0) {
            return false;
        }
        self.pose.relocate(pose, std_m, std_rad);
        self.activate(None);
        true
    }

    /// Goes on in another state, without firing anything; `false` when the machine has no such state.
    pub fn restart_in(&mut self, state: StateId) -> bool {
        let known = self.machine.restart_in(state);
        if known {
            self.activate(None);
        }
        known
    }

    /// One step.
    pub fn step(&mut self, input: &NavigationInput) -> NavigationOutput {
        self.counters.steps += 1;
        self.predict(input);
        self.look(input);
        let before = self.machine.state();
        let mut control = self.control(input);
        let (mut events, mut outputs) = (EventList::default(), EventList::default());
        self.watch(&control, &mut events);
        self.coordinate(&events, &mut outputs);
        let state = self.machine.state();
        if state != before {
            // The manoeuvre that is done is the one before; its successor already commands.
            let done = control.done;
            control = self.control(input);
            control.done = done;
        }
        self.report(input, before, &control, events, outputs)
    }

    fn predict(&mut self, input: &NavigationInput) {
        let dt_s = match self.last_step_ns {
            0 => 0.0,
            last_ns => input.now_ns.saturating_sub(last_ns) as f64 * 1e-9,
        };
        self.last_step_ns = input.now_ns;
        let before = self.pose.pose();
        let moved = self.pose.predict(input.odometry);
        self.corridor.predict(moved, dt_s);
        if let Some(wall) = self.end_wall() {
            self.lane_end.predict(moved, before, &wall.line, dt_s);
        }
    }

    /// Uses a scan that was not seen before.
    fn look(&mut self, input: &NavigationInput) {
        let Some(scan) = input.scan.filter(|scan| scan.is_valid()) else {
            return;
        };
        let reference_ns = scan.reference_ns();
        if reference_ns == self.last_scan_ns {
            return;
        }
        let since = input.odometry.pose.between(scan.odom_pose());
        let near = since.is_finite() && since.position().norm_m() < SCAN_REACH_M;
        if reference_ns < self.last_scan_ns || !near {
            self.counters.scans_refused += 1;
            // A clock that was set back must not blind the robot for good.
            self.last_scan_ns = reference_ns;
            return;
        }
        self.last_scan_ns = reference_ns;
        self.counters.scans += 1;
        let room = self.points.capacity();
        self.points.clear();
        self.points
            .extend(scan.hits().take(room).map(|point| since.transform(point)));
        self.see_corridor();
    }

    fn see_corridor(&mut self) {
        let schedule = &self.schedules[self.machine.state().index()];
        let (mut seen, mut accepted) = (false, false);
        if let Some(lane) = schedule.lane.filter(|_| schedule.features.corridor) {
            let lane = &self.map.lanes()[lane];
            let pose = self.pose.pose();
            let along_m = lane.line.along_m(pose.position());
            let walls = self
                .corridor
                .observe(&mut self.fitter, &self.points, lane, along_m);
            if schedule.tracks.corridor {
                for (wall, fit) in [(&lane.left, walls.left), (&lane.right, walls.right)] {
                    if let (Some(wall), Some(fit)) = (wall, fit) {
                        seen = true;
                        accepted |= self.pose.correct(&wall.line, &fit);
                    }
                }
            }
            if self.corridor.is_lost() {
                self.counters.corridor_restarts += 1;
                let std_m = self.pose.position_std_m().max(RESTART_STD_M);
                let std_rad = self.pose.heading_std_rad().max(RESTART_STD_RAD);
                self.corridor.start(lane, self.pose.pose(), std_m, std_rad);
            }
        }
        let end = end_wall(&self.map, schedule);
        if let Some(wall) = end.filter(|_| schedule.features.lane_end) {
            let pose = self.pose.pose();
            let std_m = self.pose.std_along_m(wall.direction_rad + FRAC_PI_2);
            let fit =
                self.lane_end
                    .observe(&mut self.fitter, &self.points, &wall.line, pose, std_m);
            if let Some(fit) = fit.filter(|_| schedule.tracks.lane_end) {
                seen = true;
                accepted |= self.pose.correct(&wall.line, &fit);
            }
        }
        if seen {
            self.pose.scan_done(accepted);
        }
    }

    /// The motion that the present schedule's controller wants.
    fn control(&mut self, input: &NavigationInput) -> ControlOutput {
        let schedule = &self.schedules[self.machine.state().index()];
        let pose = self.pose.pose();
        let error = self.lane_error(schedule);
        let speed_m_s = input.odometry.twist.v_m_s;
        let limit_m_s = schedule.speed_limit_m_s;
        let output = match schedule.controller {
            Controller::Stop => ControlOutput {
                command: MotionCommand::STOP,
                error,
                done: true,
            },
            Controller::Corridor => Corridor.step(error, limit_m_s, &self.control),
            Controller::EndOfLane(end) => {
                let wall_m = self.end_distance_m(schedule);
                end.step(error, wall_m, limit_m_s, speed_m_s, &self.control)
            }
            Controller::UTurn { .. } => match &mut self.u_turn {
                Some(turn) => turn.step(pose, limit_m_s, speed_m_s, &self.control),
                None => ControlOutput::default(),
            },
        };
        if output.command.is_finite() {
            output
        } else {
            ControlOutput::default()
        }
    }

    /// Relative to the schedule's lane: by the corridor while it is known well, by the pose otherwise.
    fn lane_error(&self, schedule: &Schedule) -> PathError {
        let Some(lane) = schedule.lane.map(|lane| &self.map.lanes()[lane]) else {
            return PathError::default();
        };
        let corridor = self.corridor.estimate();
        match corridor.filter(|estimate| schedule.features.corridor && estimate.usable) {
            Some(estimate) => PathError {
                lateral_m: estimate.lateral_m,
                heading_rad: estimate.heading_rad,
            },
            None => pose_error(lane, self.pose.pose()),
        }
    }

    fn end_distance_m(&self, schedule: &Schedule) -> f64 {
        let tracked = self.lane_end.estimate();
        if let Some(end) = tracked.filter(|end| end.std_m < LANE_END_STD_M) {
            return end.distance_m;
        }
        end_wall(&self.map, schedule).map_or(0.0, |wall| {
            wall.line.lateral_m(self.pose.pose().position()).abs()
        })
    }

    fn watch(&mut self, control: &ControlOutput, events: &mut EventList) {
        let schedule = &mut self.schedules[self.machine.state().index()];
        let situation = Situation {
            pose: self.pose.pose(),
            corridor: self
                .corridor
                .estimate()
                .filter(|_| schedule.features.corridor),
            lane_end: self
                .lane_end
                .estimate()
                .filter(|_| schedule.features.lane_end),
            manoeuvre_done: control.done,
            lateral_error_m: control.error.lateral_m,
            deviation_limit_m: schedule.deviation_limit_m,
        };
        for monitor in &mut schedule.monitors {
            if let Some(event) = monitor.step(&situation)
                && !events.push(event)
            {
                self.counters.events_lost += 1;
            }
        }
    }

    /// Steps the machine with what was posted, then with what fired here.
    fn coordinate(&mut self, fired: &EventList, outputs: &mut EventList) {
        while let Some(event) = self.posted.pop_front() {
            self.trigger(event, outputs);
        }
        let state = self.machine.state();
        for &event in fired.as_slice() {
            self.trigger(event, outputs);
            if self.machine.state() != state {
                // What else fired belongs to the schedule that has just ended.
                break;
            }
        }
    }

    fn trigger(&mut self, event: EventId, outputs: &mut EventList) {
        let step = self.machine.step(event);
        let (from, to) = (step.from, step.to);
        for &output in step.outputs {
            if !outputs.push(output) {
                self.counters.events_lost += 1;
            }
        }
        if from != to {
            self.activate(Some(from));
        }
    }

    /// Exchanges the schedule for that of the machine's state.
    fn activate(&mut self, from: Option<StateId>) {
        let (std_m, std_rad) = (self.pose.position_std_m(), self.pose.heading_std_rad());
        let pose = self.pose.pose();
        let before = from.map(|state| &self.schedules[state.index()]);
        let present = &self.schedules[self.machine.state().index()];
        let keeps_corridor = before.is_some_and(|before| {
            before.features.corridor
                && before.lane == present.lane
                && self.corridor.estimate().is_some()
        });
        let keeps_end = before.is_some_and(|before| {
            before.features.lane_end
                && end_wall(&self.map, before).map(|wall| wall.index)
                    == end_wall(&self.map, present).map(|wall| wall.index)
        });
        if !keeps_end {
            self.lane_end.clear();
        }
        match present.lane.filter(|_| present.features.corridor) {
            None => self.corridor.clear(),
            Some(_) if keeps_corridor => {}
            Some(lane) => {
                let lane = &self.map.lanes()[lane];
                let across_m = self.pose.std_along_m(lane.direction_rad + FRAC_PI_2);
                self.corridor
                    .start(lane, pose, across_m.min(std_m), std_rad);
            }
        }
        self.u_turn = match (present.controller, present.lane) {
            (
                Controller::UTurn {
                    direction,
                    radius_m,
                },
                Some(outgoing),
            ) => {
                let line = |lane: usize| self.map.lanes()[lane].line;
                let incoming: Option<Segment> = present.end_lane.map(line);
                let outgoing = line(outgoing);
                Some(UTurn::start(
                    direction,
                    radius_m,
                    incoming.as_ref(),
                    &outgoing,
                    pose,
                ))
            }
            _ => None,
        };
        let state = self.machine.state().index();
        for monitor in &mut self.schedules[state].monitors {
            monitor.reset();
        }
    }

    fn end_wall(&self) -> Option<LaneWall> {
        end_wall(&self.map, &self.schedules[self.machine.state().index()]).copied()
    }

    fn report(
        &self,
        input: &NavigationInput,
        before: StateId,
        control: &ControlOutput,
        events: EventList,
        outputs: EventList,
    ) -> NavigationOutput {
        let state = self.machine.state();
        let schedule = &self.schedules[state.index()];
        let pose_uncertain = self.pose.is_uncertain();
        let stand = pose_uncertain || !input.motion_allowed;
        let covariance = self.pose.covariance();
        let mut counters = self.counters;
        counters.pose = self.pose.counters();
        NavigationOutput {
            now_ns: input.now_ns,
            command: if stand {
                control.command.with_speed(0.0)
            } else {
                control.command
            },
            pose: self.pose.pose(),
            covariance: std::array::from_fn(|row| {
                std::array::from_fn(|column| covariance[(row, column)])
            }),
            position_std_m: self.pose.position_std_m(),
            state,
            area: schedule.area,
            skill: schedule.skill,
            lateral_error_m: control.error.lateral_m,
            heading_error_rad: control.error.heading_rad,
            corridor: self
                .corridor
                .estimate()
                .filter(|_| schedule.features.corridor),
            lane_end: self
                .lane_end
                .estimate()
                .filter(|_| schedule.features.lane_end),
            events,
            outputs,
            schedule_changed: state != before,
            manoeuvre_done: control.done,
            pose_uncertain,
            deviation_exceeded: control.error.lateral_m.abs() > schedule.deviation_limit_m,
            counters,
        }
    }
}

/// The wall that closes the schedule's lane, or the lane that its U-turn leaves.
fn end_wall<'a>(map: &'a SemanticMap, schedule: &Schedule) -> Option<&'a LaneWall> {
    schedule
        .end_lane
        .and_then(|lane| map.lanes()[lane].end.as_ref())
}

fn pose_error(lane: &LaneGeometry, pose: Pose2) -> PathError {
    PathError {
        lateral_m: lane.line.lateral_m(pose.position()),
        heading_rad: wrap_angle(pose.theta_rad - lane.direction_rad),
    }
}
