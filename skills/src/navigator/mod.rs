//! Navigation as one step: pose, perception, monitors, the robot's machine, and its controller.
//!
//! [`Navigator::step`] does, in this order: moves the pose and all estimates with odometry; looks at a new scan, with what
//! the present schedule perceives; evaluates the controller and the monitors; steps the machine with what was posted and
//! what fired, which may exchange the schedule; plans the path ahead; and commands a motion under the schedule in force
//! then, within the limits of speed, borders and instruction.
//!
//! Without a scan it goes on by odometry, and the covariance grows until the pose is uncertain. Then, when motion is not
//! allowed, and before an area that is not allowed, the command keeps its curve with speed 0. It goes on by itself when
//! the reason is over.
//!
//! Real time: [`Navigator::step`], [`Navigator::post`] and [`Navigator::instruct`] do not allocate, lock or panic;
//! [`Navigator::new`] does allocate.

mod command;
mod control;
mod coordinate;
mod goal;
mod instruction;
mod look;
mod motion;
mod output;
mod setup;
mod take_over;

pub use instruction::{Instruction, InstructionError, Parameters};
pub use output::{
    EventList, Hold, MAX_EVENTS, NavigationCounters, NavigationInput, NavigationOutput,
};
pub use setup::{NavigationGains, NavigatorSetup, SetupError};

use crate::borders::{BorderGains, BorderGuard};
use crate::control::{ControlGains, SpeedRamp, Stopping};
use crate::localisation::PoseFilter;
use crate::map::{LaneWall, SemanticMap};
use crate::perception::corridor::CorridorTracker;
use crate::perception::lane_end::LaneEndTracker;
use crate::perception::line::LineFitter;
use crate::perception::walls::WallMatcher;
use crate::schedule::{RobotLimits, Schedule, compile};
use crate::tubes::Room;
use command::Commanded;
use control::Control;
use coordination::event::EventId;
use coordination::fsm::{Machine, StateId};
use description::geometry::{Footprint, Point2, Pose2};
use goal::Goal;
use instruction::Inbox;
use motion::{Motion, PATH_POSES};

