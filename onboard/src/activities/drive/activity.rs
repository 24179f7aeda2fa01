//! The activity: its event loop around the bus, and what it judges of the drive.

use std::sync::Arc;

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::symbols::Stamped;
use description::wheels::WheelSpeeds;
use drivers::ethercat::{Bus, BusCounters, ExchangeError};
use drivers::kelo::{self, Feedback, Inputs, Setpoint, SetpointLimits};

use super::bring_ups::BringUpLimit;
use super::health::Health;
use super::ramp::WheelRamp;
use super::settings::{
    BRING_UP, GONE_NS, OpenLink, RETRY_NS, SHUT_DOWN_NS, SWITCHED_ON_NS, Settings, encoders,
};
use crate::activities::port::{Command, Port};
use crate::activities::robot_activity::RobotActivity;
use crate::realtime::clock::{Clock, MILLISECOND_NS, SECOND_NS};
use crate::realtime::guard;
use crate::realtime::log::{Complaints, LogSender};
use crate::realtime::panic::has_panicked;
use crate::symbols::faults::Fault;
use crate::symbols::values::{DriveStatus, WheelSetpoints};
use crate::symbols::wiring::DriveSymbols;

/// How long a robot may take to stop after its fieldbus thread has panicked.
const AFTER_PANIC_NS: u64 = 2 * SECOND_NS;

/// The activity.
pub struct Drive {
    port: Port,
    settings: Settings,
    symbols: DriveSymbols,
    open_link: OpenLink,
    clock: Arc<dyn Clock>,
    log: LogSender,
    bus: Option<Bus>,
    ramp: WheelRamp,
    wanted: Stamped<WheelSetpoints>,
    inputs: Inputs,
    status: DriveStatus,
    /// How often the drive was found to have lost power.
    encoder_epoch: u64,
    answered_ns: u64,
    /// Since when there has been no drive to bring up for the first time.
    sought_ns: Option<u64>,
    lost_since_ns: u64,
    limits: SetpointLimits,
    counted: BusCounters,
    health: Health,
    latched: bool,
    bring_ups: BringUpLimit,
    retry_ns: u64,
    complaints: Complaints,
    panicked_ns: u64,
}

impl Drive {
    /// An activity in state *created*. Its links have `clock`.
    #[must_use]
    pub fn new(
        port: Port,
        settings: Settings,
        symbols: DriveSymbols,
        (open_link, clock): (OpenLink, Arc<dyn Clock>),
        log: LogSender,
    ) -> Self {
        let ramp = WheelRamp::new(settings.stop_deceleration_rad_s2);
        let limits = SetpointLimits {
            max_wheel_speed_rad_s: settings.max_wheel_speed_rad_s as f32,
            max_current_a: settings.drive_current_a.max(settings.stop_current_a),
        };
        let bring_ups = BringUpLimit::new(settings.bring_ups_per_minute);
        Self {
            port,
            settings,
            symbols,
            open_link,
            clock,
            log,
            bus: None,
            ramp,
            wanted: Stamped::default(),
            inputs: Inputs::default(),
            status: DriveStatus::default(),
            encoder_epoch: 0,
            answered_ns: 0,
            sought_ns: None,
            lost_since_ns: 0,
            limits,
            counted: BusCounters::default(),
            health: Health::default(),
            latched: false,
            bring_ups,
            retry_ns: 0,
            complaints: Complaints::default(),
            panicked_ns: 0,
        }
    }

    /// Brings the bus up. The real-time rules are suspended: the activity is in state *configuring*.
    fn bring_up(&mut self, now_ns: u64) {
        if now_ns < self.retry_ns {
            return;
        }
        // The old socket goes first, and what was counted on it is kept.
        if let Some(bus) = self.bus.take() {
            self.counted = self.total(bus.counters());
        }
        if self.too_many_bring_ups(now_ns) {
            return;
        }
        let result = (self.open_link)().and_then(|link| {
            Bus::bring_up(link, &self.settings.expectation, BRING_UP)
                .map_err(|error| error.to_string())
        });
        match result {
            Ok(bus) => {
                let identity = bus.identity();
                self.judge_return(identity.had_address);
                self.log.info(format!(
                    "bus is up on {}: {}, serial {}",
                    identity.link, identity.name, identity.serial
                ));
                // Without power its encoders forgot how far they had counted.
                self.encoder_epoch += u64::from(!identity.had_address);
                self.bus = Some(bus);
                self.ramp.reset();
                self.answered_ns = self.clock.now_ns();
                self.lost_since_ns = 0;
                self.health = Health::default();
                self.status.bring_ups += 1;
                self.complaints.forget();
                self.port.clear(Fault::BusLost);
                self.port.step(LifeCycleEvent::Configured);
            }
            Err(complaint) => {
                self.sought_ns.get_or_insert(now_ns);
                self.complaints
                    .say(&self.log, "bus cannot be brought up", complaint);
                self.port.raise(Fault::BusLost, 0.0);
            }
        }
        self.retry_ns = self.clock.now_ns() + RETRY_NS;
    }

