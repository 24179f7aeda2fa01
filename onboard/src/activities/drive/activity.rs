//! The activity: its event loop around the bus, and what it judges of the drive.

use std::sync::Arc;

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::symbols::Stamped;
use description::wheels::WheelSpeeds;
use drivers::ethercat::{Bus, BusCounters, ExchangeError};
use drivers::kelo::{self, Feedback, Inputs, Setpoint, SetpointLimits};
use skills::drive::Obedience;

use super::health::Health;
use super::holding::Holding;
use super::ramp::WheelRamp;
use super::settings::{OpenLink, SHUT_DOWN_NS, Settings};
use super::wheels::Wheels;
use crate::activities::per_minute::PerMinute;
use crate::activities::port::{Command, Port, Report};
use crate::activities::robot_activity::RobotActivity;
use crate::realtime::clock::{Clock, MILLISECOND_NS, SECOND_NS};
use crate::realtime::guard;
use crate::realtime::log::{Complaints, LogSender};
use crate::realtime::panic::Panicked;
use crate::symbols::faults::Fault;
use crate::symbols::values::{DriveStatus, Encoders, WheelSetpoints};
use crate::symbols::wiring::DriveSymbols;

/// How long a robot may take to stop after its fieldbus thread has panicked.
const AFTER_PANIC_NS: u64 = 2 * SECOND_NS;