/// Poses of the planned path lie at least so far apart.
const PATH_STEP_M: f64 = 0.05;
/// No step is longer than this, whatever the clock says.
const LONGEST_STEP_S: f64 = 1.0;
/// Between the footprint and a border, beside the uncertainty of the pose.
const BORDER_MARGIN_M: f64 = 0.01;

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
    matcher: WallMatcher,
    guard: BorderGuard,
    footprint: Footprint,
    border_sigma: f64,
    max_speed_m_s: f64,
    motion: Motion,
    goal: Goal,
    stopping: Stopping,
    /// Where the instruction says to stop.
    instructed: Option<Goal>,
    halting: Stopping,
    ramp: SpeedRamp,
    last_curvature_1_m: f64,
    path: Vec<Pose2>,
    path_step_m: f64,
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
            &RobotLimits {
                max_speed_m_s,
                max_curvature_1_m: setup.gains.max_curvature_1_m,
                footprint: setup.footprint,
            },
        )?;
        if let Some(name) = &setup.start_state {
            let state = machine
                .state_id(name)
                .ok_or_else(|| SetupError::StartState(name.clone()))?;
            machine.restart_in(state);
        }
        let gains = setup.gains;
        let matcher = WallMatcher::new(&map, setup.beams, gains.perception());
        let guard = BorderGuard::new(
            map.areas().iter().map(|area| area.region),
            setup.footprint,
            BorderGains {
                sigmas: gains.border_sigma,
                margin_m: BORDER_MARGIN_M,
            },
        );
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
            matcher,
            guard,
            footprint: setup.footprint,
            border_sigma: gains.border_sigma,
            max_speed_m_s,
            motion: Motion::Still,
            goal: Goal::None,
            stopping: Stopping::default(),
            instructed: None,
            halting: Stopping::default(),
            ramp: SpeedRamp::new(gains.acceleration_m_s2, gains.deceleration_m_s2),
            last_curvature_1_m: 0.0,
            path: Vec::with_capacity(PATH_POSES),
            path_step_m: path_step_m(max_speed_m_s, gains.deceleration_m_s2),
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

    /// What holds for the present state.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        self.parameters
    }

    /// Exchanges what holds for the present state, without an event; the default clears it. The state and its path go
    /// on. What is refused changes nothing. Real time.
    pub fn set_parameters(&mut self, parameters: Parameters) -> Result<(), InstructionError> {
        parameters.validate()?;
        let same_stop = parameters.stop_at == self.parameters.stop_at;
        self.parameters = parameters;
        if !same_stop {
            self.begin_parameters();
        }
        Ok(())
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
            self.parameters = Parameters::default();
            self.activate(None);
        }
        known
    }

    /// Where the present controller is going to lead `base_link`, in `map`: poses at equal distances ahead (behind, when
    /// it creeps backward), up to where it stops. As of the last step.
    #[must_use]
    pub fn planned_path(&self) -> &[Pose2] {
        &self.path
    }

    /// One step.
    pub fn step(&mut self, input: &NavigationInput) -> NavigationOutput {
        self.counters.steps += 1;
        let dt_s = self.predict(input);
        self.look(input);
        let before = self.machine.state();
        let mut control = self.control(input, dt_s);
        let (mut events, mut outputs) = (EventList::default(), EventList::default());
        self.watch(&control, &mut events);
        self.coordinate(&events, &mut outputs);
        let state = self.machine.state();
        if state != before {
            // The manoeuvre that is done is the one before; its successor already commands.
            let done = control.done;
            control = self.control(input, dt_s);
            control.done = done;
        }
        let commanded = self.command(input, &control, dt_s);
        let mut output = self.report(input, &control, &commanded);
        output.events = events;
        output.outputs = outputs;
        output.schedule_changed = state != before;
        output
    }

    /// Moves everything with odometry; the time since the step before.
    fn predict(&mut self, input: &NavigationInput) -> f64 {
        let dt_s = match self.last_step_ns {
            0 => 0.0,
            last_ns => (input.now_ns.saturating_sub(last_ns) as f64 * 1e-9).min(LONGEST_STEP_S),
        };
        self.last_step_ns = input.now_ns;
        self.in_state_s += dt_s;
        let before = self.pose.pose();
        let moved = self.pose.predict(input.odometry);
        self.corridor.predict(moved, dt_s);
        if let Some(wall) = self.end_wall() {
            self.lane_end.predict(moved, before, &wall.line, dt_s);
        }
        dt_s
    }

    fn end_wall(&self) -> Option<LaneWall> {
        end_wall(&self.map, self.schedule_now()).copied()
    }

    fn report(
        &self,
        input: &NavigationInput,
        control: &Control,
        commanded: &Commanded,
    ) -> NavigationOutput {
        let schedule = self.schedule_now();
        let covariance = self.pose.covariance();
        let mut counters = self.counters;
        counters.pose = self.pose.counters();
        let error = control.steer.error;
        NavigationOutput {
            now_ns: input.now_ns,
            command: commanded.command,
            pose: self.pose.pose(),
            covariance: std::array::from_fn(|row| {
                std::array::from_fn(|column| covariance[(row, column)])
            }),
            position_std_m: self.pose.position_std_m(),
            state: self.machine.state(),
            area: schedule.area,
            skill: schedule.skill,
            lateral_error_m: error.lateral_m,
            heading_error_rad: error.heading_rad,
            room: Room {
                lateral_m: error.lateral_m,
                heading_rad: error.heading_rad,
                path_curvature_1_m: control.steer.path_curvature_1_m,
                limit_m: schedule.keep_within_m(),
                behind_m: commanded.behind_m,
                tightest_1_m: self.control.max_curvature_1_m,
            },
            corridor: self
                .corridor
                .estimate()
                .filter(|_| schedule.features.corridor),
            lane_end: self
                .lane_end
                .estimate()
                .filter(|_| schedule.features.lane_end),
            events: EventList::default(),
            outputs: EventList::default(),
            schedule_changed: false,
            manoeuvre_done: control.done,
            pose_uncertain: self.pose.is_uncertain(),
            deviation_exceeded: error.lateral_m.abs() > schedule.deviation_limit_m,
            hold: commanded.hold,
            waiting_for: commanded.border.area.filter(|_| commanded.at_border),
            border_distance_m: commanded.border.area.map(|_| commanded.border.distance_m),
            counters,
        }
    }
}

/// Spacing with which the planned path is long enough to stop on, from the fastest speed.
fn path_step_m(max_speed_m_s: f64, deceleration_m_s2: f64) -> f64 {
    let stop_m = max_speed_m_s * max_speed_m_s / (2.0 * deceleration_m_s2) + max_speed_m_s;
    PATH_STEP_M.max(1.2 * stop_m / PATH_POSES as f64)
}

/// The wall that closes the schedule's lane, or the lane that its U-turn leaves.
fn end_wall<'a>(map: &'a SemanticMap, schedule: &Schedule) -> Option<&'a LaneWall> {
    schedule
        .end_lane
        .and_then(|lane| map.lanes()[lane].end.as_ref())
}
