//! Navigation with leave for areas.
//!
//! The robot's own navigation activity has leave for every area: who would withhold it, a mediator, does not exist yet.
//! This one gives the same navigator the same inputs and publishes the same symbols, and passes on the leave that the
//! trial gives. Reloads are left out. It goes when the robot's own takes leave.

use std::sync::{Arc, Mutex, PoisonError};

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::symbols::Stamped;
use onboard::activities::navigation::{Symbols, hold_name};
use onboard::activities::scans::{Intake, ScanIntake};
use onboard::faults::Fault;
use onboard::port::{Command, Instructed, Port, Report};
use onboard::runner::RobotActivity;
use onboard::values::{Name, NavigationState, OdometryValue, PoseEstimate, WantedMotion};
use skills::borders::AreaSet;
use skills::navigator::{NavigationInput, NavigationOutput, Navigator};
use skills::odometry::Odometry;

/// Leave, shared with who gives it.
pub(super) type SharedLeave = Arc<Mutex<AreaSet>>;

/// The activity.
pub(super) struct LeaveNavigation {
    port: Port,
    symbols: Symbols,
    intake: ScanIntake,
    navigator: Box<Navigator>,
    leave: SharedLeave,
    fresh_scan: bool,
    odometry: Stamped<OdometryValue>,
    output: Option<NavigationOutput>,
    schedule_changes: u64,
    instructed: bool,
}

impl LeaveNavigation {
    pub(super) fn new(
        port: Port,
        symbols: Symbols,
        intake: ScanIntake,
        navigator: Box<Navigator>,
        leave: SharedLeave,
    ) -> Self {
        Self {
            port,
            symbols,
            intake,
            navigator,
            leave,
            fresh_scan: false,
            odometry: Stamped::default(),
            output: None,
            schedule_changes: 0,
            instructed: false,
        }
    }

    fn step(&mut self, now_ns: u64, motion_allowed: bool) {
        let value = self.odometry.value;
        if self.odometry.stamp_ns == 0 {
            return; // the drive has not spoken yet
        }
        let odometry = Odometry {
            stamp_ns: self.odometry.stamp_ns,
            pose: value.pose(),
            twist: value.twist(),
            steering_rad: value.steering_rad,
            distance_m: value.distance_m,
            turned_rad: value.turned_rad,
        };
        let before = self.navigator.machine().state();
        let output = self.navigator.step(&NavigationInput {
            now_ns,
            scan: self.fresh_scan.then(|| self.intake.aligned()),
            odometry: &odometry,
            motion_allowed,
            allowed: *self.leave.lock().unwrap_or_else(PoisonError::into_inner),
        });
        let (from, to) = (before.0, output.state.0);
        if from != to {
            self.port.report(Report::Moved { from, to });
        }
        if std::mem::take(&mut self.instructed) {
            let hold = output.hold;
            let taken = Instructed::Taken { from, to, hold };
            self.port.report(Report::Instructed(taken));
        }
        self.schedule_changes += u64::from(output.schedule_changed);
        let (lost, std_m) = (output.pose_uncertain, output.position_std_m);
        self.port.set(Fault::PoseUncertain, lost, std_m);
        let (strayed, error_m) = (output.deviation_exceeded, output.lateral_error_m);
        self.port.set(Fault::OffLane, strayed, error_m);
        self.output = Some(output);
    }

    fn publish(&mut self, now_ns: u64, output: &NavigationOutput) {
        let std = |axis: usize| output.covariance[axis][axis].max(0.0).sqrt();
        let pose = PoseEstimate {
            x_m: output.pose.x_m,
            y_m: output.pose.y_m,
            theta_rad: output.pose.theta_rad,
            std_x_m: std(0),
            std_y_m: std(1),
            std_theta_rad: std(2),
            uncertain: u64::from(output.pose_uncertain),
        };
        let areas = self.navigator.map().areas();
        let area = |index: Option<usize>| {
            index
                .and_then(|index| areas.get(index))
                .map(|area| Name::new(&area.id))
                .unwrap_or_default()
        };
        let machine = self.navigator.machine();
        let state = NavigationState {
            state: Name::new(machine.state_name(output.state)),
            area: area(output.area),
            skill: Name::new(self.navigator.skill_name(output.skill)),
            lateral_error_m: output.lateral_error_m,
            heading_error_rad: output.heading_error_rad,
            lane_end_m: output.lane_end.map_or(f64::NAN, |end| end.distance_m),
            hold: output
                .hold
                .map(|hold| Name::new(hold_name(hold)))
                .unwrap_or_default(),
            waiting_for: area(output.waiting_for),
            border_distance_m: output.border_distance_m.unwrap_or(f64::NAN),
            schedule_changes: self.schedule_changes,
            ignored_events: machine.ignored(),
            ..NavigationState::default()
        };
        let command = WantedMotion::new(output.command, output.room);
        self.symbols.pose.write(now_ns, &pose);
        self.symbols.state.write(now_ns, &state);
        self.symbols.command.write(now_ns, &command);
    }
}

impl Activity for LeaveNavigation {
    fn name(&self) -> &'static str {
        "navigation"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, _now_ns: u64) {
        self.odometry = self.symbols.odometry.read();
        let (scan, trace) = (&mut self.symbols.scan, &mut self.symbols.trace);
        self.fresh_scan = self.intake.take(scan, trace) == Intake::Aligned;
    }

    fn coordinate(&mut self, _now_ns: u64) {
        while let Some(command) = self.port.next_command() {
            if let Command::Instruct(instruction) = command {
                let state = self.navigator.machine().state().0;
                let refused = if !self.navigator.machine().accepts(instruction.event) {
                    Instructed::Ignored { state }
                } else if let Err(error) = self.navigator.instruct(instruction) {
                    Instructed::Refused(error)
                } else {
                    self.instructed = true;
                    continue;
                };
                self.port.report(Report::Instructed(refused));
            }
        }
    }

    fn configure(&mut self, _now_ns: u64) {
        self.port.step(LifeCycleEvent::Configured);
    }

    fn compute(&mut self, now_ns: u64) {
        self.step(now_ns, true);
    }

    fn rest(&mut self, now_ns: u64) {
        let state = self.port.state();
        if matches!(state, LifeCycleState::Ready | LifeCycleState::Paused) {
            self.step(now_ns, false);
        }
    }

    fn communicate_out(&mut self, now_ns: u64) {
        if let Some(output) = self.output {
            self.publish(now_ns, &output);
        }
        self.port.publish(now_ns);
    }
}

impl RobotActivity for LeaveNavigation {}