/// The activity.
pub struct Drive {
    pub(super) port: Port,
    pub(super) settings: Settings,
    pub(super) symbols: DriveSymbols,
    pub(super) open_link: OpenLink,
    pub(super) clock: Arc<dyn Clock>,
    pub(super) log: LogSender,
    pub(super) bus: Option<Bus>,
    pub(super) ramp: WheelRamp,
    pub(super) wanted: Stamped<WheelSetpoints>,
    pub(super) inputs: Inputs,
    /// When the drive sampled its sensors last, by its own clock.
    pub(super) sensed_ns: u64,
    pub(super) wheels: Wheels,
    pub(super) encoders: Encoders,
    pub(super) status: DriveStatus,
    /// How often the drive was found to have lost power.
    pub(super) encoder_epoch: u64,
    pub(super) answered_ns: u64,
    /// Since when there has been no drive to bring up for the first time.
    pub(super) sought_ns: Option<u64>,
    /// The robot goes on from where another process has left it: only a drive that kept its power, and is there at once, may follow.
    pub(super) goes_on: bool,
    /// Why the last exchange brought nothing.
    pub(super) trouble: Option<ExchangeError>,
    /// A bring-up since the bus was up last has found the drive without its address: it had no power meanwhile.
    pub(super) lost_power: bool,
    pub(super) lost_since_ns: u64,
    pub(super) limits: SetpointLimits,
    pub(super) counted: BusCounters,
    pub(super) health: Health,
    pub(super) obedience: Obedience,
    pub(super) holding: Holding,
    /// Wheels do not obey.
    pub(super) disobeys: bool,
    /// The drive reports a fault, a bad voltage, or an emergency stop.
    pub(super) ails: bool,
    /// It is left to stop by itself, until an operator resets it.
    pub(super) emergency: bool,
    /// It was said which encoder moves otherwise than its wheel's speed.
    pub(super) contradicted: bool,
    pub(super) latched: bool,
    pub(super) bring_ups: PerMinute,
    pub(super) retry_ns: u64,
    /// The bus was brought up in the cycle before.
    pub(super) is_just_up: bool,
    pub(super) complaints: Complaints,
    /// Any part of the robot's program has.
    panicked: Panicked,
    pub(super) panicked_ns: u64,
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
        let bring_ups = PerMinute::new(settings.bring_ups_per_minute);
        let obedience_rad = settings.obedience_rad;
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
            sensed_ns: 0,
            wheels: Wheels::default(),
            encoders: Encoders::default(),
            status: DriveStatus::default(),
            encoder_epoch: 0,
            answered_ns: 0,
            sought_ns: None,
            goes_on: false,
            trouble: None,
            lost_power: false,
            lost_since_ns: 0,
            limits,
            counted: BusCounters::default(),
            health: Health::default(),
            obedience: Obedience::new(obedience_rad),
            holding: Holding::default(),
            disobeys: false,
            ails: false,
            emergency: false,
            contradicted: false,
            latched: false,
            bring_ups,
            retry_ns: 0,
            is_just_up: false,
            complaints: Complaints::default(),
            panicked: Panicked::default(),
            panicked_ns: 0,
        }
    }

    /// Stops the robot when a part of its program has panicked, which this flag tells.
    #[must_use]
    pub fn heeding(self, panicked: Panicked) -> Self {
        Self { panicked, ..self }
    }

    /// The robot goes on from where another process has left it, if `goes_on`: only a drive that kept its power, and is there at the first
    /// attempt, may follow.
    #[must_use]
    pub fn going_on(mut self, goes_on: bool) -> Self {
        self.goes_on = goes_on;
        self
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
        if !self.may_follow() || stale {
            self.ramp.stop(now_ns, self.encoders.speeds)
        } else {
            let limit = self.settings.max_wheel_speed_rad_s;
            self.ramp.follow(now_ns, self.wanted.value.speeds, limit)
        }
    }

    /// Whether setpoints are for the wheels.
    fn may_follow(&self) -> bool {
        let ails = self.latched || self.panicked.is_raised();
        self.port.running() && !ails && self.health.senses()
    }

    /// One exchange with the drive.
    fn exchange(&mut self, now_ns: u64, speeds: WheelSpeeds) -> Result<(), ExchangeError> {
        let powers = self.powers();
        let Some(bus) = &mut self.bus else {
            return Err(ExchangeError::Lost);
        };
        let (found, angles) = (self.encoders.speeds, self.encoders.angles);
        let stands = self.holding.relaxes(speeds, found, angles, now_ns);
        // A stop is commanded as long as the wheels obey. Once they stand, nothing that the drive does by itself may move them.
        self.emergency |= self.settings.emergency_bits && (self.disobeys || self.ails && stands);
        let current_a = if stands {
            self.settings.stop_current_a
        } else {
            self.settings.drive_current_a
        };
        let setpoint = if !powers {
            Setpoint::Off
        } else if self.emergency {
            Setpoint::Emergency { current_a }
        } else {
            Setpoint::Speeds { speeds, current_a }
        };
        let outputs = setpoint.to_outputs(&self.limits).to_bytes();
        let mut bytes = [0; kelo::INPUTS_BYTES];
        bus.exchange(&outputs, &mut bytes, now_ns + self.settings.deadline_ns)?;
        self.inputs = Inputs::from_bytes(&bytes);
        // Emergency bits take the motors' power: that it is gone then is no emergency stop.
        self.health.told_to_power = matches!(setpoint, Setpoint::Speeds { .. });
        self.status.sent_left_rad_s = speeds.left_rad_s;
        self.status.sent_right_rad_s = speeds.right_rad_s;
        Ok(())
    }

    /// The motors have power, as soon as there is a bus: a robot that waits for its lidar is held too, and only then an emergency stop
    /// shows that is pressed meanwhile.
    pub(super) fn powers(&self) -> bool {
        matches!(
            self.port.state(),
            LifeCycleState::Ready | LifeCycleState::Running | LifeCycleState::Paused
        )
    }

    /// Raises a fault after which the robot stands until an operator resets it.
    pub(super) fn latch(&mut self, fault: Fault, figure: f64) {
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
        let exchanged = self.exchange(now_ns, setpoint);
        self.trouble = exchanged.err();
        match exchanged {
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
        if let Some((fault, figure)) = self.health.judge(&self.inputs, voltage, now_ns) {
            self.ails |= fault != Fault::DriveStalled;
            self.latch(fault, figure);
        }
        let stamp_ns = std::mem::replace(&mut self.sensed_ns, self.inputs.sensor_stamp_ns);
        // A sample that was seen before says nothing of the wheels: with a new time it would say that they stand.
        if stamp_ns != self.sensed_ns {
            self.sense(now_ns);
            self.symbols.encoders.write(now_ns, &self.encoders);
        }
    }

    /// Takes in a new sample of the drive's sensors.
    fn sense(&mut self, now_ns: u64) {
        let feedback = Feedback::from(&self.inputs);
        let (zero_rad, epoch) = (self.settings.pivot_zero_rad, self.encoder_epoch);
        self.encoders = self.wheels.read(&feedback, zero_rad, epoch, now_ns);
        if let Some(what) = self.wheels.contradict() {
            if !std::mem::replace(&mut self.contradicted, true) {
                self.port.report(Report::Contradicted(what));
            }
            self.latch(Fault::EncoderBroken, what.apart_rad);
        }
        self.judge_obedience(feedback.enabled, now_ns);
    }

    /// Whether the wheels do what they are told, as long as their motors have power.
    fn judge_obedience(&mut self, powered: bool, now_ns: u64) {
        if !self.health.told_to_power || self.disobeys {
            self.obedience.forget();
            return;
        }
        // If that lasts it is a fault of its own; what the wheels did before counts on.
        if !powered {
            return;
        }
        let told = WheelSpeeds::new(self.status.sent_left_rad_s, self.status.sent_right_rad_s);
        let (found, angles) = (self.encoders.speeds, self.encoders.angles);
        if let Some(what) = self.obedience.judge(told, found, angles, now_ns) {
            self.disobeys = true;
            self.port.report(Report::Disobeyed(what));
            self.latch(Fault::WheelsDisobey, what.beyond_rad);
        }
    }

    /// Counters of this bus and those before it.
    pub(super) fn total(&self, counters: BusCounters) -> BusCounters {
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
        // Whoever reset the robot while the bus was being brought up knew nothing of what was found then.
        let is_just_up = std::mem::take(&mut self.is_just_up);
        while let Some(command) = self.port.next_command() {
            if command == Command::Reset && !is_just_up {
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
        self.status.follows = u64::from(operational && self.may_follow());
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
        let setpoint = self.ramp.stop(now_ns, self.encoders.speeds);
        // A lost frame is tried again in the next step; the time limit ends it.
        let _ = self.exchange(now_ns, setpoint);
        (setpoint == WheelSpeeds::STANDING && self.ramp.standing_for(now_ns) > 200 * MILLISECOND_NS)
            || now_ns - self.panicked_ns > AFTER_PANIC_NS
            || self.bus.is_none()
    }
}
