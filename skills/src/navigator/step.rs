//! One step of navigation, with its look at a new scan, and what may be asked of a navigator between two.

use super::command::Commanded;
use super::control::Control;
use super::instruction::{Instruction, InstructionError, Parameters, validate};
use super::output::{EventList, NavigationInput, NavigationOutput, PoseCheck};
use super::state::{Navigator, end_wall};
use crate::localisation::{PoseFilter, ScanVerdict};
use crate::perception::WallFit;
use crate::perception::line::ScanPoints;
use crate::scan::AlignedScan;
use crate::tubes::Room;
use coordination::event::EventId;
use coordination::fsm::StateId;
use description::geometry::{Point2, Pose2, Segment};
use std::f64::consts::FRAC_PI_2;

/// No step is longer than this, whatever the clock says.
const LONGEST_STEP_S: f64 = 1.0;
/// A scan taken farther than this from the present odometry pose is refused.
const SCAN_REACH_M: f64 = 1.0;
/// The search for a lost corridor starts with at least this uncertainty.
const RESTART_STD_M: f64 = 0.15;
const RESTART_STD_RAD: f64 = 0.10;

impl Navigator {
    /// Gives the machine an event from elsewhere with the next step; `false`: too many wait, the event is counted as lost.
    pub fn post(&mut self, event: EventId) -> bool {
        self.instruct(Instruction::plain(event)).is_ok()
    }

    /// The same with parameters for the state that the event enters. What is refused changes nothing.
    ///
    /// # Errors
    /// [`InstructionError`]: a parameter is refused, or too many instructions wait.
    pub fn instruct(&mut self, instruction: Instruction) -> Result<(), InstructionError> {
        validate(&instruction)?;
        if self.inbox.push(instruction) {
            return Ok(());
        }
        self.counters.events_lost += 1;
        Err(InstructionError::Full)
    }