    /// A drive that was without power, or gone for long, does not go on by itself: somebody may have released an emergency
    /// stop. One that is switched on together with this computer may take a while.
    fn judge_return(&mut self, kept_power: bool) {
        let now_ns = self.clock.now_ns();
        let (gone_since_ns, may_take_ns) = if self.status.bring_ups == 0 {
            (self.sought_ns.unwrap_or(now_ns), SWITCHED_ON_NS)
        } else {
            (self.answered_ns, if kept_power { GONE_NS } else { 0 })
        };
        let gone_ns = now_ns.saturating_sub(gone_since_ns);
        if gone_ns > may_take_ns {
            self.latch(Fault::DriveReturned, gone_ns as f64 * 1e-9);
        }
    }

    /// Whether an operator is needed before another bring-up.
    fn too_many_bring_ups(&mut self, now_ns: u64) -> bool {
        if self.status.bring_ups == 0 || !self.complaints.is_empty() {
            return false; // the first one, and further attempts at the same one, do not count
        }
        let too_many = !self.bring_ups.note(now_ns);
        if too_many {
            self.port
                .raise(Fault::BringUpLimit, self.bring_ups.per_minute() as f64);
            self.retry_ns = u64::MAX;
        }
        too_many
    }

    /// The operator has seen to the faults. One whose cause is still there stays.
    fn reset(&mut self) {
        if self.bus.is_none() || self.health.is_good() {
            self.latched = false;
            for fault in [
                Fault::BusVoltage,
                Fault::DriveFault,
                Fault::MotorsOff,
                Fault::DriveReturned,
            ] {
                self.port.clear(fault);
            }
        }
        if self.bus.is_none() {
            // A drive that comes at once is the one that the operator expects.
            self.answered_ns = self.clock.now_ns();
        }
        self.port.clear(Fault::BringUpLimit);
        self.bring_ups.forget();
        self.retry_ns = 0;
    }

    /// The wheel speeds to send in this cycle.
    fn decide(&mut self, now_ns: u64) -> WheelSpeeds {
        let age_ns = now_ns.saturating_sub(self.wanted.stamp_ns);
        let running = self.port.running();
        let stale = running && age_ns > self.settings.setpoint_timeout_ns;
        self.port.set(
            Fault::SetpointStale,
            stale,
            age_ns as f64 / MILLISECOND_NS as f64,
        );
        if !running || stale || self.latched || has_panicked() {
            self.ramp.step(now_ns)
        } else {
            let limit = self.settings.max_wheel_speed_rad_s;
            self.ramp.follow(now_ns, self.wanted.value.speeds, limit)
        }
    }

    /// One exchange with the drive.
    fn exchange(&mut self, now_ns: u64, speeds: WheelSpeeds) -> Result<(), ExchangeError> {
        let Some(bus) = &mut self.bus else {
            return Err(ExchangeError::Lost);
        };
        let enabled = matches!(
            self.port.state(),
            LifeCycleState::Running | LifeCycleState::Paused
        );
        let current_a = if speeds == WheelSpeeds::STANDING {
            self.settings.stop_current_a
        } else {
            self.settings.drive_current_a
        };
        let setpoint = if enabled {
            Setpoint::Speeds { speeds, current_a }
        } else {
            Setpoint::Off
        };
        let outputs = setpoint.to_outputs(&self.limits).to_bytes();
        let mut bytes = [0; kelo::INPUTS_BYTES];
        bus.exchange(&outputs, &mut bytes, now_ns + self.settings.deadline_ns)?;
        self.inputs = Inputs::from_bytes(&bytes);
        self.health.told_to_power = enabled;
        self.status.sent_left_rad_s = speeds.left_rad_s;
        self.status.sent_right_rad_s = speeds.right_rad_s;
        Ok(())
    }

    /// Raises a fault after which the robot stands until an operator resets it.
    fn latch(&mut self, fault: Fault, figure: f64) {
        self.latched = true;
        self.port.raise(fault, figure);
    }

