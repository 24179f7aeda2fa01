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

mod coordinate;
mod instruction;
mod look;
mod output;
mod setup;

pub use instruction::{Instruction, InstructionError};
pub use output::{
    EventList, Hold, MAX_EVENTS, NavigationCounters, NavigationInput, NavigationOutput,
};
pub use setup::{NavigationGains, NavigatorSetup, SetupError};

use instruction::{Inbox, Parameters};

use crate::control::{ControlGains, ControlOutput, Corridor, PathError, UTurn};
use crate::geometry::{MotionCommand, Point2, Pose2, wrap_angle};
use crate::localisation::PoseFilter;
use crate::map::{LaneGeometry, LaneWall, SemanticMap};
use crate::perception::corridor::CorridorTracker;
use crate::perception::lane_end::LaneEndTracker;
use crate::perception::line::LineFitter;
use crate::schedule::{Controller, Schedule, compile};
use coordination::event::EventId;
use coordination::fsm::{Machine, StateId};

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
    inbox: Inbox,
    parameters: Parameters,
    in_state_s: f64,
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
        if !setup.footprint.is_valid() {
            return Err(SetupError::Footprint);
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
            inbox: Inbox::default(),
            parameters: Parameters::default(),
            in_state_s: 0.0,
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
        self.instruct(Instruction::plain(event)).is_ok()
    }

    /// The same with parameters for the state that the event enters. What is refused changes nothing.
    pub fn instruct(&mut self, instruction: Instruction) -> Result<(), InstructionError> {
        instruction.validate()?;
        if self.inbox.push(instruction) {
            return Ok(());
        }
        self.counters.events_lost += 1;
        Err(InstructionError::Full)
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
        self.in_state_s += dt_s;
        let before = self.pose.pose();
        let moved = self.pose.predict(input.odometry);
        self.corridor.predict(moved, dt_s);
        if let Some(wall) = self.end_wall() {
            self.lane_end.predict(moved, before, &wall.line, dt_s);
        }
    }

    /// The motion that the present schedule's controller wants.
    fn control(&mut self, input: &NavigationInput) -> ControlOutput {
        let schedule = &self.schedules[self.machine.state().index()];
        let pose = self.pose.pose();
        let error = self.lane_error(schedule);
        let speed_m_s = input.odometry.twist.v_m_s;
        let limit_m_s = schedule
            .speed_limit_m_s
            .min(self.parameters.speed_limit_m_s.unwrap_or(f64::INFINITY));
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
            hold: match (pose_uncertain, input.motion_allowed) {
                (true, _) => Some(Hold::PoseUncertain),
                (_, false) => Some(Hold::Forbidden),
                _ => None,
            },
            waiting_for: None,
            border_distance_m: None,
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