    /// Exchanges what holds for the present state, without an event; the default clears it. The state and its path go
    /// on. What is refused changes nothing. Real time.
    ///
    /// # Errors
    /// [`InstructionError::SpeedLimit`] or [`InstructionError::StopPose`].
    pub fn set_parameters(&mut self, parameters: Parameters) -> Result<(), InstructionError> {
        validate(&parameters)?;
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
        self.check = None;
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

    /// One step.
    pub fn step(&mut self, input: &NavigationInput) -> NavigationOutput {
        self.counters.steps += 1;
        let dt_s = self.predict(input);
        self.look(input);
        let before = self.machine.state();
        let by_hand = self.is_by_hand(input);
        let mut control = self.wanted(input, by_hand, dt_s);
        let (mut events, mut outputs) = (EventList::default(), EventList::default());
        if !by_hand {
            self.watch(&control, &mut events);
        }
        self.coordinate(&events, &mut outputs);
        let state = self.machine.state();
        if state != before {
            // The manoeuvre that is done is the one before; its successor already commands.
            let done = control.done;
            control = self.wanted(input, by_hand, dt_s);
            control.done = done;
        }
        let commanded = self.command(input, &control, dt_s);
        let mut output = self.report(input, &control, &commanded);
        output.events = events;
        output.outputs = outputs;
        output.schedule_changed = state != before;
        output
    }

    fn wanted(&mut self, input: &NavigationInput, by_hand: bool, dt_s: f64) -> Control {
        if by_hand {
            self.control_by_hand(input)
        } else {
            self.control(input, dt_s)
        }
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
        let is_known = !input.lost && !self.pose.is_uncertain();
        let known = is_known.then(|| self.pose.pose());
        self.blind = self.matcher.is_blind(scan, since, known);
        if self.blind {
            self.counters.scans_blind += 1;
            let tracks = self.schedule_now().tracks;
            if tracks.walls || tracks.corridor || tracks.lane_end {
                self.pose.scan_done(ScanVerdict::Blind);
                self.check = Some(PoseCheck::of(ScanVerdict::Blind));
            }
            return;
        }
        self.counters.scans += 1;
        let room = self.points.capacity();
        self.points.clear();
        let to_now = since.transformation();
        self.points.extend(scan.hits().take(room).map(to_now));
        let eye = since.compose(scan.geometry().mount).position();
        self.see(scan, since, eye);
    }

    /// Looks for the schedule's features and corrects the pose by those that it tracks: by all walls in view, or else by
    /// those of corridor and lane end. The same points never correct twice.
    fn see(&mut self, scan: &AlignedScan, since: Pose2, eye: Point2) {
        let tracks = self.schedule_now().tracks;
        if tracks.walls {
            let outcome = self.pose.see_walls(&mut self.matcher, scan, since);
            self.check = Some(outcome.into());
        }
        let mut best = ScanVerdict::Blind;
        let sight_m = scan.geometry().range_max_m;
        self.see_corridor(&mut best, eye, sight_m, tracks.corridor && !tracks.walls);
        self.see_lane_end(&mut best, eye, sight_m, tracks.lane_end && !tracks.walls);
        if !tracks.walls && (tracks.corridor || tracks.lane_end) {
            self.pose.scan_done(best);
            self.check = Some(PoseCheck::of(best));
        }
    }

    fn see_corridor(&mut self, best: &mut ScanVerdict, eye: Point2, sight_m: f64, corrects: bool) {
        let schedule = &self.schedules[self.machine.state().index()];
        let Some(lane) = schedule.lane.filter(|_| schedule.features.corridor) else {
            return;
        };
        let lane = &self.map.lanes()[lane];
        let along_m = lane.line.along_m(self.pose.pose().position());
        let points = ScanPoints {
            points: &self.points,
            eye,
            sight_m,
        };
        let walls = self
            .corridor
            .observe(&mut self.fitter, points, lane, along_m);
        if corrects {
            for (wall, fit) in walls.fits() {
                correct(&mut self.pose, &wall.line, fit, best);
            }
        }
        if self.corridor.is_lost() {
            self.counters.corridor_restarts += 1;
            let std_m = self.pose.position_std_m().max(RESTART_STD_M);
            let std_rad = self.pose.heading_std_rad().max(RESTART_STD_RAD);
            self.corridor.start(lane, self.pose.pose(), std_m, std_rad);
        }
    }

    fn see_lane_end(&mut self, best: &mut ScanVerdict, eye: Point2, sight_m: f64, corrects: bool) {
        let schedule = &self.schedules[self.machine.state().index()];
        let end = end_wall(&self.map, schedule);
        let Some(wall) = end.filter(|_| schedule.features.lane_end) else {
            return;
        };
        let std_m = self.pose.std_along_m(wall.direction_rad + FRAC_PI_2);
        let points = ScanPoints {
            points: &self.points,
            eye,
            sight_m,
        };
        let fit = self.lane_end.observe(
            &mut self.fitter,
            points,
            &wall.line,
            self.pose.pose(),
            std_m,
        );
        if let Some(fit) = fit.filter(|_| corrects) {
            correct(&mut self.pose, &wall.line, &fit, best);
        }
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
                tightest_1_m: self.gains.max_curvature_1_m,
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
            blind: self.blind,
            check: self.check,
            deviation_exceeded: error.lateral_m.abs() > schedule.deviation_limit_m,
            hold: commanded.hold,
            waiting_for: commanded.border.area.filter(|_| commanded.at_border),
            border_distance_m: commanded.border.area.map(|_| commanded.border.distance_m),
            counters,
        }
    }
}

fn correct(pose: &mut PoseFilter, line: &Segment, fit: &WallFit, best: &mut ScanVerdict) {
    if pose.correct(line, fit) {
        *best = ScanVerdict::Corrected;
    } else if *best == ScanVerdict::Blind {
        *best = ScanVerdict::Refused;
    }
}