    /// Decides and exchanges.
    fn turn(&mut self, now_ns: u64) {
        if self.bus.is_none() {
            return;
        }
        // In the turn that brought the bus up, the turn's own time is long past.
        let now_ns = now_ns.max(self.answered_ns);
        let setpoint = self.decide(now_ns);
        match self.exchange(now_ns, setpoint) {
            Ok(()) => self.accept(now_ns),
            Err(ExchangeError::NotOperational { .. } | ExchangeError::Io { .. }) => {
                self.lose_bus(now_ns)
            }
            // Counted from the first frame that was lost: a thread that was late has lost none.
            Err(_) if self.lost_since_ns == 0 => self.lost_since_ns = now_ns,
            Err(_) if now_ns - self.lost_since_ns > self.settings.hold_ns => self.lose_bus(now_ns),
            Err(_) => {} // hold: the drive keeps its last setpoint
        }
    }

    /// Takes in what an exchange brought.
    fn accept(&mut self, now_ns: u64) {
        self.answered_ns = now_ns;
        self.lost_since_ns = 0;
        let voltage = self.settings.voltage;
        let found = self.health.judge(&self.inputs, voltage, now_ns);
        if let Some((fault, figure)) = found {
            self.latch(fault, figure);
        }
        let encoders = encoders(
            &Feedback::from(&self.inputs),
            self.settings.pivot_zero_rad,
            self.encoder_epoch,
        );
        self.symbols.encoders.write(now_ns, &encoders);
    }

    /// Counters of this bus and those before it.
    fn total(&self, counters: BusCounters) -> BusCounters {
        BusCounters {
            cycles: self.counted.cycles + counters.cycles,
            lost_frames: self.counted.lost_frames + counters.lost_frames,
            wkc_errors: self.counted.wkc_errors + counters.wkc_errors,
            ..counters
        }
    }

    /// The bus has been gone for too long: outputs are off, and it is brought up again.
    fn lose_bus(&mut self, now_ns: u64) {
        self.port.raise(
            Fault::BusLost,
            now_ns.saturating_sub(self.answered_ns) as f64 / MILLISECOND_NS as f64,
        );
        self.port.clear(Fault::SetpointStale); // nothing is sent any more
        self.port.step(LifeCycleEvent::Fault);
        self.retry_ns = 0;
    }
}

impl Activity for Drive {
    fn name(&self) -> &'static str {
        "drive"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, _now_ns: u64) {
        self.wanted = self.symbols.setpoints.read();
    }

    fn coordinate(&mut self, _now_ns: u64) {
        while let Some(command) = self.port.next_command() {
            if command == Command::Reset {
                self.reset();
            }
        }
    }

    fn configure(&mut self, now_ns: u64) {
        self.bring_up(now_ns);
    }

    fn compute(&mut self, now_ns: u64) {
        self.turn(now_ns);
    }

    fn rest(&mut self, now_ns: u64) {
        // With motors off the bus stays in operation, unless it is being brought up.
        if !self.port.state().is_configuring() {
            self.turn(now_ns);
        }
        if self.port.state() == LifeCycleState::Stopped
            && let Some(mut bus) = self.bus.take()
        {
            // Stopped, so the real-time rules are over. The motors are off already; a drive that does not answer any
            // more has its watchdog.
            guard::relaxed(move || {
                let _ = bus.shut_down(now_ns + SHUT_DOWN_NS);
            });
        }
    }

    fn communicate_out(&mut self, now_ns: u64) {
        if let Some(bus) = &self.bus {
            let counters = self.total(bus.counters());
            self.status.cycles = counters.cycles;
            self.status.lost_frames = counters.lost_frames;
            self.status.wkc_errors = counters.wkc_errors;
        }
        let operational = self.bus.is_some() && self.port.state() != LifeCycleState::Configuring;
        self.status.operational = u64::from(operational);
        let follows = operational && self.port.running() && !self.latched && !has_panicked();
        self.status.follows = u64::from(follows);
        self.status.status =
            u64::from(self.inputs.status1.0) | u64::from(self.inputs.status2) << 16;
        self.status.bus_voltage_v = f64::from(self.inputs.bus_voltage_v);
        self.status.input_current_a = f64::from(self.inputs.input_current_a);
        self.symbols.status.write(now_ns, &self.status);
        self.port.publish(now_ns);
    }
}

impl RobotActivity for Drive {
    fn after_panic(&mut self, now_ns: u64) -> bool {
        if self.panicked_ns == 0 {
            self.panicked_ns = now_ns;
        }
        let setpoint = self.ramp.step(now_ns);
        // A lost frame is tried again in the next step; the time limit ends it.
        let _ = self.exchange(now_ns, setpoint);
        let standing = setpoint == WheelSpeeds::STANDING;
        (standing && self.ramp.standing_for(now_ns) > 200 * MILLISECOND_NS)
            || now_ns - self.panicked_ns > AFTER_PANIC_NS
            || self.bus.is_none()
    }
}
