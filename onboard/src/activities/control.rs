//! Control: turns the safe motion command into wheel setpoints.

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::symbols::Stamped;
use description::wheels::WheelSpeeds;
use skills::drive::{STANDING_RAD_S, StopKind, WheelController};

use crate::activities::exchange::Exchange;
use crate::activities::port::Port;
use crate::activities::robot_activity::RobotActivity;
use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS};
use crate::symbols::faults::Fault;
use crate::symbols::values::{Encoders, SafeCommand, WheelSetpoints};
use crate::symbols::wiring::ControlSymbols;

/// Longest time that one step of the controller stands for.
const LONGEST_STEP_NS: u64 = 50 * MILLISECOND_NS;

/// The activity.
pub struct Control {
    port: Port,
    symbols: ControlSymbols,
    controller: Box<WheelController>,
    exchange: Exchange<WheelController>,
    command_timeout_ns: u64,
    command: Stamped<SafeCommand>,
    encoders: Encoders,
    drive_follows: bool,
    setpoints: WheelSpeeds,
    stepped_ns: u64,
    stopping: bool,
}

impl Control {
    /// An activity in state *created*. A command older than `command_timeout_ns` stops the robot.
    #[must_use]
    pub fn new(
        port: Port,
        symbols: ControlSymbols,
        controller: WheelController,
        exchange: Exchange<WheelController>,
        command_timeout_ns: u64,
    ) -> Self {
        Self {
            port,
            symbols,
            controller: Box::new(controller),
            exchange,
            command_timeout_ns,
            command: Stamped::default(),
            encoders: Encoders::default(),
            drive_follows: false,
            setpoints: WheelSpeeds::STANDING,
            stepped_ns: 0,
            stopping: true,
        }
    }

    /// The wheels as they turn.
    fn speeds(&self) -> WheelSpeeds {
        self.encoders.speeds
    }

    fn step(&mut self, now_ns: u64, stop: StopKind) {
        let passed_ns = now_ns.saturating_sub(self.stepped_ns);
        let elapsed_ns = passed_ns.min(LONGEST_STEP_NS);
        self.stepped_ns = now_ns;
        let speeds = self.speeds();
        if passed_ns > LONGEST_STEP_NS {
            // The drive has begun a stop by itself: what was sent before is not what the wheels do.
            self.controller.reset(speeds);
        }
        if !self.drive_follows {
            // The wheels roll to a stand, or a fault stops them. When the drive follows again, that stop is carried
            // on from the speed they have then, before anything is driven.
            self.controller.reset(speeds);
            self.setpoints = WheelSpeeds::STANDING;
            self.stopping = true;
            return;
        }
        self.stopping &= speeds.fastest_rad_s() > STANDING_RAD_S;
        let stop = if self.stopping { StopKind::Hard } else { stop };
        let elapsed_s = elapsed_ns as f64 / SECOND_NS as f64;
        self.setpoints = self.controller.step(
            self.command.value.command,
            stop,
            self.encoders.angles.pivot_rad,
            speeds,
            elapsed_s,
        );
    }
}

impl Activity for Control {
    fn name(&self) -> &'static str {
        "control"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, _now_ns: u64) {
        self.command = self.symbols.command.read();
        self.encoders = self.symbols.encoders.read().value;
        self.drive_follows = self.symbols.drive.read().value.follows != 0;
    }

    fn coordinate(&mut self, _now_ns: u64) {
        while self.port.next_command().is_some() {} // only those of the life cycle concern it
    }

    fn configure(&mut self, _now_ns: u64) {
        if self.port.state() == LifeCycleState::Reconfiguring {
            let Some(mut controller) = self.exchange.take() else {
                return;
            };
            std::mem::swap(&mut self.controller, &mut controller);
            self.exchange.give_back(controller);
            // Its ramp goes on from the speed that the wheels have.
            let speeds = self.speeds();
            self.controller.reset(speeds);
        }
        self.port.step(LifeCycleEvent::Configured);
    }

    fn compute(&mut self, now_ns: u64) {
        let age_ns = now_ns.saturating_sub(self.command.stamp_ns);
        let stale = age_ns > self.command_timeout_ns;
        // Before the first command nothing is late.
        self.port.set(
            Fault::CommandStale,
            stale && self.command.stamp_ns != 0,
            age_ns as f64 / 1e6,
        );
        let stop = if stale || self.command.value.stop != 0 {
            StopKind::Hard
        } else {
            StopKind::None
        };
        self.step(now_ns, stop);
    }

    fn rest(&mut self, now_ns: u64) {
        self.step(now_ns, StopKind::Gentle);
    }

    fn communicate_out(&mut self, now_ns: u64) {
        let speeds = self.setpoints;
        self.symbols
            .setpoints
            .write(now_ns, &WheelSetpoints { speeds });
        self.port.publish(now_ns);
    }
}

impl RobotActivity for Control {}
